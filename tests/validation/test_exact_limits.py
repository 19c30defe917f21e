"""Limit cases of the general machine that have a solution in closed form, known without any of the papers.

Each machine here is special enough for its motion to be written down: a rotor forced to turn evenly, a pendulum or a ball
on a track that stands still, a rotor whose axis cannot move. "Cannot move" is a carrier of 1e9 kg: it recoils by the ratio
of the masses, some 1e-9, which is below each tolerance. Pendulum periods are compared at finite amplitude, with the complete
elliptic integral of the first kind, so nothing is linearised: T = 4 K(sin^2(a/2)) / omega_0 for a swing of amplitude a
(L. D. Landau, E. M. Lifshitz, "Mechanics", 3rd ed., Pergamon 1976, section 11, problem 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import sympy as sp
import xarray as xr
from scipy.special import ellipk

from wucht import RunUp, run
from wucht.analysis.vibration import Vibration
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate

GRAVITY = 9.81  # m/s^2
# A carrier that stands still: so heavy that nothing moves it, free to move in x alone.
FIXED = {"mass": 1e9, "directions": "x", "stiffness": 1e9}


def summary_and_motion(machine: Machine, **study: Any) -> tuple[dict[str, Any], xr.Dataset]:
    """The summary and the Dataset of a run-up."""
    result = run(RunUp.from_table(study), machine)
    return result.wucht.summary, result


# ----------------------------------------------------------------------------------------------------------------------
# Forced vibration: a rotor at a prescribed speed on an anisotropic carrier
# ----------------------------------------------------------------------------------------------------------------------

CARRIER_MASS, ROTOR_MASS, UNBALANCE = 2.0, 3.0, 0.01  # kg, kg, kg m
STIFFNESS, DAMPING = np.array([8e3, 3e4]), np.array([20.0, 60.0])  # N/m, N s/m; x and y
FORCED_SPEEDS = [20.0, 40.0, 60.0, 77.5, 150.0]  # rad/s; natural frequencies are 40 and 77.5


def forced(speed: float) -> Machine:
    return machine_from(
        {
            "carrier": {
                "mass": CARRIER_MASS,
                "directions": "xy",
                "stiffness": STIFFNESS.tolist(),
                "damping": DAMPING.tolist(),
            },
            "bodies": [{"kind": "rotor", "name": "drum", "mass": ROTOR_MASS, "unbalance": UNBALANCE, "inertia": 0.02}],
            "drive": {"kind": "constant-speed", "speed": speed},
        }
    )


@dataclass(frozen=True)
class Steady:
    """The end of a run: the Dataset's own samples of the last 3 s of 15 s, and the closed forms at these times."""

    speed: float
    machine: Machine
    samples: xr.Dataset

    @classmethod
    def at(cls, speed: float) -> Steady:
        machine = forced(speed)
        _, result = summary_and_motion(machine, until=15.0)
        return cls(speed, machine, result.sel(time=slice(12.0, None)))

    @property
    def time(self) -> np.ndarray:
        return self.samples.time.values

    @property
    def amplitudes(self) -> np.ndarray:
        """U w^2/sqrt((k - M w^2)^2 + (c w)^2) in x and y."""
        moving = CARRIER_MASS + ROTOR_MASS
        return UNBALANCE * self.speed**2 / np.hypot(STIFFNESS - moving * self.speed**2, DAMPING * self.speed)

    @property
    def displacement(self) -> np.ndarray:
        """x = Re z_x, y = Re z_y, complex: U w^2 exp(i w t) and -i U w^2 exp(i w t) over the dynamic stiffness."""
        dynamic = STIFFNESS - (CARRIER_MASS + ROTOR_MASS) * self.speed**2 + 1j * DAMPING * self.speed
        force = UNBALANCE * self.speed**2 * np.exp(1j * self.speed * self.time)
        return np.array([force, -1j * force]) / dynamic[:, None]

    def harmonic(self, signal: np.ndarray, order: int) -> complex:
        """The complex amplitude of an order of the speed in a signal, by least squares on orders 0 to 2."""
        turn = np.exp(1j * self.speed * self.time[:, None] * np.arange(3))
        basis = np.concatenate([turn.real, turn.imag[:, 1:]], axis=1)
        actual = np.linalg.lstsq(basis, signal, rcond=None)[0]
        return complex(actual[order], -actual[order + 2]) if order else complex(actual[0])


# Transients decay with c/2M = 2 and 6 1/s, to exp(-24) = 4e-11 after 12 s; the integration adds 1e-12 a step.
SETTLED = 1e-9


@pytest.fixture(scope="module", params=FORCED_SPEEDS, ids="{:g} rad/s".format)
def steady(request: pytest.FixtureRequest) -> Steady:
    return Steady.at(request.param)


def test_forced_vibration_has_the_amplitude_of_a_linear_oscillator(steady: Steady):
    measured = [abs(steady.harmonic(direction, 1)) for direction in steady.samples.displacement.values]
    np.testing.assert_allclose(measured, steady.amplitudes, rtol=SETTLED)


def test_forced_vibration_instant_by_instant(steady: Steady):
    for measured, expected in zip(steady.samples.displacement.values, steady.displacement, strict=True):
        np.testing.assert_allclose(measured, expected.real, rtol=0, atol=SETTLED * abs(expected[0]))


def test_bearing_force_is_what_moves_the_carrier_alone(steady: Steady):
    """The rotor pushes the carrier, of mass m, with |k - m w^2 + i c w| times the displacement."""
    expected = steady.amplitudes * np.hypot(STIFFNESS - CARRIER_MASS * steady.speed**2, DAMPING * steady.speed)
    measured = [abs(steady.harmonic(direction, 1)) for direction in steady.samples.bearing_force.values]
    np.testing.assert_allclose(measured, expected, rtol=SETTLED)


def test_motor_makes_up_for_what_the_dampers_take(steady: Steady):
    """Mean torque: sum c (w X)^2/2 / w, by the closed form, by ``Vibration.torque``, and in the run."""
    speed = steady.speed
    expected = float((DAMPING * (speed * steady.amplitudes) ** 2).sum()) / 2 / speed
    from_vibration = float(Vibration.of(steady.machine).torque(np.array([speed]), np.zeros(1))[0][0])
    assert from_vibration == pytest.approx(expected, rel=1e-12)
    torque = steady.samples.motor_torque.values
    # The torque alternates with up to a hundred times its mean, and so do the errors.
    assert steady.harmonic(torque, 0).real == pytest.approx(expected, abs=SETTLED * np.abs(torque).max())


def test_motor_torque_alternates_with_twice_the_speed(steady: Steady):
    """T(t) = U (y'' cos wt - x'' sin wt) of the closed-form vibration, instant by instant."""
    x_2, y_2 = -(steady.speed**2) * steady.displacement.real
    turned = steady.speed * steady.time
    expected = UNBALANCE * (y_2 * np.cos(turned) - x_2 * np.sin(turned))
    measured = steady.samples.motor_torque.values
    np.testing.assert_allclose(measured, expected, rtol=0, atol=SETTLED * np.abs(expected).max())


# ----------------------------------------------------------------------------------------------------------------------
# Swings under gravity, about a rotor that stands still
# ----------------------------------------------------------------------------------------------------------------------


def swinging(body: dict[str, Any]) -> Machine:
    """A body named "bob" about a rotor that is held at rest."""
    return machine_from(
        {
            "carrier": {**FIXED, "gravity": GRAVITY},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 1.0, "unbalance": 0.0, "inertia": 0.01},
                {"name": "bob", "about": "drum", **body},
            ],
            "drive": {"kind": "constant-speed", "speed": 0.0},
        }
    )


def period(machine: Machine, amplitude: float) -> float:
    """The period of a swing about "straight down" (-90 degrees), from upward passages found as events."""
    angle = machine.bodies[1].coordinate.position
    flow = compile_system(machine.system, events=(Event("lowest point", angle + sp.pi / 2, +1),))
    begin = initial_state(machine, {"bob": -math.pi / 2 - amplitude})
    passages = [h.time for h in integrate(flow, begin, machine.values, np.linspace(0, 20, 2)).hits]
    assert len(passages) > 5
    return (passages[-1] - passages[0]) / (len(passages) - 1)


AMPLITUDES = [1e-3, 0.5, 2.5]  # rad: small, and not small at all


@pytest.mark.parametrize("amplitude", AMPLITUDES)
@pytest.mark.parametrize("inertia", [None, 0.03], ids=["point ball", "pendulum"])
def test_pendulum_on_a_rotor_at_rest(inertia: float | None, amplitude: float):
    """Small swings: omega_0 = sqrt(m g l/J), J about the axis; without a given J, that of a point ball, sqrt(g/l)."""
    m, length = 0.5, 0.2
    machine = swinging({"kind": "pendulum", "mass": m, "length": length} | ({"inertia": inertia} if inertia else {}))
    omega_0 = math.sqrt(m * GRAVITY * length / (inertia or m * length**2))
    # 1e-8: the recoil of the fixed carrier, some 1e-9, and the integration, 1e-12 a step.
    assert period(machine, amplitude) == pytest.approx(4 * ellipk(math.sin(amplitude / 2) ** 2) / omega_0, rel=1e-8)


@pytest.mark.parametrize("amplitude", AMPLITUDES)
@pytest.mark.parametrize("shape_factor", [0.4, 0.5, 1.0], ids=["ball", "cylinder", "tube"])
def test_roller_in_a_track_at_rest(shape_factor: float, amplitude: float):
    """Rolling without slip makes the swing of a ball slower than sliding: omega_0 = sqrt(g/((1 + mu) (R - r)))."""
    track_radius, radius = 0.3, 0.05
    machine = swinging(
        {
            "kind": "roller",
            "mass": 0.2,
            "track_radius": track_radius,
            "radius": radius,
            "shape_factor": shape_factor,
        }
    )
    omega_0 = math.sqrt(GRAVITY / ((1 + shape_factor) * (track_radius - radius)))
    assert period(machine, amplitude) == pytest.approx(4 * ellipk(math.sin(amplitude / 2) ** 2) / omega_0, rel=1e-8)


def test_roller_hands_torque_to_a_track_that_is_free():
    """Without gravity and with the axis fixed, (18) of source 000 is linear.

    d/dt (J_00 phi_0' - J_01 phi_1') = -beta (phi_0' - phi_1') and d/dt (J_11 phi_1' - J_01 phi_0') = +beta (phi_0' - phi_1'):
    the sum of both momenta never changes, and in the end, turning together at w, (J_00 + J_11 - 2 J_01) w is that sum.
    """
    m, track_radius, radius, mu, inertia = 0.2, 0.3, 0.05, 0.4, 0.05
    eps = track_radius - radius
    machine = machine_from(
        {
            "carrier": FIXED,
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 1.0, "unbalance": 0.0, "inertia": inertia},
                {"kind": "roller", "name": "ball", "about": "drum", "mass": m, "track_radius": track_radius, "radius": radius,
                 "shape_factor": mu, "damping": 0.02},
            ],
        }
    )  # fmt: skip
    _, result = summary_and_motion(machine, until=20.0, start={"drum": {"speed": 10.0}})
    j_00, j_01, j_11 = inertia + mu * m * track_radius**2, mu * m * track_radius * eps, (1 + mu) * m * eps**2
    drum, ball = result.speed.values
    momentum = (j_00 - j_01) * drum + (j_11 - j_01) * ball
    # 1e-8: the recoil of the fixed carrier.
    np.testing.assert_allclose(momentum, (j_00 - j_01) * 10.0, rtol=1e-8)
    common = (j_00 - j_01) * 10.0 / (j_00 + j_11 - 2 * j_01)
    assert [drum[-1], ball[-1]] == pytest.approx([common, common], rel=1e-8)


# ----------------------------------------------------------------------------------------------------------------------
# Energy, and rotors that the vibration does not touch
# ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("directions", ["x", "y", "xy"])
def test_energy_is_conserved_without_drive_and_damping(directions: str):
    """An unbalanced rotor on springs under gravity, started at 50 rad/s: energy goes to and fro but is not lost."""
    machine = machine_from(
        {
            "carrier": {"mass": 1.0, "directions": directions, "stiffness": 8e3, "gravity": GRAVITY},
            "bodies": [{"kind": "rotor", "name": "drum", "mass": 3.0, "eccentricity": 0.02, "inertia": 0.01}],
        }
    )
    _, result = summary_and_motion(machine, until=20.0, start={"drum": {"speed": 50.0}})
    stored = result.stored_energy.values
    # 1e-12 a step, some thousand steps.
    assert np.ptp(stored) < 1e-9 * np.abs(stored).max()
    # It is a test only if energy does go to and fro: the rotor's share varies by far more than a tenth.
    rotation = 0.01 * result.speed.sel(body="drum").values ** 2 / 2
    assert np.ptp(rotation) > 0.1 * rotation.max()


def test_balanced_rotor_runs_up_exponentially():
    """phi' = omega (1 - exp(-U t/J)) with a linear drive; a lossy bearing changes both constants: U + b, U omega/(U + b)."""
    slope, no_load, inertia, bearing = 0.02, 200.0, 0.01, 0.005
    machine = machine_from(
        {
            "carrier": {"directions": "xy", "stiffness": 1e5},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 0.0, "inertia": inertia, "bearing_damping": bearing}
            ],
            "drive": {"kind": "linear", "slope": slope, "no_load_speed": no_load},
        }
    )
    actual, result = summary_and_motion(machine, until=10.0)
    final = slope * no_load / (slope + bearing)
    assert actual["free_speed"] == pytest.approx(final, rel=1e-14)
    expected = final * -np.expm1(-(slope + bearing) / inertia * result.time.values)
    np.testing.assert_allclose(result.speed.values[0], expected, rtol=0, atol=1e-10 * final)  # 1e-12 a step
    assert actual["peak_amplitude"] == 0.0


def test_pendulum_is_dragged_along_exponentially():
    """On a fixed axis without gravity the speeds differ by exp(-b t (1/J + 1/J_P)), while J phi' + J_P theta' is constant."""
    inertia, m, length, damping = 0.05, 0.5, 0.2, 0.01
    machine = machine_from(
        {
            "carrier": FIXED,
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 1.0, "unbalance": 0.0, "inertia": inertia},
                {"kind": "pendulum", "name": "p", "about": "drum", "mass": m, "length": length, "damping": damping},
            ],
        }
    )
    _, result = summary_and_motion(machine, until=5.0, start={"drum": {"speed": 20.0}})
    drum, pendulum = result.speed.values
    j_p = m * length**2
    # 1e-8: the recoil of the fixed carrier.
    slip = 20.0 * np.exp(-damping * (1 / inertia + 1 / j_p) * result.time.values)
    np.testing.assert_allclose(drum - pendulum, slip, rtol=0, atol=20 * 1e-8)
    np.testing.assert_allclose(inertia * drum + j_p * pendulum, inertia * 20.0, rtol=1e-8)
