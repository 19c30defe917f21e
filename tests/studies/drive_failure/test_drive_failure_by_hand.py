"""Failures of two drives in two configurations that are made by hand: rows, courses, sentences, warnings, report, figure."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, titled, warnings_of

from wucht.analysis.throw import Throw
from wucht.dynamics.run_ups import drive_losses
from wucht.dynamics.run_ups.drive_losses import RunningState
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.machines.parts import drives
from wucht.studies.drive_failure import computation, figure
from wucht.studies.drive_failure import dataset as module
from wucht.studies.drive_failure.computation import FailureRun, Findings, OperationPlan, OperationRun, Plan
from wucht.studies.drive_failure.spec import DriveFailure

SCREEN = load_machine("practice/screen")
E1, E2 = SCREEN.drives
LABELS = ("in phase", "opposed")
SPEEDS = {"e1": -150.0, "e2": 151.0}
BEFORE = MotionCourse(np.arange(5.0), np.array([[-150.0] * 5, [151.0] * 5]), np.full(5, 1e-3))
AFTER = MotionCourse(
    np.array([2.0, 4.0, 8.0]), np.array([[-140.0, -130.0, -130.0], [140.0, 30.0, 0.0]]), np.array([4e-3, 3e-3, 2e-3])
)


def state(outcome: Outcome = Outcome.SYNCHRONISED, **other: Any) -> RunningState:
    throw = Throw(stroke=5e-3, across=1e-3, direction=math.radians(-30), acceleration=1.0)
    phases = {"e2": math.radians(350), "ball": math.radians(20)} if outcome is Outcome.SYNCHRONISED else None
    given: Any = {"speeds": SPEEDS, "phases": phases, "throw": throw, "amplitude": 2e-3, "torques": {"e1": -1.5, "e2": 0.5}}
    return RunningState(outcome, f"they are {outcome}", **given | other)


def motion(made: RunningState, course: MotionCourse, end: float, advice: str | None = None, failure: str | None = None) -> Any:
    verdict = SimpleNamespace(advice=advice, needed_time=7 * end, settling_time=0.5 * end)
    seen = SimpleNamespace(largest=6e-3)
    trajectory = SimpleNamespace(end_time=end, failure=failure)
    case = SimpleNamespace(machine=SCREEN)
    return SimpleNamespace(case=case, verdict=verdict, trajectory=trajectory, observation=seen, made=made, course=course)


@pytest.fixture(autouse=True)
def _states_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_state_of", lambda _plan, of: of.made)
    courses = SimpleNamespace(from_turns=lambda _machine, of, _observation: of.course)
    monkeypatch.setattr(module, "MotionCourse", courses)


def findings(count: int = 2, *failures: tuple[Outcome, str | None], labels: tuple[str, ...] = LABELS) -> tuple[Plan, Findings]:
    """failures: outcome and advice of each, first those in the first configuration. count: of operations so far."""
    given = iter(failures or [(Outcome.SYNCHRONISED, None)] * 4)
    plans = tuple(OperationPlan(SimpleNamespace(machine=SCREEN), label) for label in labels)  # type: ignore[arg-type]
    operations, made = list[OperationRun](), 0
    for k, plan in enumerate(plans[:count]):
        before = motion(state(amplitude=(1 + k) * 1e-3, torques={"e1": -1.0 - k, "e2": 1.25}), BEFORE, 4.0 + k)
        before.trajectory.course = BEFORE
        runs = list[FailureRun]()
        for drive, (outcome, advice) in zip((E1, E2), given, strict=False):
            after = motion(state(outcome), AFTER, 8.0 + made, advice)
            after.trajectory.course = AFTER
            runs.append(FailureRun(drive, after))
            made += 1
        operations.append(OperationRun(plan, before, tuple(runs)))
    return Plan(DriveFailure(), SCREEN, plans, (E1, E2)), Findings(tuple(operations), made)


def answered(*given: Any, reason: str = "", **labels: Any) -> xr.Dataset:
    plan, made = findings(*given, **labels)
    return titled(module.dataset(replace(plan, reason=reason), made))


def test_each_failure_in_each_configuration_has_a_row() -> None:
    s = answered().wucht.summary
    assert [(row["configuration"], row["drive"]) for row in s["cases"]] == [(c, d) for c in LABELS for d in ("e1", "e2")]
    assert s["failure_times"] == [4.0, 5.0]
    assert [row["end_time"] for row in s["cases"]] == [8.0, 9.0, 10.0, 11.0]
    row = s["cases"][0]
    expected = {
        "speed": 150.0,
        "speeds": SPEEDS,
        "throw": 5e-3,
        "amplitude": 2e-3,
        "peak_amplitude": 6e-3,
        "advised_time": 56.0,
    }
    assert {key: row[key] for key in expected} == expected and row["throw_direction"] == pytest.approx(math.radians(-30))
    assert [o["amplitude"] for o in s["operation"]] == [1e-3, 2e-3] and "peak_amplitude" not in s["operation"][0]
    apart = answered(1, (Outcome.NOT_SYNCHRONISED, None)).wucht.summary["cases"][0]
    assert (apart["speed"], apart["phases"], apart["sentence"]) == (None, None, "they are not-synchronised")


def test_without_a_throw_there_is_no_direction() -> None:
    plan, made = findings(1)
    made.operations[0].motion.made = state(throw=None)  # type: ignore[attr-defined]
    made.operations[0].failures[0].motion.made = state(throw=Throw(0.0, 0.0, 0.5, 0.0))  # type: ignore[attr-defined]
    s = module.dataset(plan, made).wucht.summary
    assert (s["operation"][0]["throw"], s["operation"][0]["throw_direction"]) == (None, None)
    assert (s["cases"][0]["throw"], s["cases"][0]["throw_direction"]) == (0.0, None)


def test_a_quarter_of_the_time_after_the_failure_is_kept_of_that_before() -> None:
    """8 s after it; so 2 s before 4 s, and before 5 s, of which the course has only those until 4 s."""
    result = answered()
    assert result.time.values[0] == pytest.approx([-2.0, -1.0, 0.0, 2.0, 4.0, 8.0])
    assert result.time.values[2] == pytest.approx([-2.0, -1.0, 2.0, 4.0, 8.0, np.nan], nan_ok=True)
    assert result.rotor_speed.values[0].tolist() == [[-150.0] * 3 + [-140.0, -130.0, -130.0], [151.0] * 3 + [140.0, 30.0, 0.0]]
    assert result.amplitude.values[0].tolist() == [1e-3] * 3 + [4e-3, 3e-3, 2e-3]


def test_torques_before_and_after_each_failure() -> None:
    result = answered()
    assert result.operation_torque.values.tolist() == [[-1.0, 1.25]] * 2 + [[-2.0, 1.25]] * 2
    assert result.drive_torque.values.tolist() == [[-1.5, 0.5]] * 4
    assert result.drive.values.tolist() == ["e1", "e2"]


LOST, OPEN, KEPT = (Outcome.NOT_SYNCHRONISED, None), (Outcome.UNIDENTIFIED, "run on"), (Outcome.SYNCHRONISED, None)


@pytest.mark.parametrize(
    ("outcomes", "sentence", "outcome"),
    [
        ([KEPT, KEPT], "the rotors stay synchronised whichever drive fails", "synchronised"),
        ([KEPT], "the rotors stay synchronised whichever of the drives fails", "synchronised"),
        ([KEPT, LOST], "the rotors stay synchronised without the drive of e1; not synchronised without that of e2", "several"),
        ([LOST, LOST], "the rotors are not synchronised any more without the drive of e1 or e2", "not-synchronised"),
        ([KEPT, OPEN], "the rotors stay synchronised without the drive of e1; undecided without that of e2", "several"),
        ([(Outcome.FAILED, None), LOST], "the rotors are not synchronised any more without the drive of e2; "
         "undecided without that of e1", "several"),
    ],
)  # fmt: skip
def test_sentences(outcomes: list[Any], sentence: str, outcome: str) -> None:
    result = answered(1, *outcomes, labels=("in phase",))
    assert (result.attrs["sentence"], result.attrs["outcome"]) == (sentence, outcome)


def test_a_drive_is_named_once_in_all_configurations() -> None:
    assert answered(2, LOST, KEPT, LOST, KEPT).attrs["sentence"] == (
        "the rotors stay synchronised without the drive of e2; not synchronised without that of e1"
    )
    plan, made = findings(0)
    assert module.dataset(plan, made).attrs["sentence"] == "no drive has failed yet"


def test_warnings() -> None:
    assert warnings_of(answered()) == []
    assert warnings_of(answered(1)) == ["2 of 4 failures are computed"], "both configurations count"
    assert warnings_of(answered(2, OPEN, KEPT, OPEN, LOST)) == ["without e1: run on"], "each sentence once"
    assert warnings_of(answered(reason="it is not linear")) == ["the machine is run up from rest: it is not linear"]
    plan, made = findings()
    first = made.operations[0]
    resting = replace(plan, operations=(replace(plan.operations[0], rest_reason="has no linear carrier"), plan.operations[1]))
    first.motion.made = state(Outcome.NOT_SYNCHRONISED)  # type: ignore[attr-defined]
    first.motion.verdict.advice = "run longer"  # type: ignore[misc]
    made.operations[1].failures[1].motion.trajectory.failure = "it burst"  # type: ignore[misc]
    result = module.dataset(resting, made)
    assert warnings_of(result) == [
        "it burst",
        "the carrier begins at rest: the machine has no linear carrier",
        "before the failure (in phase) the verdict on the machine is not-synchronised: run longer",
    ]
    assert result.attrs["failure"] == "it burst"


def test_how_the_machine_begins() -> None:
    (both,) = answered().wucht.assumed
    assert both.startswith("the machine begins in each of the stable synchronous configurations in phase and opposed")
    (one,) = answered(1, labels=("in phase",)).wucht.assumed
    assert one.startswith("the machine begins in the stable synchronous configuration in phase")
    assert answered(1, labels=("",)).wucht.assumed == ["the machine is run up from rest, at the phases of the start"]


def test_the_lines_of_the_report() -> None:
    lines = module.report(answered(2, KEPT, LOST, KEPT, KEPT))[2:]
    assert lines[:4] == [
        "  before       150 rad/s (1432 rpm), throw 5 mm at -30.0°, phase e2 -10°, ball 20°, amplitude 1 mm",
        "  motors       e1: -1 N m, e2: 1.25 N m; a drive fails at 4 s",
        "  without e1   SYNCHRONISED (in phase): 150 rad/s (1432 rpm), throw 5 mm at -30.0°, phase e2 -10°, ball 20°, "
        "amplitude 6 mm at most",
        "  motors       e1: -1.5 N m, e2: 0.5 N m",
    ]
    assert lines[4] == (
        "  without e2   NOT-SYNCHRONISED (in phase): e1: -150 rad/s (-1432 rpm), e2: 151 rad/s (1442 rpm); "
        "throw 5 mm at -30.0°, amplitude 6 mm at most"
    )
    assert len(lines) == 12 and lines[6].endswith("amplitude 2 mm") and lines[7].endswith("fails at 5 s")
    assert lines[8].startswith("  without e1   SYNCHRONISED (opposed)")
    (alone,) = (x for x in module.report(answered(1, KEPT, labels=("in phase",))) if "without e1" in x)
    assert alone.startswith("  without e1   SYNCHRONISED: 150")


def test_what_each_panel_shows() -> None:
    result = answered(1, KEPT, LOST, labels=("in phase",))
    result.amplitude.values[1] *= 2
    axes = drawn("drive-failure", result).axes
    first, second, amplitudes, torques = axes[:4]
    time = [-2.0, -1.0, 0.0, 2.0, 4.0, 8.0]
    for axis, failing in ((first, "e1"), (second, "e2")):
        lines = {str(x.get_label()): np.asarray(x.get_ydata(), float).tolist() for x in axis.get_lines()}
        assert lines["e1"] == [150.0] * 3 + [140.0, 130.0, 130.0], "forwards"
        assert lines["e2"] == [151.0] * 3 + [140.0, 30.0, 0.0] and f"{failing} fails" in lines
        assert np.asarray(axis.get_lines()[0].get_xdata()).tolist() == time
    drawn_amplitudes = {str(x.get_label()): np.asarray(x.get_ydata(), float) for x in amplitudes.get_lines()}
    assert drawn_amplitudes["e1 fails"] == pytest.approx([1.0] * 3 + [4.0, 3.0, 2.0])
    assert drawn_amplitudes["e2 fails"] == pytest.approx([2.0] * 3 + [8.0, 6.0, 4.0])
    assert first.get_xlim() == amplitudes.get_xlim() == (pytest.approx(-1.2), pytest.approx(8.0)), "e2 changes until 4 s"
    heights = [patch.get_height() for patch in torques.patches]
    assert heights == [1.0, 1.25, 1.0, 1.25, 1.5, 0.5, 1.5, 0.5], "before, and after"
    assert [str(x.get_text()) for x in torques.get_legend().get_texts()] == ["before the failure", "after it"]
    assert [x.get_text() for x in torques.get_xticklabels()] == [
        f"{drive}\nif {failing}\nfails" for failing in ("e1", "e2") for drive in ("e1", "e2")
    ]
    places = [patch.get_x() + patch.get_width() for patch in torques.patches[:4]]
    assert places == pytest.approx(torques.get_xticks().tolist()) and np.diff(places) == pytest.approx([1.0, 1.5, 1.0])


@pytest.mark.parametrize(("last", "right"), [(0.0, 5.0), (2.0, 5.0), (10.0, 20.0), (80.0, 100.0)])
@pytest.mark.parametrize("where", [0, 1, 2])
def test_the_time_in_which_nothing_happens_is_not_drawn(where: int, last: float, right: float) -> None:
    """Twice the time until which a speed, or the amplitude, of any case still changes is; a twentieth of all at least."""
    time = np.concatenate([[-50.0, -1.0], np.arange(0.0, 101.0)])
    rows = np.tile(np.array([100.0, -50.0, 1e-3])[:, None], (1, len(time)))
    rows[where, time <= last] *= 1.5
    quiet = np.tile(np.array([100.0, -50.0, 1e-3])[:, None], (1, len(time)))
    both = np.array([quiet, rows if last else quiet])
    result = xr.Dataset({
        "time": (("case", "sample"), np.array([time, time])), "rotor_speed": (("case", "rotor", "sample"), both[:, :2]),
        "amplitude": (("case", "sample"), both[:, 2]),
    })  # fmt: skip
    assert figure._limits(result) == (pytest.approx(-0.15 * right), pytest.approx(right))


# --- run after run ---


class NamedWork:
    """Work that knows its name among the units, and its share of the progress."""

    def __init__(self, name: str = "", begin: float = 0.0, end: float = 1.0) -> None:
        self.name, self.begin, self.end = name, begin, end

    def part(self, name: str, begin: float, end: float) -> NamedWork:
        width = self.end - self.begin
        return NamedWork(f"{self.name}/{name}".strip("/"), self.begin + begin * width, self.begin + end * width)


@pytest.mark.parametrize("count", [1, 2])
def test_each_drive_fails_after_each_run_until_then(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    """All have names of their own, so that each is resumed as itself, and follow each other in the progress."""
    parts = list[NamedWork]()

    def run_up(case: str, work: NamedWork) -> Any:
        parts.append(work)
        for leg in (1, 2):
            yield (SimpleNamespace(case=case, leg=leg, trajectory=SimpleNamespace(failure=None)),)

    monkeypatch.setattr(computation, "run_up", run_up)
    monkeypatch.setattr(computation, "case_without_drive", lambda motion, drive, _: f"{motion.case} without {drive.on}")
    plans: Any = tuple(OperationPlan(f"run {k}", "") for k in range(count))  # type: ignore[arg-type]
    *earlier, last = computation.run(Plan(DriveFailure(), SCREEN, plans, (E1, E2)), NamedWork())  # type: ignore[arg-type]
    for k, operation in enumerate(last.operations):
        assert (operation.motion.case, operation.motion.leg) == (f"run {k}", 2)
        failures = [(f.drive.on, f.motion.case, f.motion.leg) for f in operation.failures]
        assert failures == [(d, f"run {k} without {d}", 2) for d in ("e1", "e2")]
    assert last.finished_count == 2 * count == len(last.operations) * 2
    so_far = [(len(f.operations), len(f.operations[-1].failures), f.finished_count) for f in earlier[:6]]
    assert so_far == [(1, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 0), (1, 2, 1), (1, 2, 1)]
    names = [work.name for work in parts]
    if count == 1:
        assert names == ["operation", "operation/without e1", "operation/without e2"]
    assert len(set(names)) == 3 * count
    assert [w.begin for w in parts[1:]] == pytest.approx([w.end for w in parts[:-1]])
    assert (parts[0].begin, parts[-1].end) == (0.0, pytest.approx(1.0))


def test_after_a_run_that_fails_no_drive_does(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = SimpleNamespace(trajectory=SimpleNamespace(failure="it burst"))
    monkeypatch.setattr(computation, "run_up", lambda case, work: iter([(broken,)]))
    plans: Any = (OperationPlan("run", ""),)  # type: ignore[arg-type]
    *_, last = computation.run(Plan(DriveFailure(), SCREEN, plans, (E1, E2)), NamedWork())  # type: ignore[arg-type]
    assert (last.operations[0].failures, last.finished_count) == ((), 0)


# --- the state in which a motion ends ---


def test_the_main_rotor_that_rests_is_not_the_verdict_on_several_that_turn() -> None:
    bodies = ["a", "b", "c"]
    machine: Any = SimpleNamespace(rotor=SimpleNamespace(name="a"), rotors=[SimpleNamespace(name=b) for b in bodies])
    time, turn = np.array([0.0, 2.0]), math.pi

    def told(outcome: Outcome, **speeds: float) -> tuple[Outcome, str]:
        return drive_losses._outcome(machine, outcome, "as ever", time, speeds)

    assert told(Outcome.STOPPED, a=0.0, b=-1.01 * turn, c=5.0) == (Outcome.NOT_SYNCHRONISED, "a stops, b, c turn")
    assert told(Outcome.OSCILLATING, a=0.0, b=-turn, c=0.99 * turn) == (Outcome.NOT_SYNCHRONISED, "a oscillates, b turns")
    assert told(Outcome.STOPPED, a=0.0, b=0.99 * turn, c=0.0) == (Outcome.STOPPED, "as ever")
    assert told(Outcome.SYNCHRONISED, a=9.0, b=9.0, c=9.0) == (Outcome.SYNCHRONISED, "as ever")


def test_the_mean_torque_of_a_clockwise_drive_behind_a_gear() -> None:
    """On its body: it is the motor's torque times the ratio, and pushes clockwise."""
    carrier, *bodies = SCREEN.parts[:3]
    linear = drives()["linear"]
    motors = [
        linear(on="e1", slope=0.1, no_load_speed=-300.0, transmission={"ratio": 2.0}),
        linear(on="e2", slope=0.1, no_load_speed=160.0),
    ]
    machine, time = Machine(carrier, bodies, motors), np.linspace(0.0, 1.0, 50)
    states = np.zeros((len(machine.state_names), len(time)))
    states[machine.row(machine.body("e1").coordinate.velocity)] = -90.0
    states[machine.row(machine.body("e2").coordinate.velocity)] = 150.0
    values = np.array(machine.system.values(machine.values))
    torques = drive_losses.mean_torques(machine, machine.drives, time, states, values)
    assert torques == pytest.approx({"e1": -2 * 0.1 * (300 - 2 * 90), "e2": 0.1 * (160 - 150)})


def running(
    locking: Any = None,
    outcome: Outcome = Outcome.SYNCHRONISED,
    window: tuple[float, float] = (2.0, 3.0),
    tolerance: float = 1e-12,
) -> RunningState:
    """e1 turns clockwise with 40 rad/s until 2 s, then with 20; the carrier swings by 1 mm in x until 2 s, then by 2 mm."""
    time = np.linspace(0.0, 4.0, 401)
    states = np.zeros((len(SCREEN.state_names), len(time)))
    rows = [SCREEN.row(SCREEN.body(n).coordinate.position) for n in ("e1", "e2")]
    states[rows[0]] = np.where(time < 2.0, 7 - 40 * time, 7 - 80 - 20 * (time - 2.0))
    states[rows[1]] = 30 * time
    size, (x, *_) = np.where(time < 2.0, 1e-3, 2e-3), SCREEN.carrier
    states[[SCREEN.row(x.position), SCREEN.row(x.velocity)]] = size * np.sin(40 * time), 40 * size * np.cos(40 * time)
    spans = SimpleNamespace(time=np.array([1.0, 2.5, 3.5]), greatest_distance=np.array([9e-3, 4e-3, 3e-3]))
    verdict = SimpleNamespace(outcome=outcome, sentence="as ever", window=window, locking=locking, phases={"ball": 0.5})
    values = np.array(SCREEN.system.values(SCREEN.values))
    made: Any = SimpleNamespace(
        case=SimpleNamespace(machine=SCREEN), verdict=verdict,
        trajectory=SimpleNamespace(time=time, states=states, final_parameter_values=values),
        observation=SimpleNamespace(main=SimpleNamespace(last=lambda share: spans), largest=9e-3),
        compiled_system=SimpleNamespace(tolerance=tolerance),
    )  # fmt: skip
    return RunningState.of(made, SCREEN.drives)


def test_a_machine_runs_as_in_the_window_of_its_verdict() -> None:
    told = running(outcome=Outcome.NOT_SYNCHRONISED)
    assert told.speeds == pytest.approx({"e1": -20.0, "e2": 30.0}) and told.phases is None
    assert told.amplitude == 4e-3, "the largest from its begin on"
    assert told.throw is not None and told.throw.stroke == pytest.approx(4e-3, rel=1e-3)
    early = running(outcome=Outcome.NOT_SYNCHRONISED, window=(0.0, 1.9))
    assert early.speeds["e1"] == pytest.approx(-40.0) and early.throw is not None
    assert early.throw.stroke == pytest.approx(2e-3, rel=1e-3)
    few = running(outcome=Outcome.NOT_SYNCHRONISED, window=(5.0, 6.0))
    assert few.speeds["e1"] == pytest.approx(-20.0), "else the last samples"
    assert set(told.torques) == {"e1", "e2"}
    coarse = running(tolerance=0.05).throw
    assert coarse is not None and (coarse.stroke, coarse.direction) == (0.0, None), "ten times that of 9 mm are noise"


def test_locked_rotors_have_the_phases_of_rotors_and_bodies() -> None:
    locking = SimpleNamespace(final_speeds={"e1": -21.0, "e2": 21.0}, phases={"e2": 0.25}, window=(1.0, 3.0))
    told = running(locking)
    assert told.phases == {"e2": 0.25, "ball": 0.5} and told.speeds == {"e1": -21.0, "e2": 21.0}
    assert running(locking, Outcome.NOT_SYNCHRONISED).phases is None


def test_a_carrier_that_does_not_translate_has_no_throw() -> None:
    time = np.linspace(0.0, 1.0, 41)

    def told(labels: tuple[str, ...], shaken: str = "", dimensionless: bool = False) -> Throw | None:
        carrier = [
            SimpleNamespace(position=f"{n}", velocity=f"v{n}", prescribed_velocity=1.0 if n == shaken else None) for n in labels
        ]
        rows = {name: i for i, name in enumerate(n for label in labels for n in (label, f"v{label}"))}
        free = tuple(n for n in labels if n != shaken)
        machine: Any = SimpleNamespace(
            dimensionless=dimensionless, labels=labels, free_labels=free, carrier=carrier, row=rows.__getitem__
        )
        states = np.array([f(40 * time) * s for f, s in ((np.sin, 1e-3), (np.cos, 40e-3))] * len(labels))
        return drive_losses._throw(machine, time, states)

    across = told(("y",))
    assert across is not None and across.direction == pytest.approx(math.pi / 2)
    both = told(("x", "y"))
    assert both is not None and both.direction == pytest.approx(math.pi / 4)
    shaken = told(("x", "y"), shaken="x")
    assert shaken is not None and shaken.direction == pytest.approx(math.pi / 2), "it is that of the free motion"
    assert told(("r",)) is None and told(("x",), dimensionless=True) is None
