"""Rotating bodies by hand: a rotor with a body about it and a second rotor, their solved equations, outputs and works."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from wucht.mechanics.phasors import Phasor
from wucht.mechanics.rotating_bodies.averaged_system import derive_averaged_system
from wucht.mechanics.rotating_bodies.bodies import RotatingBodies
from wucht.system import System

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
