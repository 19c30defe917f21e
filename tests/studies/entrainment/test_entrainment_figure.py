"""The figure of ``entrainment``: phases stable and not, bands, runs; drawn from the Dataset alone."""

from __future__ import annotations

import io
import json
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes

from wucht import Entrainment, draw, load_machine, run


def answered(name: str, **table: Any) -> xr.Dataset:
    machine = load_machine(f"sperling-vibration/{name}")
    return run(Entrainment.from_table(table), machine)


@pytest.fixture(scope="module")
def shaken() -> xr.Dataset:
    return answered("figure-2a", points=9, resolution=1e-2)


@pytest.fixture(scope="module")
def exciters() -> xr.Dataset:
    start = {"e1": {"speed": 12.0}, "e2": {"angle": 1.0, "speed": 12.0}}
    return answered("self-synchronisation-soft", points=7, resolution=0.1, start=start)


def labels(axis: Axes) -> list[str]:
    legend = axis.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def lines(axis: Axes, style: str) -> list[Any]:
    return [drawn for drawn in axis.get_lines() if drawn.get_linestyle() == style and len(drawn.get_xdata()) > 2]


def test_panels_and_units(shaken: xr.Dataset) -> None:
    figure = draw(shaken)
    phase, speed = figure.axes
    assert phase.get_ylabel() == "phase to the vibration (\u00b0)"
    assert speed.get_ylabel() == "mean speed (rad/s)"
    assert speed.get_xlabel() == "no-load speed of the drive (rad/s)"
    assert phase.get_ylim() == pytest.approx((-180, 180))
    assert labels(phase) == [
        "averaged equations, stable", "averaged equations, unstable", "full equations, periodic", "band of existence",
        "reached from the start", "this machine",
    ]  # fmt: skip
    assert labels(speed) == [
        "run: entrained", "run: not entrained", "frequency of the vibration", "speed without vibration",
    ]  # fmt: skip
    figure.savefig(io.BytesIO())


def test_stable_solid_unstable_dashed(shaken: xr.Dataset) -> None:
    phase, _ = draw(shaken).axes
    (solid,) = lines(phase, "-")
    (dashed,) = lines(phase, "--")
    assert np.nanmax(np.abs(solid.get_ydata())) <= 90 + 1e-6
    assert np.nanmin(np.abs(dashed.get_ydata())) >= 85  # one point of the stable part, so that the lines meet
    assert np.nanmax(np.abs(dashed.get_ydata())) == pytest.approx(180)  # up to the border of the panel


def test_bands(shaken: xr.Dataset) -> None:
    summary = shaken.wucht.summary
    phase, _ = draw(shaken).axes
    (shade,) = phase.patches
    box = shade.get_extents().transformed(phase.transData.inverted())
    assert [box.x0, box.x1] == pytest.approx(summary["existence_band"])
    edges = sorted(x.get_xdata()[0] for x in phase.get_lines() if x.get_linestyle() == "-.")
    assert edges == pytest.approx(summary["band_from_rest"])


@pytest.mark.slow
def test_exciters_are_cut_where_they_are_not_and_others_are_grey(exciters: xr.Dataset) -> None:
    phase, speed = draw(exciters).axes
    assert phase.get_ylim() == pytest.approx((0, 360))  # around 180 degrees, above the resonance
    assert phase.get_ylabel() == "phase (\u00b0)"
    assert speed.get_xlabel() == "detuning: difference of the no-load speeds (rad/s)"
    colours = {x.get_color() for x in lines(phase, "-")}
    assert len(colours) == 2
    assert "others, stable" in labels(phase)
    assert "averaged equations, stable" in labels(speed)


def test_a_result_without_bands_is_drawn(shaken: xr.Dataset) -> None:
    """Of an interrupted study, and of a machine without averaged equations."""
    bare = shaken.isel(point=slice(0, 0), orbit=slice(0, 0))
    summary = shaken.wucht.summary | dict.fromkeys(("existence_band", "band_from_rest", "range", "branch"))
    bare.attrs = shaken.attrs | {"summary": json.dumps(summary), "finished": 0, "sentence": "the study was interrupted"}
    figure = draw(bare)
    assert "the study was interrupted" in figure.get_suptitle()
    assert not figure.axes[0].patches
    figure.savefig(io.BytesIO())


def test_open_bands_are_named_and_shaded_to_the_border(shaken: xr.Dataset) -> None:
    summary = shaken.wucht.summary | {"existence_band": [5.0, None], "band_from_rest": [None, 7.0]}
    changed = shaken.copy()
    changed.attrs = shaken.attrs | {"summary": json.dumps(summary)}
    figure = draw(changed)
    assert "exists above 5 rad/s (averaged equations); reached from the start below 7 rad/s" in figure.get_suptitle()
    box = figure.axes[0].patches[0].get_extents().transformed(figure.axes[0].transData.inverted())
    assert [box.x0, box.x1] == pytest.approx([5.0, summary["range"][1]])


def on_branch(result: xr.Dataset, phases: list[float], stable: list[int], branch: int = 0) -> xr.Dataset:
    """Three motions of the averaged equations, at 0, 1 and 2 rad/s."""
    some = {"value": [0.0, 1.0, 2.0], "stable": stable, "branch": [0, 0, branch]}
    changed = result.isel(point=slice(3)).assign(phase=result.phase[:, :3].copy(data=[phases]))
    return changed.assign({name: ("point", values, result[name].attrs) for name, values in some.items()})


@pytest.mark.parametrize(
    ("phases", "stable", "goes_on", "share"),
    [
        ([3.0, -3.0, -2.0], [1, 1, 1], True, 0.5),
        ([-2.5, 3.0, 2.0], [1, 1, 1], True, (math.pi - 2.5) / (2 * math.pi - 5.5)),  # downwards
        # only where both points beside it are drawn
        ([3.0, -3.0, -2.0], [1, 1, 0], True, 0.5),
        ([3.0, -3.0, -2.0], [0, 1, 1], False, 0.5),
        ([3.0, -3.0, -2.0], [1, 0, 1], False, 0.5),
    ],
)
def test_a_phase_that_wraps_goes_to_the_border(
    shaken: xr.Dataset, phases: list[float], stable: list[int], goes_on: bool, share: float
) -> None:
    axis = draw(on_branch(shaken, phases, stable)).axes[0]
    (line,) = [x for x in axis.get_lines() if x.get_label() == "averaged equations, stable"]
    assert line.get_xdata() == pytest.approx([0.0, share, share, share, 1.0, 2.0])
    border = [180.0, math.nan, -180.0] if phases[0] > 0 else [-180.0, math.nan, 180.0]
    shown = np.asarray(line.get_ydata())
    assert shown[1:4] == pytest.approx(border if goes_on else [math.nan] * 3, nan_ok=True)
    assert shown[[0, 4, 5]] == pytest.approx(np.where(stable, np.degrees(phases), math.nan), nan_ok=True)


@pytest.mark.parametrize(
    ("phases", "stable", "orbit", "top"),
    [
        ([0.1, 3.0, 3.1], [1, 0, 1], 0.1, 180),  # around 0
        ([3.0, 0.1, 0.2], [1, 0, 1], 3.0, 360),  # around 180 degrees
        ([0.1, 0.1, 0.1], [0, 0, 1], 3.0, 360),
        ([3.0, 3.0, 3.0], [0, 0, 1], 0.1, 180),
    ],
)
def test_where_the_circle_of_phases_is_cut(
    shaken: xr.Dataset, phases: list[float], stable: list[int], orbit: float, top: float
) -> None:
    """Of rotors without a vibration: away from the stable phases of the main branch and from those of locked motions."""
    bare = on_branch(shaken, phases, stable, branch=1).isel(orbit=slice(1))
    bare = bare.assign(orbit_phase=bare.orbit_phase.copy(data=[[orbit]])).assign_attrs(
        {name: value for name, value in shaken.attrs.items() if name != "frequency"}
    )
    del bare.attrs["frequency"]
    assert draw(bare).axes[0].get_ylim() == pytest.approx((top - 360, top))


def test_several_bodies_have_lines_of_their_own(shaken: xr.Dataset) -> None:
    other = shaken.assign(phase=shaken.phase - 0.5).assign_coords(body=["e3"])
    both = xr.concat([shaken, other], "body", data_vars="minimal", combine_attrs="override")
    axis = draw(both).axes[0]
    shown = {str(x.get_label()): np.asarray(x.get_ydata()) for x in axis.get_lines()}
    stable = shaken.stable.values.astype(bool)
    for name, ahead in (("rotor", 0.0), ("e3", -0.5)):
        heights = shown[f"{name}: averaged, stable"]
        expected = np.degrees(shaken.phase.values[0][stable] + ahead)
        assert {round(h, 6) for h in expected if abs(h) < 180} <= {round(h, 6) for h in heights if math.isfinite(h)}
        assert len(shown[f"{name}: full, periodic"]) == shaken.sizes["orbit"]


def test_an_interrupted_study_is_drawn_as_far_as_it_has_come(shaken: xr.Dataset) -> None:
    """A single run: a unit to either side of it."""
    own = shaken.isel(point=slice(0, 0), orbit=slice(0, 0), run=shaken.run_value.values == 5.5)
    none = dict.fromkeys(("existence_band", "band_from_rest", "range", "branch"))
    own.attrs = shaken.attrs | {"summary": json.dumps(shaken.wucht.summary | none), "finished": 0}
    assert draw(own).axes[0].get_xlim() == pytest.approx((4.44, 6.56))
    away = own.assign_attrs(summary=json.dumps(own.wucht.summary | {"value": 3.5}))
    assert draw(away).axes[0].get_xlim() == pytest.approx((3.44, 5.56))


def test_speeds_of_a_clockwise_rotor_are_drawn_as_sizes(shaken: xr.Dataset) -> None:
    """The speed that the drive alone would reach is compared with the frequency, whichever way the rotor turns."""
    free = np.linspace(5.0, 9.0, shaken.sizes["run"])
    changed = shaken.assign(free_speed=shaken.free_speed.copy(data=-free))
    (line,) = [line for line in draw(changed).axes[1].get_lines() if line.get_label() == "speed without vibration"]
    assert np.asarray(line.get_ydata()) == pytest.approx(free)
