"""Members of ensembles against run-ups, one by one."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht import RunUp
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, prepare_start, run_up
from wucht.dynamics.sampling import ensemble_run
from wucht.dynamics.sampling.ensemble_run import integration_note, outcomes_of
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine


def pendulums(u: float) -> Machine:
    return load_machine("drozdetskaya-2020/table-5.1").with_values({"u": u})


def grid(n: int) -> list[dict[str, float]]:
    places = (np.arange(n) + 0.5) / n
    return [{"psi": 2 * math.pi * p, "delta": math.pi * d} for d in places for p in places]


def states(machine: Machine, starts: Sequence[Mapping[str, Any]]) -> np.ndarray:
    return np.array([initial_state(machine, start) for start in starts]).T


def run_of(machine: Machine, start: Mapping[str, Any], model: Any = "slow", **end: Any) -> Motion:
    spec = RunUp(start=start, model=model, tolerance=1e-8, **end)
    *_, (motion,) = run_up(RunUpCase.of(machine, start, spec.settings), Work())
    return motion


def labels(outcomes: MemberOutcomes) -> list[str]:
    return [OUTCOMES[i].value for i in outcomes.outcome]


def same(a: MemberOutcomes, b: MemberOutcomes) -> bool:
    names = ("outcome", "settling_time", "peak_amplitude", "end_time")
    return all(np.array_equal(getattr(a, n), getattr(b, n), equal_nan=True) for n in names) and a.failures == b.failures


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "u"),
    [
        *(("slow", u) for u in (1.0, 2.5)),
        ("full", 1.0),
        ("full", 2.5),
    ],
)
def test_outcomes_are_those_of_run_ups(model: str, u: float) -> None:
    machine, starts = pendulums(u), grid(3)
    found = outcomes_of(EnsembleQuestion(machine, model=model, tolerance=1e-8), states(machine, starts), {})
    for i, start in enumerate(starts):
        motion = run_of(machine, start, model)
        assert labels(found)[i] == motion.verdict.outcome.value
        assert found.peak_amplitude[i] == pytest.approx(motion.observation.largest, rel=5e-3)
        # The course of a member is kept in 160 parts of its time, of which one or two settle it; so is that of a run-up.
        apart = 3 * found.end_time[i] / 160
        assert found.settling_time[i] == pytest.approx(motion.verdict.settling_time, abs=max(apart, 20.0))


@pytest.mark.slow
def test_a_member_does_not_depend_on_the_others() -> None:
    machine = pendulums(2.5)
    question, starts = EnsembleQuestion(machine, model="slow"), states(machine, grid(4))
    whole, order = outcomes_of(question, starts, {}), np.random.default_rng(1).permutation(16)
    assert same(outcomes_of(question, starts[:, order], {}), whole.select(order))
    assert same(outcomes_of(question, starts[:, 5:6], {}), whole.select(np.array([5])))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["practice/fan-on-belt", "practice/laundry-drum"])
def test_machines_of_piecewise_laws(name: str) -> None:
    """A belt; a schedule, contacts and a fan's load: in batches, with the labels of run-ups."""
    machine = load_machine(name)
    question = EnsembleQuestion(machine, tolerance=1e-8)
    assert integration_note(question) == "members are integrated in batches"
    found = outcomes_of(question, prepare_start(machine, {})[1][:, None], {})
    motion = run_of(machine, {}, "full", settled=True)
    assert labels(found) == [motion.verdict.outcome.value]
    assert found.peak_amplitude[0] == pytest.approx(motion.observation.largest, rel=1e-3)
    assert found.settling_time[0] == pytest.approx(motion.verdict.settling_time, abs=3 * found.end_time[0] / 160)


def test_a_schedule_is_waited_for() -> None:
    """The drive is switched on after 10 s, when a rotor that stands has been at rest for long."""
    drive = {"on": "a", "kind": "linear", "slope": 1e-3, "no_load_speed": 50.0}
    schedule = {"parameter": "drive.no_load_speed", "points": [[0.0, 1e-9], [10.0, 1e-9], [10.1, 50.0]]}
    machine = machine_from(SMOOTH | {"drive": drive, "schedules": [schedule]})
    question = EnsembleQuestion(machine, tolerance=1e-8)
    found = outcomes_of(question, initial_state(machine, {})[:, None], {})
    assert labels(found) == [run_of(machine, {}, "full", settled=True).verdict.outcome.value] == ["passed"]
    assert found.settling_time[0] > 10.0
    stopped = replace(question, machine=machine, until=9.0)
    assert labels(outcomes_of(stopped, initial_state(machine, {})[:, None], {})) != ["passed"]


SMOOTH = {
    "carrier": {"mass": 1.0, "directions": "x", "stiffness": 1e3, "damping": 5.0},
    "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01, "bearing_damping": 1e-4}],
    "drive": {"on": "a", "kind": "linear", "slope": 1e-3, "no_load_speed": 50.0},
}
BESIDE = SMOOTH["bodies"][0] | {"name": "b"}
SERIES = {
    "on": "a", "kind": "dc-series", "voltage": 42.0, "armature_resistance": 1.5, "field_resistance": 1.0,
    "field_inductance": 0.05, "motor_constant": 1.0,
}  # fmt: skip
SHAKEN = {"directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}}


@pytest.mark.parametrize("model", ["full", pytest.param("slow", marks=pytest.mark.slow)])
def test_a_mirrored_machine_comes_to_its_end_as_soon(model: Any) -> None:
    """It turns clockwise, with its pendulums on the other side."""
    found = []
    for sense in (1, -1):
        machine = load_machine("drozdetskaya-2020/r1-u80").with_values({"drive.no_load_speed": sense * 200.0})
        starts = states(machine, [{"p1": sense * 0.3, "p2": -sense * 0.5}, {"p1": sense * 2.0, "p2": sense * 2.5}])
        found.append(outcomes_of(EnsembleQuestion(machine, model=model, tolerance=1e-8), starts, {}))
    forward, backward = found
    assert labels(backward) == labels(forward) == ["compensated"] * 2
    assert backward.settling_time == pytest.approx(forward.settling_time)
    assert backward.peak_amplitude == pytest.approx(forward.peak_amplitude, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changed",
    [
        {"bodies": [*SMOOTH["bodies"], BESIDE]},
        {"carrier": SHAKEN},
        {"carrier": SHAKEN, "drive": {"kind": "constant-speed", "speed": 5.0}},
        {"drive": SERIES, "load": {"kind": "viscous", "coefficient": 0.02}},
        {"drive": SERIES, "load": {"kind": "quadratic", "coefficient": 2e-4}},
    ],
    ids=["two rotors", "entrained", "shaken", "series motor", "fan"],
)
def test_what_is_integrated_in_batches_has_the_labels_of_run_ups(changed: dict[str, Any]) -> None:
    machine = machine_from(SMOOTH | changed)
    question = EnsembleQuestion(machine, until=60.0, tolerance=1e-8)
    assert integration_note(question) == "members are integrated in batches"
    found = outcomes_of(question, states(machine, [{}]), {})
    alone = run_of(machine, {}, "full", until=60.0)
    assert labels(found) == [alone.verdict.outcome.value]
    assert found.peak_amplitude[0] == pytest.approx(alone.observation.largest, rel=1e-3)


@pytest.mark.slow
def test_a_member_that_fails_is_told_and_disturbs_no_other() -> None:
    machine = pendulums(1.0)
    starts = states(machine, grid(2))
    broken = starts.copy()
    broken[machine.state_names.index("rotor.speed"), 2] = 1e300
    question = EnsembleQuestion(machine, until=200.0)
    good, found = outcomes_of(question, starts, {}), outcomes_of(question, broken, {})
    assert labels(found)[2] == "failed" and [i for i, _ in found.failures] == [2]
    rest = np.array([0, 1, 3])
    assert same(replace(found, failures=()).select(rest), good.select(rest))


def test_a_member_that_only_passes_by_a_motion_that_goes_on_is_not_taken_for_it() -> None:
    # At u = 5.8 the survey finds starts that leave the modulated motion again: all of these compensate.
    machine, starts = pendulums(5.8), [{"psi": psi, "delta": delta} for psi, delta in ((0.3, 0.5), (2.0, 1.5), (4.0, 2.5))]
    found = outcomes_of(EnsembleQuestion(machine), states(machine, starts), {})
    assert labels(found) == [run_of(machine, start, "full", settled=True).verdict.outcome.value for start in starts]


def test_averaged_equations_are_those_of_the_sense_in_which_a_member_is_driven() -> None:
    machine, start = load_machine("drozdetskaya-2020/r1"), {"p1": 0.3, "p2": -0.5}
    path, speeds = "drive.no_load_speed", np.array([200.0, -150.0])
    question = EnsembleQuestion(machine, (path,), model="slow", tolerance=1e-8)
    found = outcomes_of(question, states(machine, [start] * 2), {path: speeds})
    for i, speed in enumerate(speeds.tolist()):
        alone = run_of(machine.with_values({path: speed}), start, settled=True)
        assert labels(found)[i] == alone.verdict.outcome.value
        assert found.settling_time[i] == pytest.approx(alone.verdict.settling_time, rel=0.05)


def test_a_rotor_that_still_rises_beyond_its_resonance_has_passed() -> None:
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier").with_values({"u": 3.0})
    start = {"rotor": {"angle": 1.0}}
    found = outcomes_of(EnsembleQuestion(machine, until=400 * math.pi), states(machine, [start]), {})
    assert labels(found) == [run_of(machine, start, "full", until=400 * math.pi).verdict.outcome.value] == ["passed"]


def test_a_modulation_of_two_cycles_is_not_classified_turn_by_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its speed has risen twice, both times in the last half: no verdict is possible. Of four cycles there is one."""
    machine, calls, classify = pendulums(2.5), list[int](), ensemble_run.classify_members

    def counted(question: EnsembleQuestion, starts: np.ndarray, *rest: Any) -> MemberOutcomes:
        calls.append(starts.shape[1])
        return classify(question, starts, *rest)

    monkeypatch.setattr(ensemble_run, "classify_members", counted)
    begins = states(machine, [{"p1": 5.2006, "p2": 5.8519}, {"p1": 0.6313, "p2": 4.2312}, {"p1": 0.565, "p2": 4.3018}])
    short = outcomes_of(EnsembleQuestion(machine, model="slow", until=2000.0), begins, {})
    assert labels(short) == ["unidentified"] * 3 and calls == []
    long = outcomes_of(EnsembleQuestion(machine, model="slow", until=3400.0), begins, {})
    assert labels(long) == ["captured-modulated"] * 3
