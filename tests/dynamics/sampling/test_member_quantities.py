"""What is observed of members, in the full equations and in the averaged ones, and when."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_equations import Variants, member_equations
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.sampling.screening_observer import PARTS, SAMPLES, DoublingSchedule
from wucht.files.building import machine_from
from wucht.numerics.flow.program import lower


def values_at(equations, variants, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Speed (1, M), phases (b, 1, M), residual unbalance (1, M), square of the distance (M,) in states (k, M)."""
    quantities = equations.quantities(variants)
    program = lower(quantities.system, (*quantities.expressions.values, *quantities.expressions.peaks))
    rows = quantities.parameter_values[variants.machine_index]
    columns = [
        program.function("math")(tuple(s), 0.0, tuple(program.constant_values(p))) for s, p in zip(starts.T, rows, strict=True)
    ]
    samples = np.array(columns).T[None]
    return quantities.speed(samples), quantities.phases(samples), quantities.residual(samples), samples[0, -1]


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("model", ["full", "slow"])
def test_phases_are_observed_as_the_bodies_turn(model: str, sense: int) -> None:
    """A pendulum 0.4 rad counter-clockwise of its rotor, whichever way both turn."""
    ball = {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.05, "length": 0.1, "damping": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "stiffness": 1e3, "damping": 5.0},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01}, ball],
        "drive": {"on": "a", "kind": "linear", "slope": 1e-3, "no_load_speed": sense * 50.0},
    })  # fmt: skip
    speed = sense * 40.0
    begun = initial_state(machine, {"a": {"angle": 0.9, "speed": speed}, "p": {"angle": 0.4, "speed": speed}})
    equations = member_equations(EnsembleQuestion(machine, model=model), begun)
    variants = Variants.from_values(machine, {}, 2)
    starts = equations.starts(np.repeat(begun[:, None], 2, axis=1), variants)
    observed_speed, phases, _, _ = values_at(equations, variants, starts)
    assert np.remainder(phases, 2 * math.pi) == pytest.approx(np.full((1, 1, 2), 0.4))
    assert observed_speed == pytest.approx(np.full((1, 2), speed))


@pytest.mark.parametrize("sense", [1, -1])
def test_members_whose_rotor_has_a_prescribed_speed_start_with_it(sense: int) -> None:
    """Seven members with two speeds, not in order, and a body of each that starts slower than any of them."""
    ball = {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.05, "length": 0.1, "damping": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e3, "damping": 5.0},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01}, ball],
        "drive": {"on": "a", "kind": "constant-speed", "speed": sense * 50.0},
    })  # fmt: skip
    begun = initial_state(machine, {"p": {"angle": 0.4, "speed": sense * 40.0}})
    speeds = sense * np.array([50.0, 60.0, 60.0, 50.0, 60.0, 50.0, 50.0])
    variants = Variants.from_values(machine, {"drive.speed": speeds}, len(speeds))
    equations = member_equations(EnsembleQuestion(machine, model="slow"), begun)
    starts = equations.starts(np.repeat(begun[:, None], len(speeds), axis=1), variants)
    assert values_at(equations, variants, starts)[0] == pytest.approx(speeds[None])


@pytest.mark.parametrize("stiffness", [1e3, [1e3, 2e3]])  # in the turning frame, and in the fixed one
def test_unbalance_and_distance_are_those_of_the_machine(stiffness: float | list[float]) -> None:
    """Of two variants: |u + u_p e^(i a)|/u by hand, and the axis' distance from where it is at rest."""
    ball = {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.05, "length": 0.1, "damping": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": stiffness, "damping": 5.0},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.01}, ball],
        "drive": {"on": "a", "kind": "linear", "slope": 1e-3, "no_load_speed": 50.0},
    })  # fmt: skip
    begun = initial_state(machine, {"a": {"angle": 0.9}, "p": {"angle": 0.4}, "carrier": {"x": 3e-3, "y": -4e-3}})
    variants = Variants.from_values(machine, {"p.mass": np.array([0.05, 0.2, 0.05])}, 3)
    equations = member_equations(EnsembleQuestion(machine, ("p.mass",)), begun)
    starts = equations.starts(np.repeat(begun[:, None], 3, axis=1), variants)
    _, _, residual, square = values_at(equations, variants, starts)
    expected = [abs(1e-3 + 0.1 * m * np.exp(0.4j)) / 1e-3 for m in (0.05, 0.2, 0.05)]
    assert residual[0] == pytest.approx(expected) and square == pytest.approx([25e-6] * 3)


def test_each_chunk_is_as_long_as_all_before_and_its_samples_rise_to_its_end() -> None:
    pace = DoublingSchedule.from_end(1000.0, 300.0)
    assert pace.end == 1000.0 and pace.chunks == 3
    begin = 0.0
    for i, end in enumerate((250.0, 500.0, 1000.0)):
        times = pace.times(i)
        assert times[0] == begin and times[-1] == end and (np.diff(times) > 0).all()
        assert len(times) - 1 == (SAMPLES if i else PARTS)
        begin = end


@pytest.mark.parametrize("cycles", [1, 2, 3, 5])
def test_a_motion_of_the_samples_own_period_is_not_taken_for_rest(cycles: int) -> None:
    times = DoublingSchedule(100.0, 3).times(2)[1:]
    wave = np.sin(2 * np.pi * cycles * SAMPLES / (times[-1] - 200.0) * (times - 200.0) + 0.5)
    assert np.ptp(wave) > 1.0
