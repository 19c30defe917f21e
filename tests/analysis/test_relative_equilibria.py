"""Steady rotation as an equilibrium of the full equations: against periodic orbits in the frame at rest, and long runs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed, refused

from wucht.analysis.configurations.closed_form import State, fixed_speed_states
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.search import all_states
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.analysis.synchronous_motion import SynchronousMotions
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Evaluator

ROTOR = {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.0338}
BALL = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "inertia": 1.69e-3, "damping": 0.169}
BODIES = [ROTOR, BALL | {"name": "p1"}, BALL | {"name": "p2"}]
ISOTROPIC = {"directions": "xy", "stiffness": 1e5, "damping": 200.0}
MOTOR = {"kind": "linear", "slope": 0.02, "no_load_speed": 200.0}
ROLLER = {"kind": "roller", "name": "r", "about": "drum", "mass": 0.1, "track_radius": 0.1, "radius": 0.01, "damping": 0.01}
SLIDER = {"kind": "slider", "name": "s", "about": "drum", "mass": 0.4, "angle": 1.0, "radius": 0.08, "stiffness": 3e4}


def drum(carrier: dict[str, Any] | None = None, drive: Any = MOTOR, bodies: Any = BODIES, **more: Any) -> Machine:
    return machine_from({"carrier": ISOTROPIC | (carrier or {}), "bodies": bodies, "drive": drive} | more)


def judged(m: Machine, **near: float) -> tuple[FullStability, State]:
    """The state of the averaged equations nearest to a speed, and the full equations."""
    torques, top = SteadyTorques.of(m), 1.0001 * abs(m.values.get("drive.no_load_speed", 0.0))
    states = (
        all_states(torques, 1e-3 * top, top).states
        if torques.fixed_speed is None
        else fixed_speed_states(torques, torques.fixed_speed)
    )
    return FullStability(torques, True), min(states, key=lambda s: abs(s.speed - near.get("speed", s.speed)))


# --- the frame ---


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(
    "more",
    [
        [],
        [BALL | {"name": "q", "suspension": [0.05, -0.03]}, SLIDER | {"damping": 2.0}, ROLLER],
        [ROTOR | {"name": "second"}, BALL | {"name": "on2", "about": "second"}],
    ],
    ids=["balls", "suspension, slider, roller", "two rotors"],
)
def test_the_machines_equations_hold_in_the_turning_frame(more: list[dict[str, Any]], sense: int) -> None:
    """Rates at random states, against a difference quotient of the turned states along the rates at rest."""
    drives = [MOTOR | {"on": "drum", "no_load_speed": sense * 200.0}]
    if len(more) == 2:
        drives.append(MOTOR | {"on": "second", "no_load_speed": sense * 190.0})
    document = {"carrier": ISOTROPIC, "bodies": [*BODIES, *more], "drives": drives}
    m = machine_from(document)
    r = RelativeEquilibria.of(m)
    assert len(r.system.states) == len(m.system.states) - 1
    rng = np.random.default_rng(1)
    states, time = rng.normal(size=(len(m.state_names), 6)) * 0.1, np.zeros(6)
    rate = Evaluator.of_rates(m.system).array(time, states, m.system.values(m.values))
    h = 1e-6
    expected = (r.to_turning_frame(states + h * rate) - r.to_turning_frame(states - h * rate)) / (2 * h)
    found = Evaluator.of_rates(r.system).array(time, r.to_turning_frame(states), r.system.values(r.values))
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
    angle = states[m.row(m.rotor.coordinate.position)]
    assert r.to_fixed_frame(r.to_turning_frame(states), angle) == pytest.approx(states, abs=1e-14)
    assert r.to_fixed_frame(r.to_turning_frame(states[:, 0]), angle[0]) == pytest.approx(states[:, 0], abs=1e-14)


EXCITER = {"kind": "linear", "slope": 0.1}


@pytest.mark.parametrize(
    ("described", "sentence"),
    [
        ({"carrier": ISOTROPIC | {"stiffness": [1e5, 2e5]}}, "carrier.stiffness.x, carrier.stiffness.y"),
        ({"carrier": ISOTROPIC | {"gravity": 9.81}}, "(with carrier.gravity"),
        ({"carrier": ISOTROPIC | {"directions": "x"}}, "the carrier moves in one direction alone"),
        (
            {"carrier": ISOTROPIC | {"motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}}},
            "the motion of carrier.x is prescribed",
        ),
        ({"schedules": [{"parameter": "drive.no_load_speed", "points": [[0, 0], [1, 200]]}]}, "changes over time"),
        (
            {
                "bodies": [*BODIES, ROTOR | {"name": "second"}],
                "drives": [EXCITER | {"on": "drum", "no_load_speed": 9}, EXCITER | {"on": "second", "no_load_speed": -9}],
            },
            "second turns against it",
        ),
    ],
)
def test_other_machines_are_refused_with_the_reason(described: dict[str, Any], sentence: str) -> None:
    document: dict[str, Any] = {"carrier": ISOTROPIC, "bodies": BODIES} | described
    m = machine_from(document if "drives" in document else document | {"drive": MOTOR})
    with pytest.raises(InputError) as raised:
        RelativeEquilibria.of(m)
    assert str(raised.value).startswith("machine: steady rotation is not an equilibrium in a frame that turns with drum")
    assert sentence in str(raised.value)
    assert SynchronousMotions.of(m).relative is None
    assert sentence in SynchronousMotions.of(m).outside_reason


# --- both ways agree ---


def assert_both_ways_agree(full: FullStability, state: State) -> None:
    """Floquet exponents in the frame at rest are the eigenvalues in the turning one but for whole multiples of i w."""
    motion = full.motions.find_near(full.start(state), state.speed, state.neutral, state.dimension)
    orbit = full.motions.orbit(full.start(state), state.speed, state.dimension)
    assert motion.equilibrium is not None
    assert motion.period == pytest.approx(orbit.period, rel=1e-10)
    assert full.motions.relative is not None
    relative = full.motions.relative
    # Of a family each way may find another member: then those of the orbit's member.
    found = relative.find_near(relative.to_turning_frame(orbit.state), state.neutral)
    expected = np.append(found.eigenvalues, 0.0) * orbit.period
    logarithms = orbit.logarithms.copy()
    for value in expected[np.argsort(-expected.real)]:
        nearest = int(np.abs(np.expm1(logarithms - value)).argmin())
        assert abs(np.exp(logarithms[nearest]) - np.exp(value)) < 1e-11
        assert abs(np.expm1(logarithms[nearest] - value)) < 1e-9 * max(1.0, orbit.period * abs(found.eigenvalues).max())
        logarithms = np.delete(logarithms, nearest)


def test_eigenvalues_are_floquet_exponents_of_table_5_1() -> None:
    m = load_machine("drozdetskaya-2020/table-5.1", {"u": 1.0})
    torques = SteadyTorques.of(m)
    state = min(all_states(torques, 1e-3, 2.0002).states, key=lambda s: abs(s.speed - 0.7))
    assert_both_ways_agree(FullStability(torques, True), state)


@pytest.mark.slow
def test_a_family_has_eigenvalues_that_are_zero() -> None:
    """Three equal balls compensate in a family of one dimension: one eigenvalue is zero, and it is stable all the same."""
    m = drum(bodies=[*BODIES, BALL | {"name": "p3"}])
    full, state = judged(m, speed=200.0)
    assert state.dimension == 1
    assert_both_ways_agree(full, state)
    assert full.motions.relative is not None
    relative = full.motions.relative
    found = relative.find_near(relative.to_turning_frame(full.start(state)), 1)
    size = np.abs(found.eigenvalues).max()
    assert (np.abs(found.eigenvalues) < 1e-9 * size).sum() == found.neutral == 1
    assert found.exponents.real.max() < -1e-4 * size
    assert full.stability(state).stable is True
    with failed("singular", "0"):
        relative.find_near(found.state)
    with failed("no-single-branch"):
        relative.branches_over("drive.slope", (0.01, 0.1), found)


def test_an_anisotropic_carrier_has_an_orbit() -> None:
    m = drum({"stiffness": [1e5, 1.2e5]})
    full, state = judged(m, speed=200.0)
    motion = full.motions.find_near(full.start(state), state.speed)
    assert motion.orbit is not None and motion.equilibrium is None
    assert motion.orbit.advance[[m.row(b.coordinate.position) for b in m.bodies]] == pytest.approx(2 * math.pi)
    assert full.motions.outside_reason.endswith("(with carrier.stiffness.x, carrier.stiffness.y)")
    assert motion.exponents.real.max() < 0


# --- against runs ---


def test_a_long_run_stays_and_decays_as_the_slowest_eigenvalue_says() -> None:
    """Table 5.1 at u = 1, captured: a hundred turns at rest, then a disturbance along the slowest direction."""
    m = load_machine("drozdetskaya-2020/table-5.1", {"u": 1.0})
    torques = SteadyTorques.of(m)
    full = FullStability(torques, True)
    relative = full.motions.relative
    assert relative is not None
    captured = min(all_states(torques, 1e-3, 2.0002).states, key=lambda s: abs(s.speed - 0.7028953))
    found = relative.find_near(relative.to_turning_frame(full.start(captured)))
    values = np.array(full.flow.system.values(m.values))

    def run(state: np.ndarray, time: np.ndarray) -> np.ndarray:
        """How far a run is from the relative equilibrium (n-1, N)."""
        states = integrate(full.flow, relative.to_fixed_frame(state, 0.3), values, time).states
        return np.asarray(relative.to_turning_frame(states) - found.state[:, None])

    assert np.abs(run(found.state, np.array([0.0, 1000.0]))).max() < 1e-9
    eigenvalues, vectors = np.linalg.eig(relative.linear()(found.state)[1])
    slow = int(eigenvalues.real.argmax())
    away = run(found.state + 1e-4 * vectors[:, slow].real, np.array([0.0, 200.0, 800.0]))
    row = relative.system.state_names.index("p1.phase")
    assert math.log(away[row, 2] / away[row, 1]) / 600 == pytest.approx(found.exponents[0].real, rel=1e-3)


def test_a_start_that_leads_nowhere_is_told() -> None:
    relative = RelativeEquilibria.of(load_machine("drozdetskaya-2020/table-5.1", {"u": 1.0}))
    away = relative.to_turning_frame(np.array([-1.0, 0.2, 0.0, 5.0, 5.3, 0.1, -0.6, 0.7, 0.7, 0.7]))
    assert relative.find_near(away).speed > 0
    with failed("no-family", "1"):
        relative.find_near(away, 1)
    with failed("singular"):
        relative.find_near(np.full(len(relative.system.states), 1e6))


@pytest.mark.slow
def test_speeds_without_torque_are_a_family() -> None:
    """A drive whose torque ends at 200 rad/s: every greater speed is as good, which says nothing against stability."""
    m = drum(drive={"kind": "table", "points": [[0, 20], [100, 15], [150, 10], [200, 0]]})
    torques = SteadyTorques.of(m)
    full = FullStability(torques, True)
    (state,) = {s.speed: s for s in all_states(torques, 0.2, 200.02).states if s.is_indifferent}.values()
    motion = full.motions.find_near(full.start(state.interior_state), state.interior_state.speed, state.neutral)
    assert motion.equilibrium is not None and motion.equilibrium.neutral == 1
    assert full.stability(state).stable is True
    orbit = full.motions.orbit(full.start(state.interior_state), state.interior_state.speed)
    assert motion.exponents[0].real == pytest.approx(np.log(np.abs(orbit.nontrivial(2)[0])) / orbit.period, rel=1e-7)


HEAVY = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
SLOW = {"kind": "constant-speed", "speed": 100.0}


def test_a_family_that_gravity_breaks_is_judged_across_it() -> None:
    """Three balls that compensate: along their family they creep, however slowly."""
    ball = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    balls = [ball | {"name": f"b{k}", "mass": 0.02 + 0.01 * k} for k in range(3)]
    carrier = {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": 40.0, "gravity": 9.81}
    full = FullStability(SteadyTorques.of(machine_from({"carrier": carrier, "bodies": [HEAVY, *balls], "drive": SLOW})), True)
    family = next(s for s in fixed_speed_states(full.torques, 100.0) if s.dimension)
    judged_across = full.stability(family)
    assert judged_across.reason.startswith("the family is broken by gravity: bodies creep along it, here by up to ")
    assert (judged_across.stable is not None) == judged_across.reason.endswith("stability is judged across the family")


def test_unknown_parameters_are_refused() -> None:
    full, state = judged(drum(), speed=200.0)
    relative = full.motions.relative
    assert relative is not None
    found = relative.find_near(relative.to_turning_frame(full.start(state)))
    with refused("parameter", given="carrier.gravity"):
        relative.branches_over("carrier.gravity", (0, 10), found)
