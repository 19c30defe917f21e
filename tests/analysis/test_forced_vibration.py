"""Forced vibration beside forces, orbits and torques written out over a turn: both senses, several bodies, no damping."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.analysis.throw import GRAVITY, Throw, steady_throw
from wucht.analysis.vibration import ForcedVibration, Vibration
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

TOTAL, STIFFNESS, DAMPING, UNBALANCE = 5.0, (2e4, 8e4), (30.0, 50.0), 0.02
ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "unbalance": UNBALANCE, "inertia": 0.05}
BALL = {"kind": "pendulum", "name": "ball", "about": "drum", "mass": 0.1, "length": 0.08, "damping": 0.1}
SPEEDS = np.array([20.0, 60.0, 90.0, 125.0, 300.0])  # the resonances are at 63 and 126 rad/s
SENSES = pytest.mark.parametrize("sense", [1.0, -1.0])


def machine(sense: float = 1.0, bodies: tuple[dict[str, object], ...] = (ROTOR,), **carrier: object) -> Machine:
    """Unlike in x and y; of 5 kg with the rotor alone."""
    held = {"mass": 3.0, "stiffness": list(STIFFNESS), "damping": list(DAMPING)} | carrier
    drive = {"kind": "linear", "on": "drum", "slope": 0.05, "no_load_speed": sense * 200.0}
    return machine_from({"carrier": held, "bodies": list(bodies), "drive": drive})


def turn(w: float) -> np.ndarray:
    """Times of a turn."""
    return np.arange(7200) / 7200 * 2 * math.pi / w


def motion(w: float, sense: float, bodies: list[tuple[float, float]], total: float = TOTAL) -> tuple[np.ndarray, np.ndarray]:
    """Place (2, N) of the axis over a turn, and z (2,); bodies: unbalance and angle at time zero of each."""
    force = np.zeros(2, complex)
    for u, angle in bodies:
        # cos(angle + sense w t) and sin(angle + sense w t) as real parts of f exp(i w t).
        force += u * w**2 * np.array([np.exp(1j * sense * angle), -1j * sense * np.exp(1j * sense * angle)])
    z = force / (np.array(STIFFNESS) - total * w**2 + 1j * w * np.array(DAMPING))
    return (z[:, None] * np.exp(1j * w * turn(w))).real, z


@SENSES
def test_the_orbit_has_the_axes_of_what_is_run_through_in_a_turn(sense: float) -> None:
    """Between the two resonances it runs against the rotor: the minor semi-axis is negative."""
    forced = ForcedVibration.of(machine(sense), np.array([0.7]))
    axes, minor = forced.amplitude(SPEEDS)[0], forced.minor_amplitude(SPEEDS)
    for w, z, major, small in zip(SPEEDS.tolist(), forced.displacement(SPEEDS)[0], axes, minor, strict=True):
        (x, y), expected = motion(w, sense, [(UNBALANCE, 0.7)])
        assert z == pytest.approx(expected, rel=1e-9)
        distance = np.hypot(x, y)
        assert major == pytest.approx(distance.max(), rel=1e-5)
        assert abs(small) == pytest.approx(distance.min(), rel=1e-3)
        area = float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())  # positive counter-clockwise
        assert np.sign(small) == sense * np.sign(area)
    assert np.sign(minor).tolist() == [1, 1, -1, -1, 1]


@SENSES
def test_slopes_are_central_differences(sense: float) -> None:
    forced, h = ForcedVibration.of(machine(sense), np.array([0.7])), 1e-3
    for curve in (forced.amplitude, forced.displacement, forced.torque):
        assert curve(SPEEDS)[1] == pytest.approx((curve(SPEEDS + h)[0] - curve(SPEEDS - h)[0]) / (2 * h), rel=1e-5)


@SENSES
def test_the_torque_on_each_body_is_that_of_the_carriers_acceleration(sense: float) -> None:
    """U (x'' sin phi - y'' cos phi) turns the body counter-clockwise; on average, and against its sense."""
    angles, moments = np.array([0.7, 2.5]), (UNBALANCE, 0.1 * 0.08)
    forced = ForcedVibration.of(machine(sense, (ROTOR, BALL)), angles)
    every = forced.torque(SPEEDS)[0]
    on_each = [forced.torque_on(SPEEDS, [k])[0] for k in (0, 1)]
    assert on_each[0] + on_each[1] == pytest.approx(every, rel=1e-9)
    assert forced.torque_on(SPEEDS, [1, 0])[0] == pytest.approx(every, rel=1e-9)
    for k, (angle, u) in enumerate(zip(angles, moments, strict=True)):
        for w, actual in zip(SPEEDS.tolist(), on_each[k], strict=True):
            (x, y), _ = motion(w, sense, list(zip(moments, angles, strict=True)), TOTAL + 0.1)
            phi = angle + sense * w * turn(w)
            driving = (-(w**2) * u * (x * np.sin(phi) - y * np.cos(phi))).mean()
            assert actual == pytest.approx(-sense * driving, rel=1e-9)


@SENSES
def test_bodies_at_speeds_of_their_own_move_the_carrier_together(sense: float) -> None:
    """At one moment: the sum of the places, and of the velocities, that each alone would have."""
    vibration = Vibration.of(machine(sense, (ROTOR, BALL)))
    speeds, phases = np.array([90.0, 70.0]), np.array([0.4, -1.1])
    place, velocity = vibration.instant_motion(speeds, phases)
    expected = np.zeros((2, 2))
    for w, phase, u in zip(speeds, phases, (UNBALANCE, 0.1 * 0.08), strict=True):
        _, z = motion(float(w), sense, [(u, sense * float(phase))], TOTAL + 0.1)
        expected += np.array([z.real, (1j * w * z).real])
    assert place == pytest.approx(expected[0], rel=1e-9)
    assert velocity == pytest.approx(expected[1], rel=1e-9)


def test_a_resonance_without_damping_in_the_range_and_excited() -> None:
    natural = [math.sqrt(k / TOTAL) for k in STIFFNESS]
    undamped = ForcedVibration.of(machine(damping=[0.0, 0.0]), np.zeros(1))
    assert undamped.undamped_resonances(10.0, 200.0) == pytest.approx(natural)
    assert undamped.undamped_resonances(10.0, 100.0) == pytest.approx(natural[:1])
    assert undamped.undamped_resonances(100.0, 200.0) == pytest.approx(natural[1:])
    half = ForcedVibration.of(machine(damping=[30.0, 0.0]), np.zeros(1))
    assert half.undamped_resonances(10.0, 200.0) == pytest.approx(natural[1:])
    assert ForcedVibration.of(machine(), np.zeros(1)).undamped_resonances(10.0, 200.0) == []
    balanced = ForcedVibration.of(machine(bodies=(ROTOR, BALL | {"length": 0.2}), damping=[0.0, 0.0]), np.array([0, math.pi]))
    assert balanced.undamped_resonances(10.0, 200.0) == []


@SENSES
def test_the_throw_of_the_steady_vibration(sense: float) -> None:
    made = machine(sense)
    for speed in (90.0, -90.0):
        throw = steady_throw(made, ForcedVibration.of(made, np.array([0.2])), speed)
        assert throw is not None
        (x, y), _ = motion(90.0, sense, [(UNBALANCE, 0.2)])
        assert throw.stroke == pytest.approx(2 * np.hypot(x, y).max(), rel=1e-5)
        assert throw.acceleration == pytest.approx(90.0**2 * np.hypot(x, y).max(), rel=1e-5)


@SENSES
def test_a_carrier_that_only_turns_has_an_angle_as_amplitude(sense: float) -> None:
    """A rotor at 0.2 m from the pivot: psi'' (I + m a^2) + d psi' + k psi = a U w^2 sin(phi)."""
    rocking = {"directions": "r", "inertia": 1.0, "rotation_stiffness": 900.0, "rotation_damping": 3.0}
    drive = {"kind": "linear", "on": "drum", "slope": 0.05, "no_load_speed": sense * 200.0}
    made = machine_from({"carrier": rocking, "bodies": [ROTOR | {"position": [0.2, 0.0]}], "drive": drive})
    forced = ForcedVibration.of(made, np.array([0.7]))
    amplitude = 0.2 * UNBALANCE * SPEEDS**2 / np.abs(900 - (1 + 2 * 0.04) * SPEEDS**2 + 3j * SPEEDS)
    assert forced.amplitude(SPEEDS)[0] == pytest.approx(amplitude, rel=1e-9)
    assert forced.minor_amplitude(SPEEDS) == pytest.approx(np.zeros(5), abs=1e-15)
    assert steady_throw(made, forced, 90.0) is None
    torque = 3 * SPEEDS * amplitude**2 / 2
    assert forced.torque(SPEEDS)[0] == pytest.approx(torque, rel=1e-9)


MAJOR, MINOR, SPEED = 3e-3, 0.4e-3, 150.0


def ellipse(angle: float, sense: float, phase: float = 0.7) -> np.ndarray:
    """z (2,) of an ellipse with its major axis at an angle, run through counter-clockwise (sense 1) or clockwise."""
    own = np.array([MAJOR, -1j * sense * MINOR]) * np.exp(1j * phase)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return np.asarray(turn @ own)


def sampled(z: np.ndarray, a_turn: float, deck: float | None) -> Throw:
    """From samples in uneven steps."""
    steps = np.where(np.arange(int(40 * a_turn)) % 7 == 3, 0.8, 1.0)
    time = np.cumsum(steps) * 2 * math.pi / SPEED / a_turn
    turning = np.exp(1j * SPEED * time)
    return Throw.from_samples(time, (z[:, None] * turning).real, (1j * SPEED * z[:, None] * turning).real, deck)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("angle", [-1.2, 0.78])
def test_an_ellipse(angle: float, sense: float) -> None:
    z, deck = ellipse(angle, sense), -0.1
    own = math.hypot(MAJOR * math.sin(angle - deck), MINOR * math.cos(angle - deck))  # half its height over the deck
    for throw, exact in ((Throw.from_harmonic(z, SPEED, deck), 1e-12), (sampled(z, 24.3, deck), 1e-4)):
        assert (throw.stroke, throw.across) == pytest.approx((2 * MAJOR, 2 * MINOR), rel=max(exact, 2e-3))
        assert math.sin(throw.direction - angle) == pytest.approx(0.0, abs=max(exact, 3e-3)), "a line has no sense"
        assert throw.acceleration == pytest.approx(MAJOR * SPEED**2, rel=exact)
        assert throw.machine_number == pytest.approx(MAJOR * SPEED**2 / GRAVITY, rel=exact)
        assert throw.throw_number(deck) == pytest.approx(own * SPEED**2 / GRAVITY / math.cos(deck), rel=exact)


def test_samples_that_follow_one_another_at_once() -> None:
    """The last one of a run may lie just behind the last of its grid."""
    time = np.append(np.linspace(0.0, 1.0, 401), 1.0 + 1e-13)
    turning = ellipse(0.78, 1.0)[:, None] * np.exp(1j * SPEED * time)
    throw = Throw.from_samples(
        np.append(time, time[-1]), *(np.hstack([q, q[:, -1:]]) for q in (turning.real, (1j * SPEED * turning).real))
    )
    assert throw.acceleration == pytest.approx(MAJOR * SPEED**2, rel=2e-3)


def test_a_line_a_circle_and_rest() -> None:
    line = Throw.from_harmonic(np.array([0.0, 1e-3]), 100.0, 0.0)
    assert (line.direction, line.ratio) == (pytest.approx(math.pi / 2), pytest.approx(0.0, abs=1e-12))
    assert line.throw_number(0.0) == pytest.approx(line.machine_number)
    assert Throw.from_harmonic(np.array([1e-3, -1e-3j]), 100.0).ratio == pytest.approx(1.0)
    rest = Throw.from_samples(np.arange(5.0), np.zeros((2, 5)), np.zeros((2, 5)))
    assert (rest.stroke, rest.ratio, rest.acceleration) == (0.0, None, 0.0)


@pytest.mark.parametrize(("noise", "stroke", "ratio", "direction"), [
    (0.9e-3, 4e-3, 0.25, 0.4), (1.1e-3, 4e-3, 0.0, 0.4), (2.9e-3, 4e-3, 0.0, 0.4), (3.1e-3, 4e-3, 0.0, None),
    (4.1e-3, 0.0, None, None),
])  # fmt: skip
def test_what_is_below_the_noise_is_no_throw(noise: float, stroke: float, ratio: float | None, direction: float | None) -> None:
    """First the motion across, then the direction, of which the circle is none, then all."""
    throw = Throw(stroke=4e-3, across=1e-3, direction=0.4, acceleration=40.0, normal=30.0).beyond(noise)
    assert (throw.stroke, throw.ratio, throw.direction) == (stroke, ratio, direction)
    assert (throw.acceleration, throw.normal) == ((40.0, 30.0) if stroke else (0.0, 0.0))
    circle = Throw(stroke=4e-3, across=3.9e-3, direction=0.4, acceleration=40.0)
    assert (circle.beyond(0.9e-4).direction, circle.beyond(1.1e-4).direction) == (0.4, None)


@pytest.mark.parametrize("deck", [0.3, -0.4])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_bounce_that_is_larger_to_one_side(deck: float, sense: float) -> None:
    """x = a (cos w t + 0.3 cos 2 w t): from 1.3 a to -0.7 a - ...; accelerations of 2.2 a w^2 outward at one end."""
    time = np.linspace(0.0, 4 * math.pi / SPEED, 801)
    phase, way = SPEED * time, np.array([math.cos(0.5), math.sin(0.5)])
    along = sense * MAJOR * (np.cos(phase) + 0.3 * np.cos(2 * phase))
    rate = -sense * MAJOR * SPEED * (np.sin(phase) + 0.6 * np.sin(2 * phase))
    throw = Throw.from_samples(time, np.outer(way, along), np.outer(way, rate), deck)
    assert throw.stroke == pytest.approx(np.ptp(along), rel=1e-4)
    assert throw.across == pytest.approx(0.0, abs=1e-12)
    assert throw.direction == pytest.approx(0.5, abs=1e-9)
    assert throw.acceleration == pytest.approx(2.2 * MAJOR * SPEED**2, rel=1e-3)
    assert throw.normal == pytest.approx(2.2 * MAJOR * SPEED**2 * abs(math.sin(0.5 - deck)), rel=1e-3)
