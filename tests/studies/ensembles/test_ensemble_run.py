"""Members of ensembles against run-ups, one by one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.ensembles.ensemble_question import EnsembleQuestion
from wucht.studies.ensembles.ensemble_run import outcomes_of, way_of
from wucht.studies.ensembles.member_outcomes import OUTCOMES, MemberOutcomes
from wucht.studies.initial_state import initial_state
from wucht.studies.run_up.prepare import prepare_case
from wucht.studies.run_up.run import Motion, run_case
from wucht.studies.run_up.spec import RunUp
from wucht.studies.work import Work


def pendulums(u: float) -> Machine:
    return load_machine("drozdetskaya-2020/table-5.1").with_values({"u": u})


def grid(n: int) -> list[dict[str, float]]:
    places = (np.arange(n) + 0.5) / n
    return [{"psi": 2 * math.pi * p, "delta": math.pi * d} for d in places for p in places]


def states(machine: Machine, starts: list[dict[str, float]]) -> np.ndarray:
    return np.array([initial_state(machine, start) for start in starts]).T


def run_up(machine: Machine, start: dict[str, float], model: str = "slow", **end: object) -> Motion:
    spec = RunUp(start=start, model=model, tolerance=1e-8, **end)
    *_, (motion,) = run_case(spec, prepare_case(spec, machine, start), Work())
    return motion


def labels(outcomes: MemberOutcomes) -> list[str]:
    return [OUTCOMES[i].value for i in outcomes.outcome]


def same(a: MemberOutcomes, b: MemberOutcomes) -> bool:
    names = ("outcome", "settling_time", "peak_amplitude", "end_time")
    return all(np.array_equal(getattr(a, n), getattr(b, n), equal_nan=True) for n in names) and a.failures == b.failures


@pytest.mark.parametrize(("model", "u"), [("slow", 1.0), ("slow", 2.5), ("full", 1.0), ("full", 2.5)])
def test_outcomes_are_those_of_run_ups(model: str, u: float) -> None:
    machine, starts = pendulums(u), grid(3)
    found = outcomes_of(EnsembleQuestion(machine, model=model, tolerance=1e-8), states(machine, starts), {})
    for i, start in enumerate(starts):
        motion = run_up(machine, start, model)
        assert labels(found)[i] == motion.verdict.outcome.value
        assert found.peak_amplitude[i] == pytest.approx(motion.observation.largest, rel=5e-3)
        # The course of a member is kept in 160 parts of its time, of which one or two settle it; so is that of a run-up.
        apart = 3 * found.end_time[i] / 160
        assert found.settling_time[i] == pytest.approx(motion.verdict.settling_time, abs=max(apart, 20.0))


def test_a_member_does_not_depend_on_the_others() -> None:
    machine = pendulums(2.5)
    question, starts = EnsembleQuestion(machine, model="slow"), states(machine, grid(4))
    whole, order = outcomes_of(question, starts, {}), np.random.default_rng(1).permutation(16)
    assert same(outcomes_of(question, starts[:, order], {}), whole.taken(order))
    assert same(outcomes_of(question, starts[:, 5:6], {}), whole.taken(np.array([5])))


def test_parameters_differ_from_member_to_member() -> None:
    machine, start = pendulums(1.0), {"psi": 0.0, "delta": 0.5}
    u, beta = np.array([1.0, 3.5, 1.0, 5.0]), np.array([0.1, 0.1, 0.2, 0.1])
    question = EnsembleQuestion(machine, ("u", "beta_r"), model="slow")
    found = outcomes_of(question, states(machine, [start] * 4), {"u": u, "beta_r": beta})
    for i in range(4):
        one = machine.with_values({"u": float(u[i]), "beta_r": float(beta[i])})
        alone = outcomes_of(EnsembleQuestion(one, model="slow"), states(one, [start]), {})
        assert same(alone, found.taken(np.array([i])))
    assert labels(found) == ["captured", "compensated", "captured", "compensated"]


def test_at_a_given_end_what_is_not_settled_is_not_identified() -> None:
    machine = pendulums(1.0)
    begun = states(machine, grid(3))
    short, long = (outcomes_of(EnsembleQuestion(machine, model="slow", until=end), begun, {}) for end in (30.0, 4000.0))
    assert set(labels(short)) == {"unidentified"} and np.isnan(short.settling_time).all()
    assert (short.end_time == 30.0).all() and "captured" in labels(long)


def test_a_machine_with_contacts_is_run_up_member_by_member() -> None:
    machine = load_machine("practice/laundry-drum")
    question = EnsembleQuestion(machine, until=2.0, tolerance=1e-8)
    assert way_of(question) == "members are run up one by one, which is slower: it has contacts, schedules or tables"
    found = outcomes_of(question, initial_state(machine, {})[:, None], {})
    assert labels(found) == [run_up(machine, {}, "full", until=2.0).verdict.outcome.value]
    assert way_of(replace(question, machine=pendulums(1.0))) == "members are integrated in batches"


def test_a_member_that_fails_is_told_and_disturbs_no_other() -> None:
    machine = pendulums(1.0)
    starts = states(machine, grid(2))
    broken = starts.copy()
    broken[machine.state_names.index("rotor.speed"), 2] = 1e300
    question = EnsembleQuestion(machine, until=200.0)
    good, found = outcomes_of(question, starts, {}), outcomes_of(question, broken, {})
    assert labels(found)[2] == "failed" and [i for i, _ in found.failures] == [2]
    rest = np.array([0, 1, 3])
    assert same(replace(found, failures=()).taken(rest), good.taken(rest))
