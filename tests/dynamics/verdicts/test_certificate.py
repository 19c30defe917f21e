"""Like bodies that move together: a verdict is given only if they stay together.

The machine: two equal pendulums that fall together at the resonance of an anisotropic carrier and leave each other slowly.
A Runge-Kutta program of its own (two steps) and runs of 200 and 600 s say that it is compensated, at 108.24 rad/s.
"""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up import RunSettings, run_to_end
from wucht.dynamics.sampling.ensemble_run import outcomes_of
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.verdicts.certificate import like_pairs
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, OUTCOMES, Outcome
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrap_to_pi

START = {"p1": {"angle": 1.7158}, "p2": {"angle": 3.54888}}
CAPTURED = OUTCOMES.index(Outcome.CAPTURED_MODULATED)


MACHINE = """
[machine.carrier]
mass = 12.0
directions = "xy"
stiffness = [3.0e4, 4.0e4]
damping = [80.0, 100.0]
[[machine.bodies]]
kind = "rotor"
name = "r"
mass = 3.0
unbalance = 0.0171635
inertia = 0.04
bearing_damping = 1e-4
[[machine.bodies]]
kind = "pendulum"
name = "p1"
about = "r"
mass = 0.12
length = 0.1
damping = 0.015
[[machine.bodies]]
kind = "pendulum"
name = "p2"
about = "r"
mass = 0.12
length = 0.1
damping = 0.015
[machine.drive]
on = "r"
kind = "linear"
slope = 0.00616
no_load_speed = 110.0
"""


def machine(damping: float = 0.015, mismatch: float = 0.0, **values: float) -> Machine:
    """Return the machine. mismatch: of the masses of the pendulums, as a share. values: of other parameters, by path."""
    pendulums = {"p1.damping": damping, "p2.damping": damping, "p2.mass": 0.12 * (1 + mismatch)}
    return machine_from(tomllib.loads(MACHINE)["machine"]).with_values(pendulums | values)


def start(angles: np.ndarray) -> dict[str, Any]:
    return {name: {"angle": float(angle)} for name, angle in zip(("p1", "p2"), angles, strict=True)}


def states(of: Machine, angles: np.ndarray) -> np.ndarray:
    """The states (n, M) in which members start, with the pendulums at angles (M, 2)."""
    return np.stack([initial_state(of, start(pair)) for pair in angles], axis=1)


@pytest.mark.slow
def test_a_run_until_settled_waits_until_the_pendulums_have_left_each_other() -> None:
    for mismatch in (0.0, 1e-6):
        motion = run_to_end(machine(mismatch=mismatch), START)
        assert motion.verdict.outcome is Outcome.COMPENSATED, mismatch
        assert motion.verdict.speed == pytest.approx(108.24, abs=0.01)


def test_a_shorter_run_is_open_with_the_time_at_which_they_part() -> None:
    """The pendulums leave each other at 0.15 /s, from 6e-9 rad at 23 s: to a radian until 150 s, compensated at 176 s."""
    of = machine()
    verdict = run_to_end(of, START, RunSettings(until=23.0)).verdict
    assert verdict.outcome is Outcome.UNIDENTIFIED and verdict.settling_time is None
    assert verdict.growth_rate == pytest.approx(0.15, rel=0.05)
    assert verdict.needed_time == pytest.approx(150.0, rel=0.1)
    assert verdict.advice is not None and "p1 and p2 are alike and move together" in verdict.advice
    longer = run_to_end(of, START, RunSettings(until=100.0))
    names = list(of.state_names)
    first, second = (longer.trajectory.states[names.index(f"{p}.angle")] for p in ("p1", "p2"))
    differences, time = np.abs(wrap_to_pi(first - second)), longer.trajectory.time
    sizes = [float(differences[(time > t) & (time <= t + 10)].max()) for t in (50.0, 90.0)]
    assert np.log(sizes[1] / sizes[0]) / 40 == pytest.approx(verdict.growth_rate, rel=0.1)  # the rate of the record itself


@pytest.mark.parametrize(("damping", "stays"), [(0.01505, False), (0.0152, True)])
def test_the_outcome_is_known_where_the_pendulums_stay_together(damping: float, stays: bool) -> None:
    """On both sides of the edge, at 0.01513 N m s/rad; a run of 600 s says the same."""
    of = machine(damping)
    first = run_to_end(of, START, RunSettings(until=23.0)).verdict
    assert (first.outcome is Outcome.CAPTURED_MODULATED) == stays and (first.growth_rate is None) == stays
    assert (run_to_end(of, START, RunSettings(until=600.0)).verdict.outcome is Outcome.CAPTURED_MODULATED) == stays


def test_pendulums_that_have_become_one_never_part_and_no_longer_run_is_advised() -> None:
    """Equal to the last bit they remain so in every run; with the least difference of their masses they part."""
    alike = start(np.array([1.7158, 1.7158]))
    motion = run_to_end(machine(), alike)
    verdict = motion.verdict
    assert verdict.outcome is Outcome.UNIDENTIFIED and verdict.needed_time is None and verdict.never_parts
    assert verdict.advice is not None and "differ by a millionth" in verdict.advice and "move as one" in verdict.sentence
    assert motion.trajectory.end_time < 50.0
    assert run_to_end(machine(mismatch=1e-6), alike).verdict.outcome is Outcome.COMPENSATED


@pytest.mark.parametrize(("tracks", "count"), [(("ring", "ring"), 0), (("ring", "other"), 1), ((None, None), 1)])
def test_balls_of_one_track_cannot_move_as_one(tracks: tuple[str | None, str | None], count: int) -> None:
    table = {"kind": "pendulum", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 1e-3}
    balls = [table | {"name": f"b{k}"} | ({"track": t, "diameter": 0.02} if t else {}) for k, t in enumerate(tracks)]
    drum = {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": 0.02, "inertia": 0.1}
    of = machine_from({"carrier": {"mass": 10.0, "stiffness": 2e4}, "bodies": [drum, *balls]})
    assert len(like_pairs(of, of.state_names)) == count


def machines_near_the_edge(seed: int, count: int) -> list[tuple[Machine, dict[str, Any]]]:
    """Machines near the edge at which the pendulums leave each other, with equal and nearly equal pendulums, and starts."""
    rng = np.random.default_rng(seed)
    return [
        (
            machine(
                rng.uniform(0.0145, 0.0160),
                float(rng.choice([0.0, 1e-6, 1e-4, 1e-3])),
                **{"r.unbalance": rng.uniform(0.0168, 0.0178), "drive.slope": rng.uniform(0.0061, 0.0063)},
            ),
            start(rng.uniform(0, 2 * np.pi, 2)),
        )
        for _ in range(count)
    ]


def outcomes(of: Machine, begin: dict[str, Any], until: float) -> tuple[Outcome, Outcome]:
    """The outcome of a run until settled, and of one until a time, far longer than the settled ones take."""
    return tuple(run_to_end(of, begin, RunSettings(until=t)).verdict.outcome for t in (None, until))  # type: ignore[return-value]


def contradict(settled: Outcome, late: Outcome) -> bool:
    return settled is not late and settled not in OPEN_OUTCOMES and late not in OPEN_OUTCOMES


@pytest.mark.slow
def test_settled_and_long_runs_of_fifty_machines_do_not_contradict_each_other() -> None:
    found = [outcomes(*of, until=1000.0) for of in machines_near_the_edge(7, 50)]
    assert not any(contradict(*pair) for pair in found)
    assert sum(settled not in OPEN_OUTCOMES for settled, _ in found) >= 45


@pytest.mark.slow
def test_ensembles_until_settled_agree_with_long_ones() -> None:
    """Member by member, on both sides of the edge and with random dampings across it."""
    rng = np.random.default_rng(11)
    angles, dampings = rng.uniform(0, 2 * np.pi, (64, 2)), rng.uniform(0.0146, 0.0158, 64)
    of = machine(mismatch=1e-4)
    question = EnsembleQuestion(of, ("p1.damping", "p2.damping"))
    values = {"p1.damping": dampings, "p2.damping": dampings}
    settled = outcomes_of(question, states(of, angles), values).outcome
    late = outcomes_of(replace(question, until=1500.0), states(of, angles), values).outcome
    pairs = [(OUTCOMES[a], OUTCOMES[b]) for a, b in zip(settled, late, strict=True)]
    assert not any(contradict(*pair) for pair in pairs)
    assert 0.2 < (settled == CAPTURED).mean() < 0.8 and sum(a in OPEN_OUTCOMES for a, _ in pairs) <= 6


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "apart"), [(0.0999, 0.0), (0.10001, 0.02828), (0.05, 0.0)])
@pytest.mark.parametrize("damping", [2e-3, 2e-4])
def test_bodies_that_stay_together_or_nearly_have_an_outcome(mass: float, apart: float, damping: float) -> None:
    """Pendulums that cannot quite compensate the unbalance 0.02 kg m stand together, by symmetry; others by the closed form
    2 arccos(U / (2 m r)) apart, less than what counts as together. Weakly damped ones swing about their places first."""
    pendulums = [
        {"kind": "pendulum", "name": n, "about": "r", "mass": mass, "length": 0.1, "damping": damping} for n in ("p1", "p2")
    ]
    rotor = {"kind": "rotor", "name": "r", "mass": 5.0, "unbalance": 0.02, "inertia": 0.1, "bearing_damping": 1e-3}
    carrier = {"mass": 10.0, "stiffness": [5e3, 6e3], "damping": 200.0}
    drive = {"kind": "linear", "slope": 0.5, "no_load_speed": 100.0}
    of = machine_from({"carrier": carrier, "bodies": [rotor, *pendulums], "drive": drive})
    placed = {"r": {"speed": 98.0}, "p1": {"angle": 3.0, "speed": 98.0}, "p2": {"angle": 3.3, "speed": 98.0}}
    motion = run_to_end(of, placed, RunSettings(until=300.0))
    first, second = (motion.machine_motion.end_state[list(of.state_names).index(f"{p}.angle")] for p in ("p1", "p2"))
    assert abs(second - first) == pytest.approx(apart, abs=1e-2)
    assert motion.verdict.outcome in (Outcome.COMPENSATED, Outcome.PASSED) and motion.verdict.growth_rate is None
