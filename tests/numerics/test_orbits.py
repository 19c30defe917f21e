"""Periodic motions and their multipliers, against motions whose multipliers are known otherwise."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq
from tests.refusals import failed, rejected

from witness import machine_from
from wucht.errors import RunError
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.orbits import periodic_orbit
from wucht.numerics.periodic.closing import Closing, close_orbit
from wucht.piecewise import Pieces, PiecewiseCubic, step
from wucht.system import TIME, System

x, v, y, w, phi = sp.symbols("x v y w phi", real=True)
a, b = sp.symbols("a b", real=True)
TURN = 2 * math.pi


def sorted_as(multipliers, wanted):
    """Each of the multipliers wanted next to the one found that is nearest to it."""
    rest = list(multipliers)
    return np.array([rest.pop(int(np.abs(np.array(rest) - m).argmin())) for m in wanted])


def test_a_linear_system_has_the_exponents_of_its_matrix():
    """Forced by an angle of constant rate: the period is given, the angle's own multiplier is 1."""
    matrix = np.array([[0.0, 1.0], [-3.0, -0.4]])
    system = System((x, v, phi), (v, -3 * x - a * v + sp.cos(phi), b), (a, b), angles=frozenset({phi}))
    rate = 1.7
    orbit = periodic_orbit(
        compile_system(system),
        [0.4, rate],
        [0.0, 0.0, 0.3],
        TURN / rate,
        [0, 0, TURN],
        free_period=False,
        phase_state=2,
    )
    amplitude = 1 / (3 - rate**2 + 0.4j * rate) * cmath.exp(1j * orbit.state[2])
    assert orbit.state == pytest.approx([amplitude.real, (1j * rate * amplitude).real, 0.3], abs=1e-10)
    wanted = np.append(np.linalg.eigvals(expm(matrix * TURN / rate)), 1.0)
    assert np.abs(sorted_as(orbit.multipliers, wanted) - wanted).max() < 1e-10
    values = np.linalg.eigvals(matrix)
    values -= 1j * rate * np.round(values.imag / rate)  # an exponent is known but for multiples of the orbit's frequency
    assert np.abs(sorted_as(orbit.exponents, values) - values).max() < 1e-9
    assert (np.diff(np.abs(orbit.multipliers)) <= 1e-12).all()


def test_van_der_pol():
    """The period is known to 29 digits; the multiplier is exp of the mean divergence 1 - x^2."""
    system = System((x, v), (v, (1 - x**2) * v - x))
    orbit = periodic_orbit(compile_system(system), [], [2.0, 0.0], 6.5, [0, 0], phase_state=1)
    assert orbit.period == pytest.approx(6.6632868593231301896996820305, abs=1e-9)
    run = solve_ivp(
        lambda t, s: [s[1], (1 - s[0] ** 2) * s[1] - s[0], 1 - s[0] ** 2], (0, orbit.period), [*orbit.state, 0],
        "DOP853", rtol=1e-13, atol=1e-13,
    )  # fmt: skip
    assert orbit.multipliers.real == pytest.approx([1.0, math.exp(run.y[2, -1])], abs=1e-9)
    assert orbit.nontrivial(1).real == pytest.approx([math.exp(run.y[2, -1])], abs=1e-9)


def test_two_coupled_pendula_that_rotate():
    """AUTO's demo ``pen`` at I = 0.4: what AUTO finds to its accuracy, and what follows from the modes to ours.

    They turn together: phi'' = I - eps phi' - sin phi, and the modes of a disturbance part into that of both alike and that of
    both against each other, d'' = -eps d' - (cos phi + 2 g) d.
    """
    g, eps, torque = 0.175, 0.1, 0.4
    rates = (v, w, torque - eps * v - sp.sin(x) + g * (y - x), torque - eps * w - sp.sin(y) + g * (x - y))
    system = System((x, y, v, w), rates, angles=frozenset({x, y}))
    orbit = periodic_orbit(compile_system(system), [], [0, 0, 4, 4], TURN / 4, [TURN, TURN, 0, 0])

    def modes(t, s):
        alike, against = -math.cos(s[0]), -math.cos(s[0]) - 2 * g
        accelerations = [alike * s[2] - eps * s[4], alike * s[3] - eps * s[5], against * s[6] - eps * s[8]]
        last = against * s[7] - eps * s[9]
        return [s[1], torque - eps * s[1] - math.sin(s[0]), s[4], s[5], *accelerations[:2], s[8], s[9], accelerations[2], last]

    start = [0.0, orbit.state[2], 1, 0, 0, 1, 1, 0, 0, 1]
    end = solve_ivp(modes, (0, orbit.period), start, "DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    assert end[:2] == pytest.approx([TURN, orbit.state[2]], abs=1e-9)
    wanted = np.concatenate([np.linalg.eigvals(end[k : k + 4].reshape(2, 2)) for k in (2, 6)])
    assert np.abs(sorted_as(orbit.multipliers, wanted) - wanted).max() < 1e-8
    assert orbit.period == pytest.approx(1.5738797188, rel=1e-7)
    multipliers = np.array([0.551229 + 0.741969j, 0.551229 - 0.741969j, 0.854372])
    assert np.abs(sorted_as(orbit.nontrivial(1), multipliers) - multipliers).max() < 3e-5


ROTOR = {
    "carrier": {"mass": 3.0, "directions": "xy", "stiffness": 3e4, "damping": 60.0},
    "bodies": [
        {"kind": "rotor", "name": "rotor", "mass": 5.0, "unbalance": 4e-3, "inertia": 0.02},
        {"kind": "pendulum", "name": "ball", "about": "rotor", "mass": 0.1, "length": 0.05, "inertia": 2.6e-4, "damping": 2e-3},
    ],
}
SPEED = 40.0
PRESCRIBED = {"drive": {"on": "rotor", "kind": "constant-speed", "speed": SPEED}}


def turning(machine, speed, phases=None):
    """Names of the states, a guess of a rotation in which all bodies turn alike, and what each state gains in a turn."""
    names = machine.system.state_names
    guess = [(phases or {}).get(n, speed if n.endswith(".speed") else 0.0) for n in names]
    return names, guess, [TURN if n.endswith(".angle") else 0.0 for n in names]


def corotating():
    """Phase of the ball and eigenvalues of the motion that turns with the rotor, from its equations on paper.

    r = z exp(i w t), phi = w t + psi: m (z'' + 2 i w z' - w^2 z) + c (z' + i w z) + k z = U w^2
    + u ((w + psi')^2 - i psi'') exp(i psi), and J psi'' + b psi' + u Im[exp(-i psi) (z'' + 2 i w z' - w^2 z)] = 0.
    """
    m, c, k, unbalance, u, b, w = 8.1, 60.0, 3e4, 4e-3, 5e-3, 2e-3, SPEED
    inertia = 2.6e-4

    def displacement(psi):
        return w**2 * (unbalance + u * cmath.exp(1j * psi)) / (k - m * w**2 + 1j * c * w)

    psi = brentq(lambda p: (cmath.exp(-1j * p) * displacement(p)).imag, -1.0, 1.0, xtol=1e-15)
    z, turned = displacement(psi), cmath.exp(1j * psi)

    def row(of_z, of_psi):
        """Real and imaginary part of a complex equation in (Re z, Im z, psi)."""
        columns = np.array([of_z, 1j * of_z, of_psi])
        return np.array([columns.real, columns.imag])

    def torque(of_z, of_psi):
        return np.append((u * np.array([of_z, 1j * of_z]) / turned).imag, of_psi)

    mass = np.vstack([row(m, 1j * u * turned), torque(1.0, inertia)])
    damping = np.vstack([row(2j * m * w + c, -2 * w * u * turned), torque(2j * w, b)])
    stiffness = row(k - m * w**2 + 1j * c * w, -1j * w**2 * u * turned)
    stiffness = np.vstack([stiffness, torque(-(w**2), u * (-1j / turned * -(w**2) * z).imag)])
    below = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    return psi, np.linalg.eigvals(np.vstack([np.hstack([np.zeros((3, 3)), np.eye(3)]), below]))


def test_a_rotor_of_given_speed_on_an_isotropic_carrier():
    """Seen from the rotor the motion is an equilibrium; its eigenvalues give the multipliers."""
    psi, values = corotating()
    machine = machine_from(ROTOR | PRESCRIBED)
    names, guess, advance = turning(machine, SPEED)
    flow = compile_system(machine.system)
    orbit = periodic_orbit(flow, machine.values, guess, TURN / SPEED, advance, free_period=False)
    state = dict(zip(names, orbit.state, strict=True))
    assert state["ball.angle"] - state["rotor.angle"] == pytest.approx(psi, abs=1e-9)
    wanted = np.append(np.exp(values * TURN / SPEED), 1.0)
    assert np.abs(sorted_as(orbit.multipliers, wanted) - wanted).max() < 1e-9


def test_a_breakpoint_on_the_way_is_exact():
    """Stiffness 1 to the right and 4 to the left: all motions have the period pi (1 + 1/2), the monodromy matrix is 1."""
    force = Pieces("force", (0.0,), ((0, 4, 0, 0), (0, 1, 0, 0)))
    system = System((x, v), (v, -PiecewiseCubic(x, force)))
    flow = compile_system(system)
    orbit = periodic_orbit(flow, [], [0.3, 0.7], 4.6, [0, 0], phase_state=1)
    assert orbit.period == pytest.approx(1.5 * math.pi, abs=1e-10)
    assert np.abs(orbit.monodromy - np.eye(2)).max() < 1e-9


def test_one_of_several_jumps_on_the_way_is_refused_and_none_beside_it():
    """x' = a cos t - x + h(x), h jumps at -5, 0.25 and 5: an orbit with a = 2 passes 0.25 alone, one with a = 0.25 none."""
    steps = Pieces("h", (-5.0, 0.25, 5.0), [(value, 0, 0, 0) for value in (-3.0, 0.0, 1.0, 2.0)])
    compiled = compile_system(System((x,), (-x + a * sp.cos(TIME) + PiecewiseCubic(x, steps),), (a,)))
    with rejected("jump", "h"):
        periodic_orbit(compiled, [2.0], [0.5], TURN, [0], free_period=False)
    beside = periodic_orbit(compiled, [0.25], [0.1], TURN, [0], free_period=False)
    assert beside.state == pytest.approx([0.125], abs=1e-9)  # x = a (cos t + sin t)/2, at most 0.18


def test_a_jump_in_time_is_refused_where_the_period_holds_it():
    """x' = -x + h(t), h from 1 to 2 at t = 10. A period that begins at 11 does not see it: x = 2."""
    compiled = compile_system(System((x,), (-x + PiecewiseCubic(TIME, step("h", 10.0, 1.0, 2.0)),)))
    with rejected("jump", "h"):
        periodic_orbit(compiled, [], [1.5], 4.0, [0], free_period=False, time=8.0)
    after = periodic_orbit(compiled, [], [1.5], 11.0, [0], free_period=False, time=11.0)
    assert after.state == pytest.approx([2.0], abs=1e-10)


def test_where_there_is_none_it_is_reported():
    system = System((x, v), (v, a - x**2), (a,))  # escapes
    with failed("no-convergence"):
        periodic_orbit(compile_system(system), [-1.0], [0.0, 1.0], 3.0, [0, 0], free_period=False)
    uniform = System((x,), (sp.S.One,))
    with rejected("too-many-steps", "5", "1", "1e-10"):
        periodic_orbit(compile_system(uniform), [], [0.0], 3.0, [0], free_period=False, most_steps=5)


def test_a_free_period_needs_equations_without_time():
    system = System((x,), (-a * x + sp.cos(TIME),), (a,))
    with rejected("time-dependent"):
        periodic_orbit(compile_system(system), [1.0], [0.0], TURN, [0], phase_state=0)


@pytest.mark.parametrize(
    ("given", "refusal"),
    [
        ({"guess": [0.0]}, rejected("shape", "2")),
        ({"advance": [0.0, 0.0, 0.0]}, rejected("shape", "2")),
        ({"guess": [math.nan, 0.0]}, rejected("shape", "2")),
        ({"period": 0.0}, rejected("period", "0.0")),
        ({}, rejected("phase-state", "phase_state")),
        ({"phase_state": 5}, rejected("no-state", "phase_state", "5", "0", "1")),
        ({"phase_state": -1}, rejected("no-state", "phase_state", "-1", "0", "1")),
    ],
)
def test_bad_calls(given, refusal):
    good = {"guess": [1.0, 0.0], "period": 1.0, "advance": [0.0, 0.0]}
    with refusal:
        periodic_orbit(compile_system(System((x, v), (v, -x))), [], **good | given)


@pytest.mark.parametrize("small", [1e-4, 1e-5])
def test_what_a_broken_family_gains_is_known(small):
    """y' = e (1 + cos phi) creeps by e T, whatever y; v' = y - v follows it. The gap is where nothing closes it: in y."""
    rate = 1.7
    system = System((phi, y, v), (b, a * (1 + sp.cos(phi)), y - v), (a, b), angles=frozenset({phi}))
    orbit = periodic_orbit(
        compile_system(system), [small, rate], [0, 2.0, 2.0], TURN / rate, [TURN, 0, 0],
        free_period=False, phase_state=0, left_open=1,
    )  # fmt: skip
    creep = small * TURN / rate
    assert orbit.gap == pytest.approx([0, creep, 0], abs=1e-13)
    assert orbit.creep(2) == pytest.approx([0, creep, creep], abs=1e-13)
    assert orbit.residual == pytest.approx(creep / 2, rel=1e-3)  # of the size of y
    assert orbit.state[1:] == pytest.approx([2.0, 2.0], abs=1e-3)
    assert np.abs(orbit.logarithms - [0, 0, -TURN / rate]).max() < 1e-9
    with rejected("too-many-steps", "1e-10"):
        periodic_orbit(
            compile_system(system), [small, rate], [0, 2.0, 2.0], TURN / rate, [TURN, 0, 0],
            free_period=False, phase_state=0,
        )  # fmt: skip


def wheel(growth, decay):
    """The circle of radius 1, once round in a time of 1: z on it grows, w decays, both shaken by it."""
    r = 1 - x**2 - y**2
    rates = (
        r * x - TURN * y,
        TURN * x + r * y,
        growth * v + x * (1 + w * v) * (x**2 + y**2 - 1) + growth * r * y,
        -decay * w + r,
    )
    return System((x, y, v, w), rates)


def test_multipliers_beyond_rounding():
    """e^-2, e^5 and e^-90: the last is lost in a monodromy matrix, whose entries are rounded at e^-36 of the largest."""
    orbit = periodic_orbit(compile_system(wheel(5.0, 90.0)), [], [1, 0, 1e-4, 0], 1.01, [0, 0, 0, 0], phase_state=1)
    assert orbit.period == pytest.approx(1.0, abs=1e-11)
    assert np.abs(orbit.logarithms - [5, 0, -2, -90]).max() < 1e-8
    assert orbit.exponents.real == pytest.approx([5, 0, -2, -90], abs=1e-8)
    assert orbit.nontrivial_logarithms(1).real == pytest.approx([5, -2, -90], abs=1e-8)


def test_a_fast_decay_of_a_small_state_is_known():
    """A circle with exponents 0, -1 and -1/10 of its own, and a state of the size of 1e-6 that follows it at the rate 60."""
    grow, size = (1 - x**2 - v**2) / 2, 1e-6
    system = System((x, v, y, w), (-v + x * grow, x + v * grow, -60 * (y - size * x) - size * v, -w / 10))
    orbit = periodic_orbit(compile_system(system, 1e-14), [], [1.0, 0.0, size, 0.0], TURN, np.zeros(4), phase_state=1)
    np.testing.assert_allclose(orbit.exponents, [0.0, -0.1, -1.0, -60.0], rtol=0, atol=1e-10)


def test_an_orbit_that_a_run_leaves_at_once_is_found_from_samples():
    """A disturbance grows e^60-fold in a period: no start lies near enough for a run, but samples do."""
    system, tau = wheel(60.0, 3.0), np.linspace(0, TURN, 65)
    samples = 1.03 * np.array([np.cos(tau), np.sin(tau), 0.02 + 0 * tau, 0.02 * np.cos(3 * tau)])
    flow = compile_system(system)
    orbit = periodic_orbit(flow, [], samples, 1.02, [0, 0, 0, 0], phase_state=1)
    assert orbit.period == pytest.approx(1.0, abs=1e-10)
    assert orbit.state == pytest.approx([1, 0, 0, 0], abs=1e-9)
    assert np.abs(orbit.logarithms - [60, 0, -2, -3]).max() < 1e-7


def test_a_period_maps_the_rate_at_its_beginning_to_itself():
    """Of an orbit in several legs: each one's map stands to the left of those before it."""
    tau = np.linspace(0, TURN, 9)
    samples = np.array([np.cos(tau), np.sin(tau), 0 * tau, 0 * tau])
    orbit = periodic_orbit(compile_system(wheel(2.0, 3.0)), [], samples, 1.0, [0, 0, 0, 0], phase_state=1)
    along = np.array([0.0, TURN, 0.0, 0.0])
    assert orbit.monodromy @ along == pytest.approx(along, abs=1e-8)


def test_from_far_away_orbits_are_found_by_collocation():
    """The two pendula of AUTO, started with speeds wrong by up to a half; a step of Newton's method alone goes astray."""
    g, eps, torque = 0.175, 0.1, 0.4
    rates = (v, w, torque - eps * v - sp.sin(x) + g * (y - x), torque - eps * w - sp.sin(y) + g * (x - y))
    flow = compile_system(System((x, y, v, w), rates, angles=frozenset({x, y})))
    for angle, first, second in ((0.8, 5.0, 3.0), (1.2, 2.5, 5.5)):
        orbit = periodic_orbit(flow, [], [0, angle, first, second], TURN / 4, [TURN, TURN, 0, 0])
        assert orbit.period == pytest.approx(1.5738797, rel=1e-7)


def asked(reference: list[float], period: float, **more: object) -> Closing:
    n = len(reference)
    given = {"held_states": (), "free_period": False, "left_open": 0} | more
    return Closing(np.zeros(n), np.ones(n), np.array(reference, float), period, **given)  # type: ignore[arg-type]


def test_a_forced_oscillator_from_a_poor_motion() -> None:
    """x' = -a x + cos t from a constant: x = (a cos t + sin t)/(1 + a^2), seen from a time of 1."""
    system = System((x,), (-a * x + sp.cos(TIME),), (a,))
    found = close_orbit(system, np.array([0.3]), 1.0, np.full((1, 30), 0.7), asked([0.7], TURN), 25)
    t = 1.0 + TURN * found.times
    assert found.period == pytest.approx(TURN, rel=1e-14)
    np.testing.assert_allclose(found.states[0], (0.3 * np.cos(t) + np.sin(t)) / 1.09, atol=1e-10)


def test_a_free_period_and_a_held_state() -> None:
    """r' = r (1 - r^2), turning at the rate 3, from a circle of another radius at another rate."""
    r = 1 - x**2 - y**2
    system, tau = System((x, y), (r * x - 3 * y, 3 * x + r * y)), TURN * np.linspace(0, 1, 60)
    motion = np.array([0.6 * np.cos(tau), 0.6 * np.sin(tau)])
    found = close_orbit(system, np.zeros(0), 0.0, motion, asked([0.6, 0.0], 2.5, held_states=(1,), free_period=True), 25)
    assert found.period == pytest.approx(TURN / 3, rel=1e-9)
    assert found.states[:, 0] == pytest.approx([1.0, 0.0], abs=1e-9)


def test_of_a_family_the_nearest() -> None:
    """All motions of a linear oscillator are closed: none is preferred, the one that begins at the guess is found."""
    system, tau = System((x, v), (v, -x)), TURN * np.linspace(0, 1, 60)
    motion = np.array([1.2 * np.cos(tau), -1.1 * np.sin(tau)])
    found = close_orbit(system, np.zeros(0), 0.0, motion, asked([1.2, 0.0], TURN), 25)
    np.testing.assert_allclose(
        found.states, 1.2 * np.array([np.cos(TURN * found.times), -np.sin(TURN * found.times)]), atol=1e-9
    )


def test_where_there_is_none_it_is_told() -> None:
    """x'' = 1 + x^2 has no periodic motion at all."""
    system, tau = System((x, v), (v, 1 + x**2)), TURN * np.linspace(0, 1, 60)
    with pytest.raises(RunError):
        close_orbit(system, np.zeros(0), 0.0, np.array([np.cos(tau), -np.sin(tau)]), asked([1.0, 0.0], TURN), 25)
