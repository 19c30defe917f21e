"""A motion law that is written down: its derivatives, harmonics and restrictions in closed form, in words and in the figure."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

import wucht
from wucht.cams.laws.synthesis import Band, Cap, Restriction
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.cams.tables.motion_law import SeriesMotionLaw
from wucht.numerics.fourier_series import FourierSeries

INF = math.inf
NAMES = ("position", "velocity", "acceleration", "jerk")
# -20 mm - 8 mm cos phi + 1 mm sin 2 phi
SERIES = FourierSeries.of(-0.02, [-0.008, 0.0], [0.0, 0.001])


def motion(phi: Any, order: int = 0) -> Any:
    """By hand, in m and rad."""
    return (
        -0.02 - 0.008 * np.cos(phi) + 0.001 * np.sin(2 * phi),
        0.008 * np.sin(phi) + 0.002 * np.cos(2 * phi),
        0.008 * np.cos(phi) - 0.004 * np.sin(2 * phi),
        -0.008 * np.sin(phi) - 0.008 * np.cos(2 * phi),
    )[order]


RESTRICTIONS = (
    Band("law.restrictions[0]", 0, math.pi, math.pi, -0.012, -0.012),
    Band("law.restrictions[1]", 0, -0.1, 0.2, -0.0285, -0.027),
    Band("law.restrictions[2]", 1, 1.0, 2.0, -INF, 0.0075),
    Band("law.restrictions[3]", 2, 0.0, 2 * math.pi, -0.011, INF),
    Cap("law.caps[0]", 2, 0.001),
    Cap("law.caps[1]", 1, 0.02),
)


def answer(*restrictions: Restriction, count: int | None = 2) -> xr.Dataset:
    """The answer to a law of one's own: that motion, which is said to meet these restrictions."""

    class WrittenLaw(HarmonicLawTable):
        def make_motion_law(self, unit: str) -> SeriesMotionLaw:
            return SeriesMotionLaw(SERIES, "m", count, restrictions)

    return wucht.run(wucht.CamLaw(points=16), wucht.CamDrive(WrittenLaw()))


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return answer(*RESTRICTIONS)


def test_derivatives_and_harmonics(result: xr.Dataset) -> None:
    phi = np.linspace(0.0, 2 * math.pi, 17)
    assert result.cam_angle.values == pytest.approx(phi)
    for order, name in enumerate(NAMES):
        assert result[name].values == pytest.approx(motion(phi, order), abs=1e-15), name
        assert result[name].attrs["units"] == "m" + ("", "/rad", "/rad^2", "/rad^3")[order]
    assert float(result["mean"]) == -0.02 and result.order.values.tolist() == [1, 2]
    assert result.cosine.values.tolist() == [-0.008, 0.0] and result.sine.values.tolist() == [0.0, 0.001]
    assert result.amplitude.values == pytest.approx([0.008, 0.001])


def test_the_summary_has_the_largest_sizes(result: xr.Dataset) -> None:
    """The motion lies below zero throughout: its largest size is that of its least value."""
    s, phi = result.wucht.summary, np.linspace(0.0, 2 * math.pi, 200_001)
    for order, name in enumerate(NAMES):
        assert s["peaks"][name] == pytest.approx(np.abs(motion(phi, order)).max(), rel=1e-8), name
    assert s["peaks"]["position"] > 0.028 and s["stroke"] == pytest.approx(np.ptp(motion(phi)), rel=1e-8)
    assert s["coefficients"] == {"mean": -0.02, "cosine": [-0.008, 0.0], "sine": [0.0, 0.001]}
    assert (s["unit"], s["harmonics"], s["rise"], s["acceleration_jumps"]) == ("m", 2, None, 0.0)
    assert result.wucht.warnings == []


def test_restrictions_and_what_is_attained_under_them(result: xr.Dataset) -> None:
    assert result.restriction.values.tolist() == [r.name for r in RESTRICTIONS]
    assert result.restricted.values.tolist() == [0, 0, 1, 2, -1, -1] and result.harmonic.values.tolist() == [0, 0, 0, 0, 2, 1]
    nan = math.nan
    assert result.begin.values == pytest.approx([math.pi, -0.1, 1.0, 0.0, nan, nan], nan_ok=True)
    assert result.end.values == pytest.approx([math.pi, 0.2, 2.0, 2 * math.pi, nan, nan], nan_ok=True)
    assert result.low.values.tolist() == [-0.012, -0.0285, -INF, -0.011, 0.0, 0.0]
    assert result.high.values.tolist() == [-0.012, -0.027, 0.0075, INF, 0.001, 0.02]
    arcs = [motion(np.linspace(*ends, 20_001), order) for ends, order in (((-0.1, 0.2), 0), ((1.0, 2.0), 1), ((0, 7), 2))]
    assert result.least.values == pytest.approx([-0.012, *(a.min() for a in arcs), 0.0, 0.0], rel=1e-6)
    assert result.greatest.values == pytest.approx([-0.012, *(a.max() for a in arcs), 0.001, 0.008], rel=1e-6)


def test_the_ripple_is_that_of_the_tightest_or_of_the_dwells(result: xr.Dataset) -> None:
    """The dwell about 0 holds -27.75 mm. Where a restriction is widened only its deviation counts."""
    dwell, velocity = motion(np.linspace(-0.1, 0.2, 20_001)), motion(np.linspace(1.0, 2.0, 20_001), 1)
    wide = Band("law.restrictions[0]", 1, 1.0, 2.0, 0.0, 0.0, True)
    without, widened = answer(RESTRICTIONS[0], *RESTRICTIONS[2:]), answer(wide, RESTRICTIONS[1])
    ripples = [one.wucht.summary["ripple"] for one in (result, without, widened)]
    assert ripples == [
        pytest.approx(np.abs(dwell + 0.02775).max(), rel=1e-5), None, pytest.approx(np.abs(velocity).max(), rel=1e-6)
    ]  # fmt: skip
    assert not any(line.startswith("  dwell") for line in wucht.report(without))


@pytest.mark.parametrize(
    ("below", "above", "binds"),
    [(100, 100, False), (0.98, 100, True), (1.02, 100, False), (100, 0.98, True), (100, 1.02, False)],
)
def test_what_binds(below: float, above: float, binds: bool) -> None:
    """Within 1e-5 of the larger bound, the lower one, of either bound. below, above: distances of the bounds, in these."""
    attained = motion(np.linspace(-0.1, 0.2, 200_001))
    near = 1e-5 * abs(attained.min())
    low, high = attained.min() - below * near, attained.max() + above * near
    told = [line for line in wucht.report(answer(Band("law.restrictions[0]", 0, -0.1, 0.2, low, high))) if "]: " in line]
    assert told[0].endswith("(binding)") is binds


@pytest.mark.parametrize(("low", "high", "marks"), [(-0.03, INF, ["^"]), (-INF, -0.01, ["v"]), (-0.03, -0.01, ["^", "v"])])
def test_bounds_at_an_angle_are_triangles(low: float, high: float, marks: list[str]) -> None:
    """Of an arc below two degrees, at its angle within the turn."""
    axis = wucht.draw(answer(Band("law.restrictions[0]", 0, -0.5, -0.5 + math.radians(1.9), low, high))).axes[0]
    shown = [(x.get_marker(), x.get_xdata()[0], x.get_ydata()[0]) for x in axis.get_lines()[1:]]
    assert [m for m, *_ in shown] == marks
    assert [x for _, x, _ in shown] == pytest.approx([360 - math.degrees(0.5)] * len(marks))
    assert [y for *_, y in shown] == pytest.approx([1e3 * limit for limit in (low, high) if math.isfinite(limit)])
