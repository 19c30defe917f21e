"""Runs with random starts and parameters: each starts as its run-up, and in tiles and one by one they keep their order."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.run_variations import varied_quantity
from wucht.dynamics.sampling.distributions import REPLICATES
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes
from wucht.dynamics.sampling.random_runs import ProbabilityPoint, RandomRuns
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.machines.machine import Machine


def random_runs(machine: Machine, along: str, names: list[str], start: dict[str, Any], **settings: Any) -> RandomRuns:
    quantities = tuple(varied_quantity(machine, name, f"random.{name}") for name in names)
    paths = tuple(v.name for v in quantities if v.state is None)
    return RandomRuns(EnsembleQuestion(machine, paths, **settings), machine.parameters[along], quantities, start, ("runaway",))


def members(names: list[str]) -> MemberOutcomes:
    unknown = np.ones(len(names))
    return MemberOutcomes(np.array([[str(o) for o in OUTCOMES].index(n) for n in names], np.int8), unknown, unknown, unknown)


def rotor(drive: dict[str, Any]) -> Machine:
    body = {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": 5e-3, "inertia": 0.02}
    carrier = {"mass": 5.0, "directions": "xy", "stiffness": 1e5, "damping": 60.0}
    return machine_from({"carrier": carrier, "bodies": [body], "drive": {"on": "drum"} | drive})


def test_runs_one_by_one_keep_their_places() -> None:
    """The first of each replicate are made first, and put back: those with a small unbalance run away, in any order."""
    runs = random_runs(rotor({"kind": "constant-torque", "torque": 2.0}), "drive.torque", ["drum.unbalance"], {}, until=8.0)
    unbalances = np.random.default_rng(1).permutation(np.linspace(2e-3, 20e-3, 2 * REPLICATES))
    point = runs.point(2.0, unbalances[None], Work())
    held = point.members.outcome != OUTCOMES.index("runaway")  # type: ignore[arg-type]
    assert 4 < held.sum() < 28
    assert unbalances[held].min() > unbalances[~held].max()
    assert point.inside.tolist() == (~held).reshape(REPLICATES, 2).sum(axis=1).tolist()


def test_tiles_are_joined_in_their_order() -> None:
    """More runs than a unit of work has: those that start above 104 rad/s get through, as below the motor is too weak."""
    machine = rotor({"kind": "linear", "slope": 0.004, "no_load_speed": 150.0})
    runs = random_runs(machine, "drive.slope", ["drum.speed"], {}, model="slow", until=100.0)
    speeds = np.random.default_rng(2).permutation(np.linspace(100.0, 108.0, 1040))
    units: list[float] = []
    work = Work(reporter=lambda share, _: units.append(share))
    outcome = runs.outcomes(0.004, speeds[None], work).outcome
    assert 0.5 in units, "two units"
    passed = outcome == OUTCOMES.index("passed")  # type: ignore[arg-type]
    assert speeds[passed].min() > speeds[~passed].max()
    assert speeds[passed].min() == pytest.approx(103.8, abs=0.3)


def test_what_is_counted_of_each_replicate() -> None:
    """Of each four runs two are counted, one is not, one has no verdict."""
    counted = ("compensated", "passed")
    one = ProbabilityPoint.of(1.0, members(["compensated", "captured", "passed", "unidentified"] * REPLICATES), counted, 0.95)
    assert one.inside.tolist() == [2] * REPLICATES and one.open.tolist() == [1] * REPLICATES
    assert one.estimate == pytest.approx(2 / 3), "of those with a verdict"
    assert one.open_share == 0.25 and not one.is_undecided and one.low < 0.5 and one.high > 0.75
    every, none, open_ = (
        ProbabilityPoint.of(1.0, members([name] * 64), counted, 0.95) for name in ("passed", "captured", "failed")
    )
    assert (every.low, every.high) == pytest.approx((0.025 ** (1 / 64), 1.0)) and every.value == 1.0
    assert (none.low, none.high) == pytest.approx((0.0, 1 - 0.025 ** (1 / 64)))
    assert np.isnan(open_.estimate) and open_.is_undecided and (open_.low, open_.high) == (0.0, 1.0)
    uneven = ProbabilityPoint.of(1.0, members(["compensated"] * 4 + ["captured"] * 60), counted, 0.95)
    assert uneven.inside.tolist() == [4] + [0] * 15, "replicates are in a row"
