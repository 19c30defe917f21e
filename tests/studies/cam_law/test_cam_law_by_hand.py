"""A motion law that is written down: its derivatives, harmonics and restrictions in closed form, in words and in the figure."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, titled, warnings_of

from wucht.cams.laws.synthesis import Band, Cap
from wucht.cams.tables.motion_law import SeriesMotionLaw
from wucht.dynamics.work import Work
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies import cam_law
from wucht.studies.cam_law import Findings, Plan

INF = math.inf
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


def planned(*restrictions: Any, points: int = 8, count: int | None = 2) -> Plan:
    law = SeriesMotionLaw(SERIES, "m", count, restrictions)
    return Plan(law, points, 2)


@pytest.fixture(scope="module")
def plan() -> Plan:
    return planned(*RESTRICTIONS)


@pytest.fixture(scope="module")
def findings(plan: Plan) -> Findings:
    (made,) = cam_law.run(plan, Work())
    return made


@pytest.fixture(scope="module")
def result(plan: Plan, findings: Findings) -> xr.Dataset:
    return titled(cam_law.dataset(plan, findings))


def test_derivatives_and_harmonics(result: xr.Dataset) -> None:
    phi = np.linspace(0.0, 2 * math.pi, 9)
    assert result.cam_angle.values == pytest.approx(phi)
    for order, name in enumerate(("position", "velocity", "acceleration", "jerk")):
        assert result[name].values == pytest.approx(motion(phi, order), abs=1e-15), name
        assert result[name].attrs["units"] == "m" + ("", "/rad", "/rad^2", "/rad^3")[order]
    assert float(result["mean"]) == -0.02 and result.order.values.tolist() == [1, 2]
    assert result.cosine.values.tolist() == [-0.008, 0.0] and result.sine.values.tolist() == [0.0, 0.001]
    assert result.amplitude.values == pytest.approx([0.008, 0.001])


def test_the_summary_has_the_largest_sizes(result: xr.Dataset) -> None:
    """The motion lies below zero throughout: its largest size is that of its least value."""
    s, phi = result.wucht.summary, np.linspace(0.0, 2 * math.pi, 200_001)
    for order, name in enumerate(("position", "velocity", "acceleration", "jerk")):
        assert s["peaks"][name] == pytest.approx(np.abs(motion(phi, order)).max(), rel=1e-8), name
    assert s["peaks"]["position"] > 0.028 and s["stroke"] == pytest.approx(np.ptp(motion(phi)), rel=1e-8)
    assert s["coefficients"] == {"mean": -0.02, "cosine": [-0.008, 0.0], "sine": [0.0, 0.001]}
    assert (s["unit"], s["harmonics"], s["rise"], s["acceleration_jumps"]) == ("m", 2, None, 0.0)
    assert warnings_of(result) == []


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


def test_the_ripple_is_that_of_the_tightest_or_of_the_dwells(plan: Plan, findings: Findings) -> None:
    """The dwell about 0 holds -27.75 mm. Where a restriction is widened only its deviation counts."""
    arc = motion(np.linspace(-0.1, 0.2, 20_001))
    assert cam_law._ripple(plan, findings) == pytest.approx(np.abs(arc + 0.02775).max(), rel=1e-5)
    none = planned(RESTRICTIONS[0], *RESTRICTIONS[2:])
    (made,) = cam_law.run(none, Work())
    assert cam_law._ripple(none, made) is None
    wide = Band("law.restrictions[0]", 1, 1.0, 2.0, 0.0, 0.0, True)
    other = planned(wide, RESTRICTIONS[1])
    (made,) = cam_law.run(other, Work())
    assert cam_law._ripple(other, made) == pytest.approx(np.abs(motion(np.linspace(1.0, 2.0, 20_001), 1)).max(), rel=1e-6)


@pytest.mark.parametrize(("count", "restrictions", "sentence"), [
    (1, (), "a motion of 1 harmonic"), (3, RESTRICTIONS[:1], "a motion of 3 harmonics meets 1 restriction"),
    (2, RESTRICTIONS, "a motion of 2 harmonics meets 6 restrictions"), (None, (), "a motion given by points or pieces"),
])  # fmt: skip
def test_sentences(count: int | None, restrictions: Any, sentence: str) -> None:
    assert cam_law._sentence(planned(*restrictions, count=count)) == sentence


def test_the_lines_of_the_report(result: xr.Dataset) -> None:
    lines = cam_law.report(result)
    assert lines[1] == "verdict: a motion of 2 harmonics meets 6 restrictions"
    told = [line.split("]: ")[1] for line in lines if "]: " in line]
    assert [line.endswith("(binding)") for line in told] == [False, False, False, False, True, False]
    assert told[0] == "position -12 mm" and told[4] == "amplitude 1 mm (binding)" and told[5] == "amplitude 8 mm"


@pytest.mark.parametrize(
    ("least", "greatest", "binds"),
    [
        (-0.028, -0.0272, False),
        (-0.0285 + 2.7e-7, -0.0276, True),
        (-0.0285 + 3e-7, -0.0276, False),
        (-0.028, -0.027 - 2.7e-7, True),
        (-0.028, -0.027 - 3e-7, False),
    ],
)
def test_what_binds(plan: Plan, findings: Findings, least: float, greatest: float, binds: bool) -> None:
    """Within 1e-5 of the larger bound, 28.5 mm, of either bound."""
    attained = findings.attained_ranges.copy()
    attained[1] = least, greatest
    changed = Findings(**vars(findings) | {"attained_ranges": attained})
    told = [line for line in cam_law.report(titled(cam_law.dataset(plan, changed))) if "restrictions[1]: " in line]
    assert told[0].endswith("(binding)") is binds


def test_a_law_whose_acceleration_jumps(plan: Plan, findings: Findings) -> None:
    changed = Findings(**vars(findings) | {"jump": 2.5e-3, "rise": np.array([1.5, 4.5, 30.0])})
    jumping = titled(cam_law.dataset(plan, changed))
    s = jumping.wucht.summary
    assert s["acceleration_jumps"] == 2.5e-3 and s["rise"] == {"velocity": 1.5, "acceleration": 4.5, "jerk": 30.0}
    assert len(warnings_of(jumping)) == 1
    assert any(line.endswith("of 1 over an arc of 1: Cv = 1.5, Ca = 4.5, Cj = 30") for line in cam_law.report(jumping))


def test_the_figure(result: xr.Dataset) -> None:
    """Bounds of each derivative in its panel: over their arcs and these a turn on, or as marks where there is no arc."""
    axes = drawn("cam-law", result).axes
    deg, phi = 180 / math.pi, np.linspace(0.0, 360.0, 9)
    for order, (axis, name) in enumerate(zip(axes, ("position", "velocity", "acceleration", "jerk"), strict=False)):
        line = axis.get_lines()[0]
        assert line.get_xdata() == pytest.approx(phi) and line.get_ydata() == pytest.approx(1e3 * result[name].values)
        assert axis.get_ylabel() == f"{name} (mm{('', '/rad', '/rad²', '/rad³')[order]})" and axis.get_xlim() == (0.0, 360.0)
    marks = [
        (x.get_marker(), list(x.get_xdata()), list(x.get_ydata())) for x in axes[0].get_lines() if x.get_marker() != "None"
    ]
    assert marks == [("o", [pytest.approx(180.0)], [pytest.approx(-12.0)])]
    bounds = [(list(x.get_xdata()), x.get_ydata()[0]) for x in axes[0].get_lines() if x.get_linestyle() == "--"]
    arc = [-0.1 * deg, 0.2 * deg]
    assert [level for _, level in bounds] == pytest.approx([-28.5] * 3 + [-27.0] * 3)
    assert [ends for ends, _ in bounds] == [pytest.approx([a + t for a in arc]) for t in (-360, 0, 360)] * 2
    for axis, level in ((axes[1], 7.5), (axes[2], -11.0)):
        assert [x.get_ydata()[0] for x in axis.get_lines() if x.get_linestyle() == "--"] == pytest.approx([level] * 3)
    assert len(axes[3].get_lines()) == 1
    for axis, power in ((axes[4], 0), (axes[5], 2)):
        assert [b.get_height() for b in axis.patches] == pytest.approx([8.0, 2.0**power])
        caps = [(list(x.get_xdata()), x.get_ydata()[0]) for x in axis.get_lines()]
        assert caps == [([1.5, 2.5], pytest.approx(2.0**power)), ([0.5, 1.5], pytest.approx(20.0))]


@pytest.mark.parametrize(("low", "high", "marks"), [(-0.03, INF, ["^"]), (-INF, -0.01, ["v"]), (-0.03, -0.01, ["^", "v"])])
def test_bounds_at_an_angle_are_triangles(low: float, high: float, marks: list[str]) -> None:
    """Of an arc below two degrees, at its angle within the turn."""
    plan = planned(Band("law.restrictions[0]", 0, -0.5, -0.5 + math.radians(1.9), low, high))
    (made,) = cam_law.run(plan, Work())
    axis = drawn("cam-law", titled(cam_law.dataset(plan, made))).axes[0]
    shown = [(x.get_marker(), x.get_xdata()[0], x.get_ydata()[0]) for x in axis.get_lines()[1:]]
    assert [m for m, *_ in shown] == marks
    assert [x for _, x, _ in shown] == pytest.approx([360 - math.degrees(0.5)] * len(marks))
    assert [y for *_, y in shown] == pytest.approx([1e3 * limit for limit in (low, high) if math.isfinite(limit)])


def test_of_a_law_with_infinitely_many_harmonics_as_many_are_shown_as_is_said() -> None:
    endless = SimpleNamespace(motion_law=SimpleNamespace(count=None))
    asked: Any = SimpleNamespace(points=16, orders=7)
    assert cam_law.prepare(asked, endless).orders == 7  # type: ignore[arg-type]
    asked_of_two: Any = SimpleNamespace(motion_law=SimpleNamespace(count=2))
    assert cam_law.prepare(asked, asked_of_two).orders == 2
