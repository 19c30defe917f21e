"""Rotating bodies by hand: a rotor with a body about it and a second rotor, their solved equations, outputs and works."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from wucht.mechanics.phasors import Lines, Phasor
from wucht.mechanics.rotating_bodies.averaged_system import derive_averaged_system
from wucht.mechanics.rotating_bodies.bodies import RotatingBodies, absolute_torque_slope, body_symbol
from wucht.mechanics.rotating_bodies.coupling import Coupling, _is_round
from wucht.mechanics.rotating_bodies.solution import _largest_radius, with_inertia, without_inertia
from wucht.system import TIME, System

# Rotor a with the body b about it, and rotor c: on a carrier of mass 3 in x and y, sprung alike.
BODIES = RotatingBodies(
    names=("a", "b", "c"),
    heads=(0, 0, 2),
    inertia=sp.ImmutableMatrix([[2, 0, 0], [0, 3, 0], [0, 0, 5]]),
    relative=sp.ImmutableMatrix([[7, -7, 0], [-7, 7, 0], [0, 0, 0]]),
    drive=(lambda v: 20 - v, lambda v: sp.S.Zero, lambda v: 4 - v / 2),
    losses=(lambda v: v / 4, lambda v: v / 8, lambda v: sp.S.Zero),
    mass=sp.ImmutableMatrix([[3, 0], [0, 3]]),
    damping=sp.ImmutableMatrix([[1, 0], [0, 1]]),
    stiffness=sp.ImmutableMatrix([[100, 0], [0, 100]]),
    excitation=tuple((Phasor(sp.Rational(u)), Phasor(sp.S.Zero, -sp.Rational(u))) for u in ("1/2", "1/4", "1/8")),
    labels=("x", "y"),
    axis=sp.ImmutableMatrix([[1, 0], [0, 1]]),
)
AT = {"a.speed": 4.0, "b.speed": 4.5, "c.speed": 3.5, "b.phase": 0.6, "c.phase": -1.1}


def values(system: System, wanted: tuple[str, ...], at: dict[str, float] = AT) -> list[float]:
    numbers: dict[sp.Symbol, float] = {s: at[s.name] for s in system.states}
    for symbol, expression in system.definitions:
        numbers[symbol] = float(sp.sympify(expression).xreplace(numbers))
    return [float(sp.sympify(system.output(name).expression).xreplace(numbers)) for name in wanted]


def vibration() -> tuple[np.ndarray, np.ndarray]:
    """z (2,) and the torques V (3,) in complex numbers."""
    w, alpha = AT["a.speed"], np.array([0.0, AT["b.phase"], AT["c.phase"]])
    excitation = np.array([[u, -1j * u] for u in (0.5, 0.25, 0.125)])
    z = w**2 * (np.exp(1j * alpha) @ excitation) / (100 - 3 * w**2 + 1j * w)
    return z, 0.5 * (np.exp(1j * alpha) * (excitation @ np.conj(-(w**2) * z))).imag


def test_phases_are_measured_from_the_rotor_and_of_rotors_from_the_main_one() -> None:
    assert BODIES.rotors == (0, 2) and BODIES.free == [0, 1, 2] and BODIES.group(0) == [0, 1] and BODIES.group(2) == [2]
    deep = replace(BODIES, heads=(0, 2, 2))
    b, c = (body_symbol(n, "phase") for n in "bc")
    assert [BODIES.total_phase(i) for i in range(3)] == [0, b, c] and deep.total_phase(1) == b + c
    assert [deep.reference(i) for i in range(3)] == [0, 2, 0]
    assert absolute_torque_slope(BODIES, 0, sp.Integer(3)) == -sp.Rational(5, 4)
    fixed = replace(BODIES, fixed_speed=sp.Integer(9))
    assert fixed.free == [1, 2] and fixed.frequency == 9 and fixed.speed(2) == body_symbol("c", "speed")


def test_outputs_with_the_inertia_of_all_bodies() -> None:
    system = derive_averaged_system(BODIES).system
    z, torques = vibration()
    radius = abs(z[0] + 1j * z[1]) / 2 + abs(z[0] - 1j * z[1]) / 2
    assert values(system, ("amplitude",)) == pytest.approx([radius])
    names = ("amplitude.re[x]", "amplitude.im[x]", "amplitude.re[y]", "amplitude.im[y]")
    assert values(system, names) == pytest.approx([z[0].real, z[0].imag, z[1].real, z[1].imag])
    assert values(system, tuple(f"vibration_torque[{n}]" for n in "abc")) == pytest.approx(torques)
    assert values(system, tuple(f"speed[{n}]" for n in "abc")) == pytest.approx([4.0, 4.5, 3.5])
    assert values(system, ("motor_torque", "rotor_angle")) == pytest.approx([16.0, 4.0])
    assert values(system, ("stored_energy",)) == pytest.approx([(2 * 4**2 + 3 * 4.5**2 + 5 * 3.5**2) / 2])
    supplied, lost = 16.0 * 4 + 2.25 * 3.5, 4 * 4 / 4 + 4.5 * 4.5 / 8 + 7 * 0.5**2
    vibrating = -float(torques @ [4.0, 4.5, 3.5])
    assert values(system, ("supplied_work", "dissipated_work", "vibration_work")) == pytest.approx([supplied, lost, vibrating])


def test_accelerations_with_the_inertia_of_all_bodies() -> None:
    system = derive_averaged_system(BODIES).system
    _, torques = vibration()
    numbers: dict[sp.Symbol, float] = {s: AT[s.name] for s in system.states}
    for symbol, expression in system.definitions:
        numbers[symbol] = float(sp.sympify(expression).xreplace(numbers))
    rates = {s.name: float(sp.sympify(d).xreplace(numbers)) for s, d in zip(system.states, system.derivatives, strict=True)}
    expected = {
        "a.speed": (16.0 - 1.0 + 7 * 0.5 + torques[0]) / 2, "b.speed": (-4.5 / 8 - 7 * 0.5 + torques[1]) / 3,
        "c.speed": (2.25 + torques[2]) / 5, "b.phase": 0.5, "c.phase": -0.5,
    }  # fmt: skip
    assert rates == pytest.approx(expected)


def test_outputs_where_a_body_keeps_no_inertia() -> None:
    """It is taken at the speed of its rotor, and w' moves both: its slip is (V - J w' - losses)/7."""
    system = derive_averaged_system(BODIES, inertia=False).system
    assert [s.name for s in system.states] == ["b.phase", "c.phase", "a.speed", "c.speed"]
    _, torques = vibration()
    rate = (16.0 - 1.0 - 4.0 / 8 + torques[0] + torques[1]) / 5
    slip = (torques[1] - 4.0 / 8 - 3 * rate) / 7
    assert values(system, ("speed[b]",)) == pytest.approx([4.0 + slip])
    assert values(system, ("stored_energy",)) == pytest.approx([(5 * 4.0**2 + 5 * 3.5**2) / 2])
    supplied, lost, vibrating = 16.0 * 4 + 2.25 * 3.5, 4 * 4 / 4 + 4 * 4 / 8, -float(torques @ [4.0, 4.0, 3.5])
    assert values(system, ("supplied_work", "dissipated_work", "vibration_work")) == pytest.approx([supplied, lost, vibrating])


def test_rows_as_they_stand_on_paper() -> None:
    """Each with its inertia, torques and losses; without inertia of a body: of a group the sum, and of the body its slip."""
    V = sp.symbols("V_a V_b V_c", real=True)
    a, b, c, da, db, dc = (body_symbol(n, q) for q in ("speed", "speed.rate") for n in "abc")
    _, _, rows = with_inertia(BODIES, Lines(), V)
    assert [sp.expand(lhs - rhs) for lhs, rhs in rows] == [
        sp.expand(2 * da - (20 - a - a / 4 - 7 * a + 7 * b + V[0])), sp.expand(3 * db - (-b / 8 + 7 * a - 7 * b + V[1])),
        sp.expand(5 * dc - (4 - c / 2 + V[2])),
    ]  # fmt: skip
    speeds, accelerations, rows = without_inertia(BODIES, Lines(), V)
    slip = body_symbol("b", "slip")
    assert [sp.expand(lhs - rhs) for lhs, rhs in rows] == [
        sp.expand(5 * da - (20 - a - a / 4 - a / 8 + V[0] + V[1])), sp.expand(7 * slip - (-a / 8 + V[1] - 3 * da)),
        sp.expand(5 * dc - (4 - c / 2 + V[2])),
    ]  # fmt: skip
    assert speeds[0] == a and speeds[2] == c and accelerations[0] == accelerations[1]


def test_a_prescribed_speed_that_grows_turns_its_body_too() -> None:
    """Without inertia of the body it slips by J w'/7 against it, and no row is left for the rotor."""
    growing = replace(BODIES, fixed_speed=3 + 2 * TIME)
    _, accelerations, rows = without_inertia(growing, Lines(), (sp.S.Zero,) * 3)
    assert accelerations[:2] == [2, 2] and len(rows) == 2
    (_, rhs), _ = rows
    assert sp.expand(rhs + (3 + 2 * TIME) / 8 + 3 * 2) == 0
    _, torques = vibration()
    # The motor moves its rotor alone, against the damper; or with the body, which keeps no inertia of its own.
    alone, together = 2 * 2 + 4.0 / 4 + 7 * (4.0 - 4.5) - torques[0], (2 + 3) * 2 + 4.0 / 4 + 4.0 / 8 - torques[0] - torques[1]
    for inertia, states, motor in ((True, ["b.speed", "c.speed"], alone), (False, ["c.speed"], together)):
        system = derive_averaged_system(growing, inertia).system
        assert [s.name for s in system.states] == ["b.phase", "c.phase", *states]
        numbers = {TIME: 0.5} | {s: AT[s.name] for s in system.states}
        for symbol, expression in system.definitions:
            numbers[symbol] = float(sp.sympify(expression).xreplace(numbers))
        assert float(sp.sympify(system.output("motor_torque").expression).xreplace(numbers)) == pytest.approx(motor)


def test_a_prescribed_speed_that_grows_moves_what_is_coupled_to_it_by_inertia() -> None:
    """As a roller in a drum: J_b w_b' = ... - J_ab w_a'."""
    coupled = sp.ImmutableMatrix(BODIES.inertia + sp.Matrix(3, 3, lambda i, k: int({i, k} == {0, 1})))
    for inertia, more in ((BODIES.inertia, 0), (coupled, -2)):
        growing = replace(BODIES, fixed_speed=3 + 2 * TIME, inertia=inertia)
        _, accelerations, rows = with_inertia(growing, Lines(), (sp.S.Zero,) * 3)
        b = body_symbol("b", "speed")
        (lhs, rhs), _ = rows
        assert lhs == 3 * body_symbol("b", "speed.rate") and accelerations[0] == 2
        assert sp.expand(rhs - (-b / 8 - 7 * (b - 3 - 2 * TIME) + more)) == 0


def test_phase_rates_of_followers_are_slips_where_they_keep_no_inertia() -> None:
    a, b, c = (body_symbol(n, "speed") for n in "abc")
    with_all, without = (derive_averaged_system(BODIES, inertia).rows for inertia in (True, False))
    assert with_all[:2] == ((body_symbol("b", "phase.rate"), b - a), (body_symbol("c", "phase.rate"), c - a))
    assert without[:2] == ((body_symbol("b", "phase.rate"), body_symbol("b", "slip")), (body_symbol("c", "phase.rate"), c - a))


def test_the_largest_radius_is_the_semi_major_axis() -> None:
    """Of x = 3 cos, y = 2 sin it is 3, whichever way; along a line its length; of one direction its amplitude."""
    for x, y, radius in ((3, -2j, 3.0), (3, 2j, 3.0), (3, 4, 5.0), (1, -2j, 2.0)):
        motion = [Phasor(sp.Integer(int(complex(c).real)), sp.Integer(int(complex(c).imag))) for c in (x, y)]
        lines = Lines()
        expression = _largest_radius(BODIES, lines, motion)
        for symbol, meaning in reversed(lines.pairs):
            expression = expression.xreplace({symbol: meaning})
        assert float(expression) == pytest.approx(radius)
    one = replace(BODIES, axis=sp.ImmutableMatrix([[1, 0]]))
    lines = Lines()
    expression = _largest_radius(one, lines, [Phasor(sp.Integer(3), sp.Integer(4)), Phasor(sp.Integer(9))])
    for symbol, meaning in reversed(lines.pairs):
        expression = expression.xreplace({symbol: meaning})
    assert float(expression) == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("change", "is_round"),
    [
        ({}, True), ({"stiffness": sp.ImmutableMatrix([[100, 0], [0, 101]])}, False),
        ({"damping": sp.ImmutableMatrix([[1, 1], [1, 1]])}, False), ({"mass": sp.ImmutableMatrix([[3, 0], [0, 4]])}, False),
        ({"labels": ("x", "y", "z")}, False),
        ({"excitation": tuple((Phasor(sp.S.One), Phasor(sp.S.Zero, sp.S.One)) for _ in range(3))}, False),
    ],
)  # fmt: skip
def test_a_round_carrier_pulses_no_body(change: dict[str, object], is_round: bool) -> None:
    assert _is_round(replace(BODIES, **change)) is is_round  # type: ignore[arg-type]


def test_torques_at_twice_the_speed() -> None:
    """Re[T exp(2 i theta)] with T = i w^2/2 (E . z) exp(i alpha), of any motion z."""
    lines = Lines()
    coupling = Coupling(BODIES, lines)
    z = [Phasor(sp.Rational(1, 3), sp.Rational(1, 5)), Phasor(sp.Rational(-1, 4), sp.Rational(2, 3))]
    computed = coupling.alternating(z)
    at = {sp.Symbol(f"{n}.{q}", real=True): AT[f"{n}.{q}"] for n, q in (("a", "speed"), ("b", "phase"), ("c", "phase"))}

    def number(e: sp.Expr) -> float:
        for symbol, meaning in reversed(lines.pairs):
            e = sp.sympify(e).xreplace({symbol: meaning})
        return float(sp.sympify(e).xreplace(at))

    numbers = np.array([1 / 3 + 0.2j, -0.25 + 2j / 3])
    for u, alpha, t in zip((0.5, 0.25, 0.125), (0.0, 0.6, -1.1), computed, strict=True):
        expected = 0.5j * 4.0**2 * (u * numbers[0] - 1j * u * numbers[1]) * np.exp(1j * alpha)
        assert (number(t.re), number(t.im)) == pytest.approx((expected.real, expected.imag))
    assert math.isclose(number(coupling.direction[1].re), math.cos(0.6))


E = np.array([[u, -1j * u] for u in (0.5, 0.25, 0.125)])
J, B = np.diag([2.0, 3.0, 5.0]), np.array([[7.0, -7.0, 0.0], [-7.0, 7.0, 0.0], [0.0, 0.0, 0.0]])


def changing(
    w: float, alpha: np.ndarray, k: tuple[float, float] = (100.0, 100.0), pulsing: np.ndarray | float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray]]:
    """Torques V (3,), their change with slips S and accelerations A (3, 3), and what displacements z (2,) consist of.

    z = H F - i H' F' - (i/2) H'' w' F for F = sum E_k (phi_k'^2 - i phi_k'') exp(i alpha_k), the acceleration likewise with
    G = -w^2 H: linear in phi_k' - w and phi_k''; w' is that of the first body. pulsing (2,): a change of the moments.
    """
    s = sp.Symbol("s")
    of = [1 / (stiffness - 3 * s**2 + sp.I * s) for stiffness in k]
    h, g = (
        [np.array([complex(sp.diff(factor * f, s, n).xreplace({s: sp.Float(w)})) for f in of]) for n in range(3)]
        for factor in (1, -(s**2))
    )
    e = E * np.exp(1j * alpha)[:, None]
    force = w**2 * (e.sum(axis=0) + pulsing)

    def parts(f: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        slips, accelerations = e * (f[0] * 2 * w + f[1] * w**2), e * (-1j * f[0] - 2j * w * f[1])
        accelerations[0] += -0.5j * f[2] * force
        return f[0] * force, slips, accelerations

    def torques(acceleration: np.ndarray) -> np.ndarray:
        return -0.5 * (np.exp(-1j * alpha) * (np.conj(E) @ acceleration)).imag

    steady, slips, accelerations = parts(g)
    V, S, A = torques(steady), np.array([torques(z) for z in slips]).T, np.array([torques(z) for z in accelerations]).T
    return V, S, A, list(parts(h))


def test_second_order_with_the_inertia_of_all_bodies() -> None:
    """(J - A) theta'' + B theta' = L + V + S (theta' - w), and the carrier's motion that follows from both."""
    system = derive_averaged_system(BODIES, order=2).system
    speeds = np.array([4.0, 4.5, 3.5])
    V, S, A, (steady, by_slip, by_acceleration) = changing(4.0, np.array([0.0, 0.6, -1.1]))
    absolute = np.array([16.0 - 1.0, -4.5 / 8, 2.25])
    rates = np.linalg.solve(J - A, absolute + V + S @ (speeds - 4.0) - B @ speeds)
    computed = numbers_of(system)
    assert [computed[f"{n}.speed"] for n in "abc"] == pytest.approx(rates) and computed["b.phase"] == pytest.approx(0.5)
    z = steady + (speeds - 4.0) @ by_slip + rates @ by_acceleration
    names = ("amplitude.re[x]", "amplitude.im[x]", "amplitude.re[y]", "amplitude.im[y]")
    assert values(system, names) == pytest.approx([z[0].real, z[0].imag, z[1].real, z[1].imag])
    torques = V + S @ (speeds - 4.0) + A @ rates
    assert values(system, tuple(f"vibration_torque[{n}]" for n in "abc")) == pytest.approx(torques)


def numbers_of(system: System) -> dict[str, float]:
    """Rates of the states by their names."""
    numbers: dict[sp.Symbol, float] = {s: AT[s.name] for s in system.states}
    for symbol, expression in system.definitions:
        numbers[symbol] = float(sp.sympify(expression).xreplace(numbers))
    return {s.name: float(sp.sympify(d).xreplace(numbers)) for s, d in zip(system.states, system.derivatives, strict=True)}


def test_second_order_where_a_body_keeps_no_inertia() -> None:
    """The same equation for w' of both rotors and the slip of the body, whose rate is that of its slip of first order."""

    def slip(w: float, b: float, c: float) -> float:
        V = changing(w, np.array([0.0, b, c]))[0]
        rate = (20 - w - w / 4 - w / 8 + V[0] + V[1]) / 5
        return float((V[1] - w / 8 - 3 * rate) / 7)

    at, h = (4.0, 0.6, -1.1), 1e-5
    by_w, by_b, by_c = ((slip(*(np.array(at) + h * one)) - slip(*(np.array(at) - h * one))) / (2 * h) for one in np.eye(3))
    V, S, A, _ = changing(4.0, np.array([0.0, 0.6, -1.1]))
    # Unknown are w', the slip nu and the rate of c: theta' = (w, w + nu, w_c), theta'' = (w', w' + nu', w_c').
    turning, speeds = np.array([[0.0, 0, 0], [0, 1, 0], [0, 0, 0]]), np.array([4.0, 4.0, 3.5])
    rates, known = np.array([[1.0, 0, 0], [1 + by_w, by_b, 0], [0, 0, 1]]), np.array([0.0, by_c * (3.5 - 4.0), 0.0])
    absolute, slopes = np.array([16.0 - 1.0, -4.0 / 8, 2.25]), np.diag([-1.25, -1 / 8, -0.5])
    matrix = (J - A) @ rates + (B - S - slopes) @ turning
    rate, nu, other = np.linalg.solve(matrix, absolute + V + S @ (speeds - 4.0) - B @ speeds - (J - A) @ known)
    system = derive_averaged_system(BODIES, inertia=False, order=2).system
    computed = numbers_of(system)
    assert (computed["a.speed"], computed["c.speed"], computed["b.phase"]) == pytest.approx((rate, other, nu), rel=1e-7)
    assert values(system, ("speed[b]",)) == pytest.approx([4.0 + nu], rel=1e-7)


UNEVEN = replace(
    BODIES,
    stiffness=sp.ImmutableMatrix([[100, 0], [0, 140]]),
    weight=tuple(Phasor(sp.S.Zero, -sp.Rational(w)) for w in ("3", "2", "1")),
)


def fluctuation() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Torques T and W at twice the speed and at the speed, with J psi'' + k psi' = Re[W exp(i theta) + T exp(2 i theta)]."""
    w, turned = 4.0, np.exp(1j * np.array([0.0, 0.6, -1.1]))
    z = w**2 * (turned @ E) / (np.array([100.0, 140.0]) - 3 * w**2 + 1j * w)
    T, W = 0.5j * w**2 * (E @ z) * turned, -1j * np.array([3.0, 2.0, 1.0]) * turned
    k = B - np.diag([-1.25, -1 / 8, -0.5])  # with the slopes of drives and losses
    return T, W, np.linalg.solve(-4 * w**2 * J + 2j * w * k, T), np.linalg.solve(-(w**2) * J + 1j * w * k, W)


def test_the_fluctuation_within_a_turn() -> None:
    _, _, twice, once = fluctuation()
    fast = derive_averaged_system(UNEVEN).fast
    for quantity, amplitudes in (("ripple", twice), ("gravity", once)):
        names = tuple(f"{quantity}.{part}[{n}]" for n in "abc" for part in ("re", "im"))
        assert values(fast, names) == pytest.approx([x for a in amplitudes for x in (a.real, a.imag)])
    still = derive_averaged_system(BODIES).fast
    assert values(still, ("ripple.re[a]", "ripple.im[b]", "gravity.re[c]")) == [0.0, 0.0, 0.0]


def test_second_order_of_bodies_that_pulse() -> None:
    """The fluctuation changes the moments by -(i/2) sum conj(E exp(i alpha)) P, and the torques by -Im[T conj(P)]/2."""
    T, W, P, G = fluctuation()
    alpha = np.array([0.0, 0.6, -1.1])
    pulsing = -0.5j * (P @ np.conj(E * np.exp(1j * alpha)[:, None]))
    V, S, A, _ = changing(4.0, alpha, (100.0, 140.0), pulsing)
    V = V - (T * np.conj(P) + W * np.conj(G)).imag / 2
    speeds = np.array([4.0, 4.5, 3.5])
    absolute = np.array([16.0 - 1.0, -4.5 / 8, 2.25])
    rates = np.linalg.solve(J - A, absolute + V + S @ (speeds - 4.0) - B @ speeds)
    computed = numbers_of(derive_averaged_system(UNEVEN, order=2).system)
    assert [computed[f"{n}.speed"] for n in "abc"] == pytest.approx(rates)
