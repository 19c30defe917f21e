"""The figures of sweeps: panels, labels, marks."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.patches import ArrowStyle

from wucht import Sweep
from wucht.files.catalogue import load_machine
from wucht.studies.runner import draw, run

FIGURE_5 = "sperling-vibration/figure-5"


@pytest.fixture(scope="module")
def swept() -> xr.Dataset:
    return run(Sweep(along="drive.no_load_speed", range=(8.0, 11.0), rate=0.01, jump_tolerance=1e-3), load_machine(FIGURE_5))


def _labels(axis: object) -> list[str]:
    return [t.get_text() for t in axis.get_legend().get_texts()]  # type: ignore[attr-defined]


def test_a_sweep_shows_both_ways_and_its_jumps(swept: xr.Dataset) -> None:
    speed, amplitude = draw(swept).axes
    assert speed.get_ylabel() == "mean speed (rad/s)"
    assert amplitude.get_ylabel() == "amplitude of the axis (mm)"
    assert amplitude.get_xlabel() == "no-load speed of the drive (rad/s)"
    assert amplitude.get_xlim() == (8.0, 11.0)
    assert _labels(speed) == ["rising", "falling", "end of a branch", "no-load speed"]
    assert _labels(amplitude) == ["rising", "falling", "end of a branch"]
    assert len(speed.texts) == len(amplitude.texts) == 2  # an arrow a jump


def test_an_arrow_leads_from_the_end_of_a_branch_to_where_the_machine_lands(swept: xr.Dataset) -> None:
    speed, amplitude = draw(swept).axes
    ends = {
        speed: (swept.jump_from.values, swept.jump_to.values),
        amplitude: (1e3 * swept.jump_from_amplitude.values, 1e3 * swept.jump_to_amplitude.values),  # mm
    }
    for axis, (before, after) in ends.items():
        arrows = [(*arrow.xyann, *arrow.xy) for arrow in axis.texts]
        at = swept.jump_value.values
        assert np.array(arrows) == pytest.approx(np.column_stack([at, before, at, after]))
        assert all(isinstance(arrow.arrow_patch.get_arrowstyle(), ArrowStyle.CurveFilledB) for arrow in axis.texts)  # type: ignore[attr-defined]


def test_the_title_of_a_sweep_names_the_jumps(swept: xr.Dataset) -> None:
    heading = draw(swept)._suptitle.get_text()  # type: ignore[attr-defined]
    up, down = swept.jump_value.values
    says = f"it jumps at no-load speed of the drive = {up:.4g} rad/s (rising) and {down:.4g} rad/s (falling)"
    assert heading.endswith(f"\n{says}") and heading.count("\n") == 1


def test_an_interrupted_sweep_is_drawn() -> None:
    def stop(_share: float, _what: str) -> None:
        raise KeyboardInterrupt

    result = run(Sweep(along="drive.no_load_speed", range=(8.0, 11.0)), load_machine(FIGURE_5), progress=stop)
    assert draw(result)._suptitle.get_text().endswith("\nthe sweep was interrupted")  # type: ignore[attr-defined]


def test_the_band_about_the_speed_is_its_modulation(swept: xr.Dataset) -> None:
    speed, _ = draw(swept).axes
    bands = [collection.get_paths()[0].get_extents() for collection in speed.collections]
    expected = [
        (ramp.value.min(), ramp.min_speed.min(), ramp.value.max(), ramp.max_speed.max())
        for ramp in (swept.sel(direction=way) for way in swept.direction.values)
    ]
    assert [band.extents.tolist() for band in bands] == [pytest.approx([float(x) for x in box]) for box in expected]
