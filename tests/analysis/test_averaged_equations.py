"""The averaged equations of machines, against averages of the full ones, limit cases and symmetries."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from tests.refusals import refused

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of
from wucht.analysis.vibration import ForcedVibration
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.mechanics.lagrange import equations_of_motion
from wucht.mechanics.rotating_bodies.solution import DISSIPATED_WORK, SUPPLIED_WORK, VIBRATION_WORK
from wucht.numerics.flow.program import Evaluator, python_function

MOUNTS = [
    {"at": [-0.3, 0.05], "stiffness": [5e3, 6e3], "damping": [60.0, 70.0]},
    {"at": [0.35, -0.1], "stiffness": [4e3, 7e3], "damping": [50.0, 90.0]},
]
DRIVE = {"kind": "linear", "slope": 0.02}


def exciters(sense: int, directions: str = "xyr") -> Machine:
    """Two exciters, the second with a ball, on a frame: three directions, two senses, two places."""
    carrier: dict[str, Any] = {"mass": 20.0, "directions": directions, "gravity": 9.81}
    carrier |= {"inertia": 3.0, "mounts": MOUNTS} if directions == "xyr" else {"stiffness": [1e4, 3e4], "damping": [90.0, 40.0]}
    rotor = {"kind": "rotor", "mass": 1.0, "bearing_damping": 1e-3}
    return machine_from(
        {
            "carrier": carrier,
            "bodies": [
                rotor | {"name": "a", "unbalance": 0.02, "inertia": 0.05, "position": [0.2, 0.1]},
                rotor | {"name": "b", "unbalance": 0.015, "inertia": 0.04, "position": [-0.1, 0.2]},
                {
                    "kind": "roller",
                    "name": "ball",
                    "about": "b",
                    "mass": 0.1,
                    "track_radius": 0.1,
                    "radius": 0.02,
                    "damping": 0.01,
                },
            ],
            "drives": [DRIVE | {"on": "a", "no_load_speed": 45.0}, DRIVE | {"on": "b", "no_load_speed": sense * 46.0}],
        }
        if directions == "xyr"
        else {
            "carrier": carrier,
            "bodies": [rotor | {"name": "a", "unbalance": 0.02, "inertia": 0.05}],
            "drive": DRIVE | {"on": "a", "no_load_speed": 45.0},
        }
    )


def at(averaged_equations: AveragedEquations, state: np.ndarray, *names: str) -> np.ndarray:
    """Outputs (k,) at a slow state (n,)."""
    outputs = Evaluator.of(averaged_equations.system, [averaged_equations.system.output(n).expression for n in names], names)
    return outputs.array(np.zeros(1), state[:, None], averaged_equations.values())[:, 0]


def rates(averaged_equations: AveragedEquations, state: np.ndarray) -> np.ndarray:
    """State derivatives (n,) at a slow state (n,)."""
    return Evaluator.of_rates(averaged_equations.system).array(
        np.zeros(1), np.asarray(state)[:, None], averaged_equations.values()
    )[:, 0]


def averaged_torques(machine: Machine, w: float, alpha: np.ndarray, senses: np.ndarray) -> np.ndarray:
    """Mean over a turn of what the vibrating carrier does to each body, from the full equations of motion in numbers.

    The bodies turn steadily; the carrier's periodic motion follows from its own rows, sampled and solved by a Fourier series.
    """
    motion = equations_of_motion(machine.energies, machine.coordinates)
    m, n, count = len(machine.carrier), len(machine.bodies), 64
    symbols = (*motion.coordinates, *motion.velocities)
    numbers = {s: sp.Float(v) for s, v in machine.numbers.items()}
    mass = python_function(symbols, (), [e.xreplace(numbers) for e in motion.mass])
    force = python_function(symbols, (), [e.xreplace(numbers) for e in motion.forces])
    theta = 2 * np.pi * np.arange(count) / count
    angles = senses[:, None] * (theta + alpha[:, None])
    speeds = np.repeat(senses[:, None] * w, count, axis=1)
    rest = np.zeros((m, count))

    def rows(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """M a - F (m + n, N), the bodies turning steadily."""
        args = [*q, *angles, *v, *speeds]
        big = np.array([np.broadcast_to(e, count) for e in mass(*args)]).reshape(m + n, m + n, count)
        return np.einsum("ijt,jt->it", big[:, :m], a) - np.array([np.broadcast_to(e, count) for e in force(*args)])

    # The carrier's rows are linear: their matrices by unit motions, their periodic solution by FFT.
    base = rows(rest, rest, rest)[:m]
    unit = np.eye(m)[:, :, None] * np.ones(count)
    stiffness, damping, inertia = (
        np.array([(rows(*(unit[k] if j == which else rest for j in range(3)))[:m] - base)[:, 0] for k in range(m)]).T
        for which in range(3)
    )
    pushed = -np.fft.fft(base, axis=1)
    order = np.fft.fftfreq(count, 1 / count)
    given = machine.carrier.index(machine.shaken_coordinate) if machine.shaken_coordinate is not None else None
    free = [i for i in range(m) if i != given]
    z = np.zeros((m, count), complex)
    for i, k in enumerate(order):
        dynamic = stiffness - (k * w) ** 2 * inertia + 1j * k * w * damping
        if given is not None and abs(k) == 1:
            z[given, i] = count * machine.values["carrier.motion.amplitude"] / 2
        known = dynamic[:, given] * z[given, i] if given is not None else 0.0
        z[free, i] = np.linalg.solve(dynamic[np.ix_(free, free)], (pushed[:, i] - known)[free])
    q, v, a = (np.fft.ifft(z * (1j * order * w) ** p, axis=1).real for p in range(3))
    steady = rows(q, v, a)[m:].mean(axis=1) - rows(rest, rest, rest)[m:].mean(axis=1)
    return -senses * steady


@pytest.mark.slow
@pytest.mark.parametrize(("directions", "sense"), [("xyr", 1), ("xyr", -1), ("xy", 1)])
def test_vibration_torques_are_the_means_of_the_full_equations(directions: str, sense: int) -> None:
    machine = exciters(sense, directions)
    averaged_equations = averaged_equations_of(machine)
    rng, w = np.random.default_rng(7), 38.0
    senses = np.array([averaged_equations.senses[b.name] for b in machine.bodies])
    alpha = np.concatenate([[0.0], rng.uniform(-3, 3, len(machine.bodies) - 1)])
    absolute = dict(zip((b.name for b in machine.bodies), senses * alpha, strict=True))
    state = averaged_equations.state(absolute, {b.name: averaged_equations.senses[b.name] * w for b in machine.bodies})
    torques = at(averaged_equations, state, *(f"vibration_torque[{b.name}]" for b in machine.bodies))
    expected = averaged_torques(machine, w, alpha, senses)
    assert np.abs(expected).max() > 1e-3
    # Round-off of sums over 64 samples.
    assert torques == pytest.approx(expected, rel=1e-11, abs=1e-13)
    forced = ForcedVibration.of(machine, senses * alpha)
    parts = [-float(forced.torque_on(np.array([w]), [i])[0][0]) for i in range(len(senses))]
    assert torques == pytest.approx(parts, rel=1e-9, abs=1e-12)
    assert at(averaged_equations, state, "amplitude")[0] == pytest.approx(
        float(forced.amplitude(np.array([w]))[0][0]), rel=1e-11
    )


def test_vibration_torques_on_a_frame_that_is_shaken() -> None:
    """The prescribed motion moves the free directions too, through stiffness, damping and mass that couple them."""
    shaken = {"direction": "x", "amplitude": "2 mm", "frequency": "40 rad/s"}
    machine = machine_from(
        {
            "carrier": {"mass": 20.0, "directions": "xyr", "inertia": 3.0, "mounts": MOUNTS, "motion": shaken},
            "bodies": [
                {"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 0.02, "inertia": 0.05, "position": [0.2, 0.1]},
                {"kind": "rotor", "name": "b", "mass": 1.0, "unbalance": 0.015, "inertia": 0.04, "position": [-0.1, 0.2]},
            ],
            "drives": [DRIVE | {"on": "a", "no_load_speed": 41.0}, DRIVE | {"on": "b", "no_load_speed": -42.0}],
        }
    )
    averaged_equations = averaged_equations_of(machine)
    assert averaged_equations.system.state_names == ("a.phase", "b.phase", "a.speed", "b.speed")
    senses, alpha = np.array([1.0, -1.0]), np.array([0.4, -1.1])
    state = averaged_equations.state({"a": 0.4, "b": 1.1}, {"a": 40.0, "b": -40.0})
    torques = at(averaged_equations, state, "vibration_torque[a]", "vibration_torque[b]")
    expected = averaged_torques(machine, 40.0, alpha, senses)
    assert torques == pytest.approx(expected, rel=1e-10, abs=1e-13)
    still = averaged_torques(machine.with_values({"carrier.motion.amplitude": 0.0}), 40.0, alpha, senses)
    assert np.abs(expected - still).min() > 1e-3  # the shaking does most of it


EQUILIBRIA = {  # cases.md, Table 5.1, type II at u = 1: speed, eigenvalues per unit phi of the reduced equations
    "stable": (0.7028953, (-1.0, -1.0, 0.70), (-0.16462, -0.016217, -0.003762)),
    "saddle": (0.7674411, (-2.2, -2.2, 0.77), None),
}


@pytest.mark.parametrize("case", EQUILIBRIA)
def test_steady_states_of_table_5_1(case: str) -> None:
    from scipy.optimize import fsolve

    speed, guess, eigenvalues = EQUILIBRIA[case]
    averaged_equations = averaged_equations_of(
        load_machine("drozdetskaya-2020/table-5.1", {}).with_values({"u": 1.0}), inertia=False
    )
    steady = fsolve(lambda x: rates(averaged_equations, x), guess, xtol=1e-13)
    assert steady[2] == pytest.approx(speed, abs=5e-8)
    moves = 1e-6 * np.eye(3)
    jacobian = (
        np.array([(rates(averaged_equations, steady + e) - rates(averaged_equations, steady - e)) / 2e-6 for e in moves]).T
        / steady[2]
    )
    if eigenvalues is not None:
        assert np.sort(np.linalg.eigvals(jacobian).real) == pytest.approx(eigenvalues, rel=2e-4)
    else:
        assert (np.linalg.eigvals(jacobian).real > 0).sum() == 1


def test_slips_of_the_start_move_the_slow_phase() -> None:
    """002 (4.24), (4.30): without vibration the strongly damped state must be where the full one ends."""
    machine = load_machine("drozdetskaya-2020/r1", {}).with_values({"drum.eccentricity": 0.0, "drive.slope": 0.0})
    averaged_equations = averaged_equations_of(machine, inertia=False)
    angles, speeds = {"drum": 0.0, "p1": 0.3, "p2": -0.5}, {"drum": 50.0, "p1": 80.0, "p2": 20.0}
    state = dict(zip(averaged_equations.system.state_names, averaged_equations.state(angles, speeds), strict=True))
    j, b = np.diag([9.75e-4, 1.69e-3, 1.69e-3]), 0.169 * np.array([[2, -1, -1], [-1, 1, 0], [-1, 0, 1.0]])
    decay = -np.linalg.solve(j, b)
    time = np.linspace(0, 2, 200_001)
    values, vectors = np.linalg.eig(decay)
    nu = vectors @ (np.linalg.solve(vectors, np.array([50.0, 80.0, 20.0]))[:, None] * np.exp(values[:, None] * time))
    moved = np.trapezoid(nu.real, time, axis=1)
    assert state["drum.speed"] == pytest.approx(nu.real[0, -1], rel=1e-9)
    assert state["p1.phase"] == pytest.approx(0.3 + moved[1] - moved[0], abs=1e-5)  # the trapezoidal rule
    assert state["p2.phase"] == pytest.approx(-0.5 + moved[2] - moved[0], abs=1e-5)


REFUSED = {
    "slider": ("sperling-vibration/figure-7", {}, "slides in a guide"),
    "suspension": (None, {"suspension": [0.01, 0.0]}, "pivot of p turns with the rotor"),
}


@pytest.mark.parametrize("case", REFUSED.values(), ids=REFUSED.keys())
def test_machines_outside_the_class_are_refused(case: tuple[str | None, dict[str, Any], str]) -> None:
    name, keys, reason = case
    ball = {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.2, "length": 0.1, "damping": 0.05} | keys
    given = (
        load_machine(name, {})
        if name
        else machine_from(
            {
                "carrier": {"stiffness": 1e5, "damping": 150.0},
                "bodies": [{"kind": "rotor", "name": "drum", "mass": 10.0, "eccentricity": 1e-3, "inertia": 0.01}, ball],
                "drive": {"on": "drum", "kind": "linear", "slope": 0.01, "no_load_speed": 250.0},
            }
        )
    )
    with pytest.raises(InputError, match=reason):
        averaged_equations_of(given)


ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}


HELD = {"kind": "constant-speed", "speed": 100.0}


MOTOR = {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0}


@pytest.mark.parametrize(
    ("motion", "drive", "code"),
    [
        ({"direction": "x", "points": [[0, 0], [1, 1e-3], [2, 0], [3, 1e-3], [4, 0]]}, MOTOR, "table"),
        ({"direction": "x", "amplitude": 1e-3, "frequency": 6.0}, HELD, "no-common-speed"),
    ],
)
def test_shaken_machines_without_averaged_equations(motion: dict[str, Any], drive: dict[str, Any], code: str) -> None:
    machine = machine_from({"carrier": {"directions": "x", "motion": motion}, "bodies": [ROTOR], "drive": drive})
    with refused("machine", code=code):
        averaged_equations_of(machine)
    for order in (0, 3):
        with refused("machine", f"order {order}", code="order"):
            averaged_equations_of(load_machine("drozdetskaya-2020/r1", {}), True, order)


@pytest.mark.parametrize("inertia", [True, False])
def test_powers_make_the_stored_energy_at_any_slow_state(inertia: bool) -> None:
    """d(stored)/dt by differences: supplied less lost, relative dampers included, less what shakes the carrier."""
    averaged_equations = averaged_equations_of(exciters(1), inertia, 1)
    names = averaged_equations.system.state_names
    state = np.array([0.3 if n.startswith(("phase", "alpha", "psi")) else 40.0 + 0.3 * i for i, n in enumerate(names)])
    rate, step = rates(averaged_equations, state), 1e-7
    there, here = (at(averaged_equations, state + s * step * rate, "stored_energy")[0] for s in (1, -1))
    supplied, lost, shaken = (
        at(averaged_equations, state, name)[0] for name in (SUPPLIED_WORK, DISSIPATED_WORK, VIBRATION_WORK)
    )
    assert lost > 0
    assert (there - here) / (2 * step) == pytest.approx(supplied - lost - shaken, rel=1e-5, abs=1e-4)
