"""Dips of a machine with two rotors that are made by hand: courses, sentences, warnings, report and figure."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.hand_made import drawn, titled, warnings_of

from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.settled_operation import EndState, SettledOperation
from wucht.dynamics.run_ups.voltage_dips import CriticalDip, Dip, LastingDip
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_machine
from wucht.studies.voltage_dip import computation, figure
from wucht.studies.voltage_dip import dataset as module
from wucht.studies.voltage_dip.computation import Findings, Plan
from wucht.studies.voltage_dip.spec import VoltageDip

VOLTAGES = {"drives.e1.voltage": 200.0, "drives.e2.voltage": 100.0}
BEFORE = MotionCourse(np.array([-2.0, -1.0]), np.array([[-150.0] * 2, [151.0] * 2]), np.full(2, 1e-3))
IN_OPERATION = EndState("synchronised", (150.0, 151.0), (1.0,), 1e-3, 9.0)


def ended(outcome: str, speed: float, advice: str | None = None) -> EndState:
    return EndState(outcome, (speed, speed), (), None, 3.0, advice)


def dip(duration: float, returns: bool = True, outcome: str = "stopped", **other: Any) -> Dip:
    course = MotionCourse(
        np.array([0.0, duration, 10 * duration]),
        np.array([[-150.0, -100.0, -10.0], [151.0, 101.0, 0.0]]),
        np.array([1e-3, 2e-3, 3e-3]),
    )
    end = IN_OPERATION if returns else ended(outcome, 12.0, "run longer")
    given: Any = {"speed_at_recovery": 100.0, "recovery_time": 0.75, "peak_amplitude": 4e-3, "course": course}
    return Dip(duration, end, returns, **given | other)


LASTING = LastingDip(ended("passed", 80.0), True, np.empty(0), BEFORE)


def planned(depth: float = 0.75, **keys: Any) -> Plan:
    settings: Any = SimpleNamespace()
    return Plan(VoltageDip(depth=depth, **keys), load_machine("practice/screen"), VOLTAGES, settings)


def made(*dips: Dip, operation: EndState = IN_OPERATION, working_point: float | None = None, **other: Any) -> Findings:
    settled = SettledOperation(np.zeros(1), operation, BEFORE, {}, working_point)
    given = {"lasting": LASTING, "is_complete": True, "critical": CriticalDip(dips)}
    return Findings(settled, **given | other)


def answered(findings: Findings, **keys: Any) -> xr.Dataset:
    return titled(module.dataset(planned(**keys), findings))


SHORT, LONG, LOSS = dip(0.5), dip(1.0), dip(2.0, returns=False)


def test_the_voltages_that_are_left_and_the_operating_state() -> None:
    s = answered(made(SHORT)).wucht.summary
    assert s["voltages"] == {"drives.e1": 200.0, "drives.e2": 100.0} and s["dip_voltages"] == {
        "drives.e1": 50.0,
        "drives.e2": 25.0,
    }
    assert (s["operating_speed"], s["operating_amplitude"], s["depth"]) == (150.0, 1e-3, 0.75)


def test_the_dips_at_the_border_are_drawn_from_before_they_begin() -> None:
    """Speeds in magnitude; a single dip is drawn once, also where it is one of the two at the border."""
    result = answered(made(SHORT, LONG, LOSS))
    assert result.course.values.tolist() == ["longest dip with a return", "shortest dip without"]
    assert result.course_duration.values.tolist() == [1.0, 2.0]
    assert result.time.values.tolist() == [[-2.0, -1.0, 0.0, 1.0, 10.0], [-2.0, -1.0, 0.0, 2.0, 20.0]]
    assert result.speed.values[1].tolist() == [[150.0, 150.0, 150.0, 100.0, 10.0], [151.0, 151.0, 151.0, 101.0, 0.0]]
    assert result.amplitude.values[0].tolist() == [1e-3, 1e-3, 1e-3, 2e-3, 3e-3]
    assert result.rotor.values.tolist() == ["e1", "e2"]
    single = answered(made(SHORT, LONG, LOSS, single=LOSS))
    assert single.course.values.tolist() == ["dip of the given duration", "longest dip with a return"]
    assert answered(made(SHORT, LOSS, single=dip(3.0))).course_duration.values.tolist() == [3.0, 0.5, 2.0]
    assert answered(made()).course.values.tolist() == ["operation"]


def test_the_critical_duration_is_that_of_a_border_that_is_complete() -> None:
    s = answered(made(SHORT, LONG, LOSS)).wucht.summary
    assert (s["critical_duration"], s["critical_speed"], s["beyond"]["duration"]) == (1.0, 100.0, 2.0)
    assert (s["outcome"], s["beyond"]["speed"], s["beyond"]["recovery_time"]) == ("stopped", 12.0, 0.75)
    open_border = answered(made(SHORT, LONG, LOSS, is_complete=False)).wucht.summary
    assert (open_border["critical_duration"], open_border["critical_speed"]) == (None, None)
    assert answered(made(SHORT, LONG)).wucht.summary["critical_duration"] is None
    assert answered(made(SHORT, LONG, LOSS, single=LONG)).wucht.summary["outcome"] == "synchronised"
    assert s["lasting"] == {"outcome": "passed", "speed": 80.0, "time": 3.0, "settled": True}


WITH = "with 75 % of the voltage lost, the machine returns by itself after"


@pytest.mark.parametrize(
    ("findings", "keys", "sentence"),
    [
        (made(SHORT, LONG, LOSS), {}, f"{WITH} dips of up to 1 s; after 2 s: stopped"),
        (made(SHORT, LONG, LOSS, is_complete=False), {}, f"{WITH} a dip of 1 s; after 2 s: stopped"),
        (made(SHORT, dip(2.0, False, "captured")), {}, f"{WITH} dips of up to 0.5 s; after 2 s: captured, at 12 rad/s"),
        (made(LOSS), {}, f"{WITH} none of the dips that were tried; after 2 s: stopped"),
        (made(SHORT, LONG), {}, f"{WITH} every dip, however long: it settles at 80 rad/s, and returns from there"),
        (made(SHORT, LONG, lasting=replace(LASTING, is_settled=False)), {}, f"{WITH} all dips that were tried, up to 1 s"),
        (made(SHORT, LONG, lasting=replace(LASTING, end=ended("stopped", 0.0))), {"depth": 1.0},
         "with all voltage lost, the machine returns by itself after every dip, however long: it stops, and starts again"),
        (made(SHORT, LONG), {"duration": (0.25, 1.0)}, f"{WITH} every dip of 0.25 to 1 s"),
        (made(), {}, "not determined yet"), (made(SHORT, lasting=None), {}, "not determined yet"),
    ],
)  # fmt: skip
def test_sentences(findings: Findings, keys: dict[str, Any], sentence: str) -> None:
    assert answered(findings, **keys).attrs["sentence"] == sentence


def test_warnings() -> None:
    again = answered(made(SHORT, LOSS, dip(3.0), dip(4.0), dip(5.0, returns=False)))
    assert again.wucht.summary["later_returns"] == [3.0, 4.0]
    assert warnings_of(again) == [
        "after longer dips the machine returns again: of those that were tried, after 2 from 3 to 4 s",
    ]
    unknown = [dip(k, returns=False, outcome="unidentified") for k in (2.0, 3.0, 4.0, 5.0)]
    told = warnings_of(answered(made(SHORT, *unknown)))
    assert told == [f"no verdict after a dip of {k} s, taken as no return: run longer" for k in (2, 3, 4)]
    stopped = made(operation=ended("stopped", 0.0, "start faster"))
    assert warnings_of(answered(stopped)) == ["start faster"]
    assert answered(stopped).attrs["sentence"].startswith("the machine does not reach a state of operation")


def test_a_failure_of_any_dip_is_that_of_the_study() -> None:
    dip_failed = answered(made(SHORT, dip(1.0, False, failure="it burst")))
    lasting_failed = answered(made(SHORT, lasting=replace(LASTING, failure="it broke")))
    for result, failure in ((dip_failed, "it burst"), (lasting_failed, "it broke")):
        assert failure in warnings_of(result)


def test_where_the_operating_state_comes_from() -> None:
    assert answered(made(SHORT)).wucht.assumed[0] == "the machine has settled after a run-up from the start"
    placed = answered(made(SHORT, working_point=144.5)).wucht.assumed[0]
    assert placed.endswith("has settled at its stable working point, 144.5 rad/s")


def test_the_lines_of_the_report() -> None:
    lines = module.report(answered(made(SHORT, LONG, LOSS, single=LONG)))[2:]
    assert lines == [
        "  operation    synchronised, 150 rad/s (1432 rpm), amplitude 1 mm",
        "  voltage      75 % lost; left: drives.e1: 50 V, drives.e2: 25 V",
        "  critical     1 s, to 1 %; the speed is then 100 rad/s (955 rpm)",
        "  dip          1 s: returns, from 100 rad/s (955 rpm); settled 0.75 s after the voltage is back; "
        "amplitude 4 mm at most",
        "  beyond       2 s: does not return: stopped, 12 rad/s (115 rpm), from 100 rad/s (955 rpm); "
        "settled 0.75 s after the voltage is back; amplitude 4 mm at most",
        "  low voltage  passed, 80 rad/s (764 rpm), after 3 s",
        "  dips         3 tried, 2 with a return",
    ]
    still = made(dip(1.0, False, recovery_time=None, peak_amplitude=0.0), lasting=replace(LASTING, is_settled=False))
    lines = module.report(answered(still))[2:]
    assert lines[2] == "  beyond       1 s: does not return: stopped, 12 rad/s (115 rpm), from 100 rad/s (955 rpm)"
    assert lines[3].endswith("not settled after 3 s") and lines[4] == "  dips         1 tried, 0 with a return"


def test_what_each_panel_shows() -> None:
    speed, amplitude, ends = drawn("voltage-dip", answered(made(SHORT, LONG, LOSS))).axes[:3]
    rows = [x for x in speed.get_lines() if len(np.asarray(x.get_xdata())) == 5]
    assert [np.asarray(x.get_ydata(), float)[-2:].tolist() for x in rows] == [[100.0, 10.0], [101.0, 0.0]] * 2
    assert [np.asarray(x.get_xdata(), float)[-1] for x in rows] == [10.0, 10.0, 20.0, 20.0]
    assert [str(x.get_label()) for x in rows[::2]] == ["longest dip with a return: 1 s", "shortest dip without: 2 s"]
    (level,) = (x for x in speed.get_lines() if x.get_label() == "in operation")
    assert np.asarray(level.get_ydata()).tolist() == [150.0, 150.0]
    upright = [float(np.asarray(x.get_xdata())[0]) for x in speed.get_lines() if x.get_label() != "in operation"][4:]
    assert upright == [0.0, 1.0, 2.0], "where the voltage falls and returns"
    first, second = amplitude.get_lines()[:2]
    assert np.asarray(second.get_xdata(), float)[-1] == 20.0
    assert np.asarray(first.get_ydata(), float) == pytest.approx([1.0, 1.0, 1.0, 2.0, 3.0])
    assert amplitude.get_xlim() == (-2.0, 20.0)
    of_name = {str(x.get_label()): x for x in ends.get_lines()}
    assert np.asarray(of_name["when the voltage returns"].get_ydata(), float).tolist() == [100.0] * 3
    for name, x, y in (("at the end, returned", [0.5, 1.0], [150.0] * 2), ("at the end, not returned", [2.0], [12.0])):
        line = of_name[name]
        shown = np.isfinite(np.asarray(line.get_ydata(), float))
        assert (
            np.asarray(line.get_xdata(), float)[shown].tolist() == x
            and np.asarray(line.get_ydata(), float)[shown].tolist() == y
        )
    assert np.asarray(of_name["critical duration"].get_xdata()).tolist() == [1.0, 1.0]


def test_a_long_course_is_cut_off() -> None:
    """At four times the end of the shortest one, but not before its dip is over."""
    for longest, end in ((2.0, 20.0), (9.0, 20.0), (30.0, 33.0)):
        axis = Figure().subplots()
        figure._limit_time(axis, answered(made(SHORT, dip(longest, False))))
        assert axis.get_xlim()[1] == pytest.approx(end)


# --- which dips are computed ---


def computed(
    monkeypatch: pytest.MonkeyPatch, returns: Any, outcome: str = "passed", **keys: Any
) -> tuple[list[Findings], list[Any]]:
    """The findings of a machine that returns as told, and what was asked of its supply: of the lasting dip, then durations."""
    asked = list[Any]()

    class Supply:
        def lasting_dip(self, until: float | None, count: int, work: Any) -> LastingDip:
            asked.append((until, count))
            return replace(LASTING, levels=np.array([0.2, 0.5, 0.9, 3.0]))

        def dip(self, duration: float, work: Any) -> Dip:
            asked.append(duration)
            return dip(duration, returns(duration))

    settled = SettledOperation(np.zeros(1), replace(IN_OPERATION, outcome=outcome), BEFORE, {})
    monkeypatch.setattr(computation, "operation_of", lambda *_: settled)
    monkeypatch.setattr(Plan, "supply", lambda *_: Supply())
    return list(computation.run(planned(**keys), Work())), asked


def test_dips_of_all_levels_then_the_border(monkeypatch: pytest.MonkeyPatch) -> None:
    findings, asked = computed(monkeypatch, lambda t: t < 0.7, points=7)
    assert asked[:5] == [(None, 7), 0.2, 0.5, 0.9, 3.0]
    assert all(0.5 < t < 0.9 for t in asked[5:])
    assert [f.is_complete for f in findings] == [False] * (len(findings) - 1) + [True]
    last = findings[-1].critical
    assert last.longest_return is not None and last.longest_return.duration == pytest.approx(0.7, rel=0.01)
    assert findings[0].lasting is None and findings[1].lasting is not None and findings[2].critical.dips != ()


def test_a_single_duration_comes_first_and_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    findings, asked = computed(monkeypatch, lambda t: t < 0.7, duration=0.75)
    assert asked[1:3] == [0.75, 0.2]
    single = findings[-1].single
    assert single is not None and (single.duration, single.is_return) == (0.75, False)
    assert single in findings[-1].critical.dips and not any(0.75 < t < 0.9 for t in asked[2:] if isinstance(t, float))


def test_of_a_range_its_ends_and_the_levels_between_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    _, asked = computed(monkeypatch, lambda t: True, duration=(0.2, 0.8))
    assert asked[0][0] == 0.8 and asked[1:] == [0.2, 0.5, 0.8]
    _, asked = computed(monkeypatch, lambda t: False, duration=(0.2, 0.8))
    assert asked[1:] == [0.2, 0.5, 0.8], "none that is shorter"


def test_a_machine_that_is_not_in_operation_has_no_dips(monkeypatch: pytest.MonkeyPatch) -> None:
    findings, asked = computed(monkeypatch, lambda t: True, outcome="stopped")
    assert len(findings) == 1 and asked == []


def test_the_machine_whose_supply_dips_is_as_the_run_up_has_left_it() -> None:
    settled = SettledOperation(np.zeros(1), IN_OPERATION, BEFORE, {})
    supply = planned(depth=0.25).supply(settled)
    assert (supply.voltages, supply.depth, supply.operation) == (VOLTAGES, 0.25, settled)
    assert {n: supply.dip_machine.values[n] for n in VOLTAGES} == {"drives.e1.voltage": 150.0, "drives.e2.voltage": 75.0}
