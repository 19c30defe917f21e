from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from tests.refusals import rejected

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.orbits import periodic_orbit
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.floquet import integrated_maps, logarithms, transverse_maps
from wucht.numerics.periodic.periods import with_forcing_phase, with_period_unit
from wucht.system import TIME, System

X, V = sp.symbols("x v", real=True)
OMEGA, FORCE, DAMPING = sp.symbols("omega force damping", real=True)
DUFFING = System((X, V), (V, FORCE * sp.cos(OMEGA * TIME) - DAMPING * V - X - X**3), (OMEGA, FORCE, DAMPING))
FIXED = {"force": 0.3, "damping": 0.1}


def orbit(cycles: Cycles, omega: float) -> Cycle:
    values = {"omega": omega} | FIXED
    period = 2 * math.pi / omega

    def rates(t: float, x: np.ndarray) -> list[float]:
        return [x[1], values["force"] * math.cos(omega * t) - values["damping"] * x[1] - x[0] - x[0] ** 3]

    run = solve_ivp(rates, (0, 40 * period), [0.0, 0.0], rtol=1e-8, atol=1e-8, dense_output=True)
    times = 39 * period + np.linspace(0, period, 81)
    return cycle_near(cycles, times, np.vstack([run.sol(times), omega * times]), omega)


def harmonic_balance(omega: float, guess: np.ndarray, harmonics: int = 9) -> np.ndarray:
    """Coefficients of cos, sin of the odd harmonics of x'' + d x' + x + x^3 = F cos(omega t)."""
    theta = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    orders = np.arange(1, 2 * harmonics, 2)
    waves = np.concatenate([np.cos(np.outer(orders, theta)), np.sin(np.outer(orders, theta))])

    def left(c: np.ndarray) -> np.ndarray:
        a, b = c[:harmonics], c[harmonics:]
        x = c @ waves
        cubic = waves @ x**3 * 2 / len(theta)
        k = orders * omega
        off = np.concatenate([(1 - k**2) * a + 0.1 * k * b, (1 - k**2) * b - 0.1 * k * a]) + cubic
        off[0] -= 0.3
        return off

    start = np.zeros(2 * harmonics)
    start[[0, harmonics]] = guess
    found = fsolve(left, start, xtol=1e-10, full_output=True)[0]  # at rounding it would warn
    assert np.abs(left(found)).max() < 1e-10
    return np.asarray(found)


def test_response_of_a_forced_duffing_oscillator() -> None:
    """Along the resonance curve with its two folds: amplitude by harmonic balance, multipliers by Liouville and by shooting."""
    cycles = Cycles.of(with_forcing_phase(DUFFING, "omega"), "omega", FIXED, (0.8, 2.2), winding={"forcing.phase": 1})
    first = orbit(cycles, 0.9)
    start = first if first.point.tangent[-1] > 0 else cycles.backwards(first)
    points = list(cycles.walk(start))
    assert [p.kind for p in points if p.kind] == ["fold", "fold"] and points[-1].parameter == 2.2
    for p in points[:: max(1, len(points) // 8)]:
        omega, x, phase = p.parameter, p.states[0], p.states[2]
        a = p.integral(x * np.cos(phase)) * 2 / p.period
        b = p.integral(x * np.sin(phase)) * 2 / p.period
        balance = harmonic_balance(omega, np.array([a, b]))
        np.testing.assert_allclose([a, b], balance[[0, 9]], atol=3e-6)
        assert p.period == pytest.approx(2 * math.pi / omega, rel=1e-7)
        assert p.logarithms.sum().real == pytest.approx(-0.1 * p.period, abs=1e-5)

    p = points[len(points) // 3]
    fixed = FIXED | {"omega": p.parameter}
    edges = p.problem.mesh.edges
    maps, flow = integrated_maps(with_forcing_phase(DUFFING, "omega"), fixed, edges * p.period, p.states_at(edges))
    values = np.exp(logarithms(transverse_maps(maps, flow)[0])[0])
    shift = p.states[2, 0] / p.parameter
    shot = periodic_orbit(
        compile_system(DUFFING, 1e-14), fixed, p.states[:2, 0], p.period, np.zeros(2), free_period=False, time=shift
    )
    np.testing.assert_allclose(shot.state, p.states[:2, 0], atol=1e-6)
    np.testing.assert_allclose(np.sort_complex(shot.multipliers), np.sort_complex(values), atol=1e-6)


def test_what_cannot_be_forced_is_told() -> None:
    with rejected("no-parameter"):
        with_forcing_phase(DUFFING, "phi")
    with rejected("other-period", "2"):
        with_forcing_phase(DUFFING, "damping")
    with rejected("other-period"):
        with_forcing_phase(System((X,), (TIME - X,), (OMEGA,)), "omega")


def test_in_periods_leaves_a_time_to_be_told() -> None:
    with rejected("time-dependent"):
        with_period_unit(DUFFING)
    whole = with_period_unit(with_forcing_phase(DUFFING, "omega"))
    assert whole.parameter_names[0] == "_period" and len(whole.states) == 3
