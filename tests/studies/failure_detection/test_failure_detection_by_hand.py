"""Failures that are made by hand: sentences, warnings, lines and panels; and the places at which the signal is looked for."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, five_functions, titled, warnings_of, with_answer
from tests.refusals import refused

import wucht
from wucht.dynamics.exciters.failing_machine import FailingMachine, FailureCourse
from wucht.dynamics.exciters.speed_readings import FEWEST, STEADY, UNSTABLE, AveragedSpeed, Readings, Windows
from wucht.dynamics.work import Work
from wucht.errors import RunError
from wucht.studies.failure_detection import computation as run_module
from wucht.studies.failure_detection import dataset as dataset_module
from wucht.studies.failure_detection.computation import Findings, MonitoredRun, ParameterAxis, ParameterPoint
from wucht.studies.failure_detection.dataset import _reading_extremes as over_readings
from wucht.studies.failure_detection.spec import FailureDetection

STUDY = five_functions("failure-detection")
WHOLE = 1e5
KEYS = {
    "until": 8.0, "start": {"p1": 0.3, "p2": -0.5}, "after": 0.5,
    "sensor": {"interval": 0.2, "noise": 1.0, "false_alarm_every": 3600.0},
}  # fmt: skip
ALONG = {"along": "drive.slope", "range": (0.01, 0.02), "points": 3}
SECOND = {"second": "carrier.damping", "second_range": (190.0, 210.0), "second_points": 2}


def machine(*points: tuple[float, float], interpolation: str = "steps") -> wucht.Machine:
    p = wucht.parts
    pendulums = [
        p.Pendulum(name=name, about="drum", mass=mass, length=0.104, inertia=1.69e-3, damping=0.169)
        for name, mass in (("p1", 0.125), ("p2", 0.126))
    ]
    drum = p.Rotor(name="drum", mass=9.75, eccentricity=1e-3, inertia=9.75e-4)
    schedule = {"parameter": "carrier.stiffness", "points": list(points), "interpolation": interpolation}
    motor = p.LinearDrive(slope=0.01365, no_load_speed=200.0)
    return wucht.Machine(p.Carrier(stiffness=WHOLE, damping=200.0), [drum, *pendulums], [motor], schedules=[schedule])


MACHINE = machine((0.0, WHOLE), (4.0, 0.8 * WHOLE))


def planned(**more: Any) -> Any:
    return STUDY.prepare(FailureDetection(**KEYS | more), MACHINE)


def seen(failed: float | None = 4.0, **other: Any) -> MonitoredRun:
    """A run of 32 readings whose speed goes from 90 to 120; other: of the readings, or advice, residual, failure, damage."""
    time = 0.25 * np.arange(1, 33)
    speed = np.where(time <= 4.0, 90.0, 120.0)
    common = {"before": 90.0, "after": 120.0, "beating": 0.75}
    given = common | {key: value for key, value in other.items() if key in common}
    readings = Readings(time, speed, time <= 4.0, time > 6.0, **given)
    at = np.linspace(0.0, 8.0, 257)
    damage = other.get("damage")
    share = np.where(at <= 4.0, 1.0, 0.8)
    course = FailureCourse(
        at, 90 * at, share, np.full(257, np.nan) if damage is None else damage * at / 8, np.sin(at), -np.cos(at),
        np.full(257, other.get("residual", 1e-9)), -0.5 * at,
    )  # fmt: skip
    stored = SimpleNamespace(failure=other.get("failure"))
    state = SimpleNamespace(
        damage=None if damage is None else SimpleNamespace(total=damage), last=SimpleNamespace(trajectory=stored)
    )
    verdict = SimpleNamespace(outcome="compensated", advice=other.get("advice", ""))
    before, failure = SimpleNamespace(outcome="captured"), other.get("failure")
    run = SimpleNamespace(course=course, state=state, verdict=verdict, verdict_before=before, failure=failure)
    return MonitoredRun(run, Windows((0.5, 4.0), (6.0, 8.0), failed, failed), readings)  # type: ignore[arg-type]


class Known:
    """A detection whose numbers are given."""

    def __init__(self, mean: float | None = 1.5, reference: float = 2.5) -> None:
        self.mean, self.learnt, self.horizon, self.readings = mean, 90.0, 5000.0, 20_000
        self.chart = SimpleNamespace(reference=reference, threshold=9.75)

    def quantile(self, probability: float) -> float | None:
        return {0.5: 1.25, 0.95: None}[probability]

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array([0.25, 0.5, 5000.0]), np.array([0.0, 0.5, 0.96875])


def result(plan: Any = None, of: MonitoredRun | None = None, detection: Any = None, **other: Any) -> xr.Dataset:
    found = Findings(of or seen(), detection, **other)
    return titled(STUDY.dataset(plan or planned(), found))


# --- sentences and warnings ---


FAILS = "the specimen fails at 4 s, the speed changes by 30 rad/s"


@pytest.mark.parametrize(
    ("of", "detection", "sentence"),
    [
        (seen(), None, f"{FAILS}; no control chart monitors it"),
        (seen(), Known(), f"{FAILS}, which is detected 1.5 s later on average"),
        (seen(), Known(0.0), f"{FAILS}, which is detected 0 s later on average"),
        (seen(), Known(-1.5), f"{FAILS}, which is detected 1.5 s before it on average"),
        (
            seen(), Known(None),
            f"{FAILS}, which is detected within 20,000 readings, 5000 s (1.39 h) with a probability of 0.969",
        ),
        (seen(after=None), Known(), "the specimen fails at 4 s; there are too few readings to determine the change of speed"),
        (seen(None, after=None), None, "the specimen does not fail"),
        (seen(None, after=None, damage=0.123456), None, "the specimen does not fail: damage 0.1235"),
        (
            seen(None, damage=0.5), Known(),
            "the specimen does not fail: damage 0.5, the speed changes by 30 rad/s, which is detected 1.5 s after the chart "
            "begins on average",
        ),
    ],
)  # fmt: skip
def test_sentences(of: MonitoredRun, detection: Any, sentence: str) -> None:
    made = result(of=of, detection=detection)
    assert made.wucht.summary["failure_time"] == of.windows.failure_time
    assert made.attrs["sentence"] == sentence


def test_no_warnings() -> None:
    assert warnings_of(result(detection=Known())) == []
    assert warnings_of(result(detection=Known(1800.0), of=seen(residual=1e-6))) == []


@pytest.mark.parametrize(
    ("of", "other", "warning"),
    [
        (seen(residual=1.1e-6), {}, "the energy balance closes only to 1.1e-06: the run is not accurate"),
        (seen(), {"no_detection": "why"}, "there is no control chart: why"),
        (
            seen(), {"detection": Known(1800.5)},
            "an alarm comes hardly any sooner than a false one: the chart does not detect this failure",
        ),
        (
            seen(), {"detection": Known(reference=15.5)},
            "the chart is designed for changes of 31, and this one is smaller: a smaller study.sensor.change detects it sooner",
        ),
        (seen(advice="run longer"), {}, "after the failure run longer"),
        (seen(failure="it burst"), {}, "it burst"),
        (seen(None), {}, "the specimen does not fail within study.until: run longer, or give it a shorter life (a smaller ND)"),
        (
            seen(before=None), {},
            "there are too few readings before or after the failure: run longer, or let the specimen fail later",
        ),
    ],
)  # fmt: skip
def test_a_warning(of: MonitoredRun, other: dict[str, Any], warning: str) -> None:
    assert warnings_of(result(of=of, **other)) == [warning]


def averaged(before: AveragedSpeed, after: AveragedSpeed) -> list[str]:
    return warnings_of(result(averaged_speeds=(before, after)))


def test_warnings_of_the_averaged_equations() -> None:
    near, good = AveragedSpeed(94.4, STEADY), AveragedSpeed(120.0, STEADY)
    assert averaged(near, good) == []
    assert averaged(AveragedSpeed(None, reason="why"), good) == ["the averaged equations give no speed before the failure: why"]
    (unstable,) = averaged(near, AveragedSpeed(120.0, UNSTABLE, next_stable=200.123456))
    assert unstable == (
        "the steady state after the failure is unstable: the run stays there because nothing disturbs it, but a machine would "
        "not; the nearest stable one has 200.12. This happens with identical bodies: make one of them slightly different"
    )
    (alone,) = averaged(near, AveragedSpeed(120.0, UNSTABLE))
    assert "would not. This happens" in alone
    far = [
        f"the averaged equations have {x:.5g} {when} the failure, the full ones {speed}: the speed is still changing, the "
        "averaged motion is a different one, or the averaging is too coarse"
        for x, when, speed in ((94.6, "before", 90), (113.9, "after", 120))
    ]
    assert averaged(AveragedSpeed(94.6, STEADY), AveragedSpeed(113.9, STEADY)) == far


@pytest.mark.parametrize(
    ("time", "unit", "words"),
    [
        (3599.0, "s", "3599 s"), (3600.0, "s", "3600 s (1 h)"), (-7200.0, "s", "-7200 s (-2 h)"), (3600.0, "", "3600"),
    ],
)  # fmt: skip
def test_times_from_an_hour_on_are_in_hours_too(time: float, unit: str, words: str) -> None:
    assert dataset_module.duration_in_words(time, unit) == words


# --- the report ---


def test_the_lines_of_a_failure() -> None:
    made = result(of=seen(damage=0.75), detection=Known(), averaged_speeds=(AveragedSpeed(91.0, STEADY), AveragedSpeed(None)))
    assert STUDY.report(made)[2:] == [
        "  before       90 rad/s, captured; averaged equations 91 rad/s",
        "  after        120 rad/s, compensated",
        "  change       30 rad/s, 24 times the standard deviation of the readings, 1.25 rad/s",
        "  chart        cumulative sum, k = 2.5, h = 9.75 rad/s",
        "  detection    1.5 s after the failure on average; half of them within 1.25 s, 19 of 20 not within 3 readings, "
        "5000 s (1.39 h)",
        "  damage       0.75 at the end",
        "  stiffness    0.8 of the intact specimen's at the end, its work -4 J",
        "  energy       closes to 1.0e-09",
    ]
    never = STUDY.report(result(of=seen(None), detection=Known()))
    assert never[6].startswith("  detection    1.5 s after the chart begins on average; ")
    few = STUDY.report(result(of=seen(before=None)))
    assert [line[2:12].strip() for line in few[2:]] == ["after", "stiffness", "energy"]
    unknown = with_answer(made, before={"speed": 90.0, "outcome": None})
    assert STUDY.report(unknown)[2] == "  before       90 rad/s, not classified; averaged equations 91 rad/s"


# --- other values ---


PLACES = (
    ParameterPoint((0.01,), 90.0, 95.0, 4.0, "captured"),
    ParameterPoint((0.015,), 90.0, 150.0, 48.0, "passed"),
    ParameterPoint((0.02,), None, 99.0, None, "x"),
)


def test_the_signal_over_one_parameter() -> None:
    made = result(planned(**ALONG), points=PLACES)
    assert made.signal.dims == ("along",) and made.along.values.tolist() == [0.01, 0.015, 0.02]
    assert made.signal.values[:2].tolist() == [4.0, 48.0] and made.change.values[:2].tolist() == [5.0, 60.0]
    assert np.isnan(made.signal.values[2]) and np.isnan(made.change.values[2])
    assert (made.along.attrs["long_name"], made.along.attrs["units"]) == ("drive.slope", "N m s")
    assert made.change.attrs["units"] == "rad/s"
    largest = made.wucht.summary["largest"]
    assert {k: largest[k] for k in ("drive.slope", "signal", "change", "outcome")} == {
        "drive.slope": 0.015, "signal": 48.0, "change": 60.0, "outcome": "passed",
    }  # fmt: skip
    assert largest["neighbours"] == [{"drive.slope": 0.01, "signal": 4.0}, {"drive.slope": 0.02, "signal": None}]
    cliff = largest["cliff"]
    assert (cliff["value"], cliff["inside"], cliff["signal"]) == (0.02, 0.015, 0.0), "a third away; the other one is half away"
    assert not any("cliff" in w for w in made.wucht.warnings), "it is far"
    assert STUDY.report(made)[-1] == "  largest      signal 48 at drive.slope = 0.015: change 60 rad/s, then passed"
    axis = drawn("failure-detection", made).axes[-1]
    line, largest, cliff = axis.get_lines()
    assert (line.get_label(), list(line.get_xdata()), list(line.get_ydata())[:2]) == (
        "signal",
        [0.01, 0.015, 0.02],
        [4.0, 48.0],
    )
    assert (largest.get_label(), list(largest.get_xdata()), list(largest.get_ydata())) == ("largest", [0.015], [48.0])
    assert (cliff.get_label(), cliff.get_xdata()[0]) == ("cliff, 33 % above it", pytest.approx(0.0175))
    assert axis.get_ylim()[0] == 0 and axis.get_title() == "signal at the failure"
    assert axis.get_ylabel() == "change of speed / standard deviation" and len(axis.get_xticks()) <= 7


def signals(*rows: tuple[float, float]) -> tuple[ParameterPoint, ...]:
    return tuple(ParameterPoint((x,), 90.0, 90.0 + y, y, "passed") for x, y in rows)


def test_a_largest_signal_at_a_cliff_is_warned_of() -> None:
    """Half the signal is none yet: the cliff is where less than half is left. At least 5 % away from it another one is best."""
    made = result(planned(**ALONG), points=signals((0.01, 9.0), (0.0199, 9.99), (0.02, 20.0), (0.021, 19.0), (0.022, 18.0)))
    s = made.wucht.summary
    assert s["largest"]["cliff"]["distance"] == pytest.approx(-0.005) and s["largest"]["cliff"]["signal"] == pytest.approx(9.99)
    assert (s["largest_safe"]["drive.slope"], s["largest_safe"]["signal"]) == (0.021, 19.0)
    assert s["sentence"].endswith("the signal is largest, 20 (24 as it is), at drive.slope = 0.02, and 0.5 % below that 9.99")
    (warning,) = (w for w in made.wucht.warnings if "cliff" in w)
    assert warning == (
        "the largest signal, 20 at drive.slope = 0.02 N m s, lies at a cliff: 0.5 % below, at 0.0199 N m s, it is 9.99; "
        "at least 5 % away from it drive.slope = 0.021 N m s is best, 19"
    )
    half = result(planned(**ALONG), points=signals((0.0199, 10.0), (0.02, 20.0))).wucht
    assert half.summary["largest"]["cliff"] is None and not any("cliff" in w for w in half.warnings)
    edge = result(planned(**ALONG), points=signals((0.019, 1.0), (0.02, 20.0))).wucht
    assert edge.summary["largest_safe"] == edge.summary["largest"], "5 % away is far enough"
    assert not any("cliff" in w for w in edge.warnings)


def test_the_signal_over_two_parameters() -> None:
    values = [(a, b) for a in (0.01, 0.015, 0.02) for b in (190.0, 210.0)]
    places = tuple(ParameterPoint(v, 90.0, 90.0 - k, float(k), f"o{k}") for k, v in enumerate(values))
    made = result(planned(**ALONG, **SECOND), points=places[:5])
    assert made.signal.dims == ("along", "second") and made.second.attrs["long_name"] == "carrier.damping"
    assert made.signal.values[:2].tolist() == [[0.0, 1.0], [2.0, 3.0]] and math.isnan(made.signal.values[2, 1])
    assert made.change.values[1].tolist() == [-2.0, -3.0]
    assert STUDY.report(made)[-1] == (
        "  largest      signal 4 at drive.slope = 0.02, carrier.damping = 190: change -4 rad/s, then o4"
    )
    lines = drawn("failure-detection", made).axes[-1].get_lines()
    assert [line.get_label() for line in lines] == [
        "carrier.damping = 190", "carrier.damping = 210", "largest", "cliff, 50 % below it",
    ]  # fmt: skip
    assert list(lines[0].get_ydata()) == [0.0, 2.0, 4.0] and list(lines[1].get_ydata())[:2] == [1.0, 3.0]
    assert (list(lines[2].get_xdata()), list(lines[2].get_ydata())) == ([0.02], [4.0])
    nowhere = tuple(replace(p, signal=None) for p in places)
    made = result(planned(**ALONG, **SECOND), points=nowhere)
    assert made.wucht.summary["largest"] is None
    assert len(drawn("failure-detection", made).axes[-1].get_lines()) == 2
    assert "signal" not in result(planned(**ALONG))


def looked_at(monkeypatch: pytest.MonkeyPatch, best: float, **asked: Any) -> tuple[list[tuple[float, ...]], Any]:
    """The places of a study whose signal is largest near a value of the first parameter, in the order of being run."""
    plan, order = planned(**asked), list[tuple[float, ...]]()

    def run(self: FailingMachine, work: Work) -> Any:
        values = tuple(self.machine.values[p] for p in ("drive.slope", *(["carrier.damping"] if "second" in asked else [])))
        order.append(values)
        signal = 100 - abs(values[0] - best) * 1e4
        yield SimpleNamespace(failure="early", verdict=None, values=values, signal=0.0)
        burst = "burst" if values[0] >= 0.02 else None
        yield SimpleNamespace(failure=burst, verdict=SimpleNamespace(outcome="passed"), values=values, signal=signal)

    def readings(plan: Any, failing: Any) -> Any:
        of = seen(after=90.0 + 1.25 * failing.signal)
        return replace(of, run=SimpleNamespace(**vars(of.run) | {"failure": failing.failure}))

    monkeypatch.setattr(FailingMachine, "run", run)
    monkeypatch.setattr(run_module, "_monitored_run", readings)
    monkeypatch.setattr(run_module, "_detection", lambda *_: (None, ""))
    monkeypatch.setattr(run_module, "_averaged_speed", lambda *_: AveragedSpeed(None))
    shares = list[float]()
    *_, last = STUDY.run(plan, Work(reporter=lambda share, _: shares.append(share)))
    assert shares == sorted(shares) and len(set(shares[-3:])) == 3, "each place takes it further"
    most = 6 if "second" in asked else 3 + 2 * 4
    assert shares[-1] == pytest.approx(0.35 + 0.65 * len(last.points) / most), "the machine itself takes about a third"
    return order[1:], last


def test_beside_the_best_value_it_is_looked_more_finely(monkeypatch: pytest.MonkeyPatch) -> None:
    order, last = looked_at(monkeypatch, 0.0162, **ALONG)
    expected = [0.01, 0.015, 0.02, 0.0125, 0.0175, 0.01375, 0.01625, 0.015625, 0.016875, 0.0159375, 0.0165625]
    assert [v[0] for v in order] == pytest.approx(expected)
    assert [p.values for p in last.points] == sorted(p.values for p in last.points)
    best = max(last.points, key=lambda p: p.signal or 0.0)
    assert best.values[0] == pytest.approx(0.0162, abs=1e-4) and best.signal == pytest.approx(
        100 - abs(best.values[0] - 0.0162) * 1e4
    )
    assert last.points[-1].signal is None and last.points[-1].values == (0.02,), "what ends early has no signal"
    assert {p.outcome for p in last.points} == {"passed"}


def test_at_an_end_of_the_range_there_is_one_neighbour(monkeypatch: pytest.MonkeyPatch) -> None:
    order, _ = looked_at(monkeypatch, 0.01, **ALONG)
    assert [v[0] for v in order] == pytest.approx([0.01, 0.015, 0.02, 0.0125, 0.01125, 0.010625, 0.0103125])


def test_of_two_parameters_the_grid_alone_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    order, last = looked_at(monkeypatch, 0.0162, **ALONG, **SECOND)
    assert order == [(a, b) for a in (0.01, 0.015, 0.02) for b in (190.0, 210.0)]
    assert len(last.points) == 6


def test_why_there_is_no_chart(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: Any) -> None:
        raise RunError("too much noise")

    plan, of = planned(), seen()
    monkeypatch.setattr(FailingMachine, "run", lambda *_: iter([None]))
    monkeypatch.setattr(run_module, "_monitored_run", lambda *_: of)
    monkeypatch.setattr(run_module, "detection_of", none)
    monkeypatch.setattr(run_module, "_averaged_speed", lambda *_: AveragedSpeed(None))
    *_, last = STUDY.run(plan, Work())
    assert (last.detection, last.no_detection) == (None, "too much noise")


# --- the figure ---


def test_panels() -> None:
    made = result(
        of=seen(damage=0.5), detection=Known(), averaged_speeds=(AveragedSpeed(91.0, STEADY), AveragedSpeed(119.0, STEADY))
    )
    speed, load, alarm, stiffness = drawn("failure-detection", made).axes
    levels = [(line.get_label(), line.get_ydata()[0]) for line in speed.get_lines()[2:4]]
    assert levels[0] == ("averaged equations", 91.0) and levels[1][1] == 119.0 and str(levels[1][0]).startswith("_")
    assert list(speed.get_lines()[1].get_ydata()) == made.speed.values.tolist()
    assert list(speed.get_lines()[0].get_ydata()) == made.reading.values.tolist()
    for axis in (speed, load, stiffness):
        (failure,) = [line for line in axis.get_lines() if line.get_label() == "failure"]
        assert failure.get_xdata()[0] == 4.0
    step, marks, mean = alarm.get_lines()
    assert list(step.get_ydata()) == list(marks.get_ydata()) == [0.0, 0.5, 0.96875] and mean.get_xdata()[0] == 1.5
    assert [list(line.get_ydata()) for line in stiffness.get_lines()[:2]] == [
        made.stiffness.values.tolist(),
        made.damage.values.tolist(),
    ]
    assert alarm.get_ylim() == (0.0, 1.02) and stiffness.get_ylim()[0] == 0.0


def test_panels_without_what_is_not_known() -> None:
    many = Known(None)
    many.curve = lambda: (np.arange(70.0), np.linspace(0.0, 0.9, 70))  # type: ignore[method-assign]
    _, _, alarm, stiffness = drawn("failure-detection", result(of=seen(None), detection=many)).axes
    assert [line.get_label() for line in alarm.get_lines()] == ["alarm of the chart"]
    assert [line.get_label() for line in stiffness.get_lines()] == ["stiffness, share of the initial one"]
    assert len(drawn("failure-detection", result()).axes) == 3


def test_what_is_varied_is_kept_in_the_plan() -> None:
    plan = planned(**ALONG, **SECOND)
    assert isinstance(plan.along, ParameterAxis) and plan.along.values == pytest.approx((0.01, 0.015, 0.02))
    assert plan.second.values == (190.0, 210.0) and plan.along.parameter.path == "drive.slope"


def test_the_stored_readings_are_noisy_about_the_speed() -> None:
    """The mean of 32 values with a standard deviation of 1 is 0 to within three times 0.18."""
    made = result()
    noise = made.reading.values - made.speed.values
    assert noise == pytest.approx(np.random.default_rng(0).normal(size=32)), "by the seed alone"
    assert 0.5 < noise.std() < 1.5


# --- schedules ---


@pytest.mark.parametrize(
    ("interpolation", "points", "begin", "end"),
    [
        ("steps", ((0.0, WHOLE), (4.0, 0.8 * WHOLE)), 4.0, 4.0),
        ("linear", ((1.0, WHOLE), (3.0, WHOLE), (3.5, 0.9 * WHOLE), (4.0, 0.5 * WHOLE), (6.0, 0.5 * WHOLE)), 3.0, 4.0),
    ],
)
def test_a_schedule_falls_between_its_changes(
    interpolation: str, points: tuple[tuple[float, float], ...], begin: float, end: float
) -> None:
    """And its share is that of the value with which it begins."""
    of = machine(*points, interpolation=interpolation)
    fall = STUDY.prepare(FailureDetection(**KEYS | {"after": 0.5, "learning": 2.0}), of).scheduled_fall
    assert (fall.begin, fall.end) == (begin, end)
    assert fall.share(np.array([0.0, begin - 1e-9, 7.0])) == pytest.approx([1.0, 1.0, points[-1][1] / WHOLE])


@pytest.mark.parametrize("at", [0.0, 8.0, 9.0])
def test_a_fall_at_the_beginning_or_at_the_end_of_the_run_is_refused(at: float) -> None:
    before = [] if at == 0.0 else [(0.0, WHOLE)]
    of = machine((-1.0, WHOLE), *before, (at, 0.8 * WHOLE))
    with refused("study.until", given=8.0):
        STUDY.prepare(FailureDetection(**KEYS), of)


def test_there_are_enough_readings_before_the_fall_and_in_half_of_the_time_after_it() -> None:
    """From 0.5 s to the fall at 4 s, and from 6 s to 8 s: the readings of 0.2 s are 17 and 10."""

    def prepared(interval: float, **other: Any) -> Any:
        sensor = KEYS["sensor"] | {"interval": interval}  # type: ignore[operator]
        return STUDY.prepare(FailureDetection(**KEYS | {"sensor": sensor} | other), MACHINE)

    most = 2.0 / FEWEST
    assert prepared(most)
    with refused("study.sensor.interval", f"{most:.4g}", given=1.01 * most):
        prepared(1.01 * most)
    late = 1.0 / FEWEST
    assert prepared(late, after=3.0)
    with refused("study.sensor.interval", f"{late:.4g}", given=1.01 * late):
        prepared(1.01 * late, after=3.0)
    with refused("study.sensor.interval", f"{late:.4g}", given=1.01 * late):
        prepared(1.01 * late, after=1.0, learning=1.0)
    with refused("study.after", "4", given=3.0):
        prepared(0.1, after=3.0, learning=1.01)
    assert prepared(0.1, after=3.0, learning=1.0)


FALL = SimpleNamespace(begin=4.0, end=5.0)


@pytest.mark.parametrize(
    ("fall", "broken", "gradual", "after", "learning", "end", "windows"),
    [
        (FALL, None, False, None, None, 8.0, ((2.0, 4.0), (6.5, 8.0), 4.0, 4.0)),
        (FALL, None, False, 1.0, 2.0, 8.0, ((1.0, 3.0), (6.5, 8.0), 4.0, 4.0)),
        (FALL, None, False, None, None, 4.5, ((2.0, 4.0), None, 4.0, 4.0)),
        (FALL, None, False, None, None, 3.0, ((2.0, 3.0), None, None, None)),
        (FALL, None, False, 3.5, None, 3.0, (None, None, None, None)),
        (None, 6.0, False, None, None, 10.0, ((3.0, 6.0), (8.0, 10.0), 6.0, 6.0)),
        (None, None, False, None, None, 10.0, ((5.0, 10.0), None, None, None)),
        (None, None, True, 1.0, 3.0, 10.0, ((1.0, 4.0), (7.0, 10.0), 4.0, None)),
        (None, 6.0, True, 1.0, 3.0, 10.0, ((1.0, 4.0), (8.0, 10.0), 4.0, 6.0)),
    ],
)
def test_when_the_speed_is_measured(
    fall: Any, broken: float | None, gradual: bool, after: float | None, learning: float | None, end: float, windows: Any
) -> None:
    """Before the failure from half of that time on; after it over the second half of the rest of the run so far."""
    spec = SimpleNamespace(after=after, learning=learning)
    failing = SimpleNamespace(course=SimpleNamespace(time=np.array([0.0, end])), state=SimpleNamespace(broken=broken))
    plan: Any = SimpleNamespace(spec=spec, scheduled_fall=fall, is_gradual=gradual)
    assert vars(run_module._windows(plan, failing)) == vars(Windows(*windows))


def test_the_extremes_of_a_reading_begin_after_the_sample_before_it() -> None:
    readings: Any = SimpleNamespace(speed=np.zeros(2))
    samples = np.array([9.0, 1.0, 2.0, 8.0, 3.0, 99.0])  # the last one is of a reading that is not complete
    assert over_readings(np.fmax, samples, readings) == pytest.approx([2.0, 8.0])
    assert over_readings(np.fmin, samples, readings) == pytest.approx([1.0, 3.0])
