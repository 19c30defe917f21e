"""What a figure of phase portraits shows."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import wucht
from wucht.files.user_system import equations_from

TILE = 2 * np.pi


@pytest.fixture(scope="module")
def cylinder() -> xr.Dataset:
    machine = wucht.load_machine("drozdetskaya-2020/table-5.1")
    spec = wucht.PhasePortrait(
        together=True, trajectories=3, along="u", values=[1.0, 3.0, 7.0], ranges={"speed": (0.4, 2.2)}, nullclines=True
    )
    return wucht.run(spec, machine)


def test_each_fixed_point_is_drawn_in_every_turn(cylinder: xr.Dataset) -> None:
    """Filled where stable, half filled where only the section is, a cross at the saddle; at both turns of the phase."""
    drawn = wucht.draw(cylinder)
    first, second, third = (a for a in drawn.axes if a.get_visible())
    for axis, style, count in ((first, "full", 2), (third, "bottom", 2)):
        filled = [x for x in axis.lines if x.get_marker() == "o" and x.get_fillstyle() == style]
        assert len(filled) == count
        at = sorted(float(x.get_xdata()[0]) for x in filled)
        assert np.diff(at) == pytest.approx([TILE])
        assert len([x for x in axis.lines if x.get_marker() == "x"]) == 2
    assert not [x for x in second.lines if x.get_marker() in ("o", "x")]
    assert first.get_xlim() == pytest.approx((0, 4 * np.pi)) and first.get_ylim() == pytest.approx((0.4, 2.2))
    assert [t.get_text() for t in first.get_xticklabels()] == ["0", "π", "2π", "3π", "4π"]
    assert third.get_xlabel() == "phase of p1, p2 $\\psi$ (rad)" and first.get_ylabel() == "speed of rotor $\\omega$"


@pytest.mark.slow
def test_manifolds_are_told_apart_by_colour_and_dashes(cylinder: xr.Dataset) -> None:
    drawn = wucht.draw(cylinder)
    axis = drawn.axes[0]
    bold = {(x.get_color(), x.is_dashed()) for x in axis.lines if x.get_linewidth() > 1.5 and len(x.get_xdata()) > 1}
    assert len(bold) == 2 and {dashed for _, dashed in bold} == {True, False}
    names = [t.get_text() for t in drawn.legends[0].get_texts()]
    assert names == [
        "stable fixed point", "stable within the section only", "saddle", "unstable manifold: leaves the saddle",
        "stable manifold: leads to the saddle", "closed curve, stable", "trajectory", "nullcline of psi", "nullcline of speed",
    ]  # fmt: skip


def test_arrows_point_the_way_of_time() -> None:
    """x' = 1: every arrow points to the right; those of both manifolds of a saddle away from it and to it."""
    own = equations_from({"states": {"x": "x", "y": "-y"}})
    spec = wucht.PhasePortrait(trajectories=[{"x": 0.3, "y": 0.3}], ranges={"x": (-1, 1), "y": (-1, 1)})
    axis = wucht.draw(wucht.run(spec, own)).axes[0]
    arrows = [(np.array(t.xyann), np.array(t.xy)) for t in axis.texts if t.arrow_patch is not None]
    assert len(arrows) == 5
    for tail, head in arrows:
        (x, y), (dx, dy) = tail, head - tail
        assert dx * x >= 0 and dy * y <= 0 and abs(dx) + abs(dy) > 0


@pytest.mark.slow
def test_a_file_alone_is_drawn(cylinder: xr.Dataset, tmp_path: object) -> None:
    own = equations_from({"states": {"x": "1", "y": "-y"}})
    spec = wucht.PhasePortrait(trajectories=2, ranges={"x": (-1, 1), "y": (-1, 1)})
    nothing = wucht.run(spec, own)
    assert nothing.sizes["fixed_point"] == 0 and len(wucht.draw(nothing).axes) == 1
    path = f"{tmp_path}/result.nc"
    cylinder.to_netcdf(path, engine="h5netcdf")
    assert len(wucht.draw(wucht.load(path)).axes) == len(wucht.draw(cylinder).axes)
