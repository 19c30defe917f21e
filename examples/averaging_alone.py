"""Averaging without any machine: a van der Pol oscillator, its averaged equations derived, printed and integrated.

python examples/averaging_alone.py
"""

import numpy as np
import sympy as sp

from wucht.mechanics import Averaging, averaged, with_amplitude_and_phase
from wucht.numerics.flow import System, compile_system, integrate

x, v, r, psi, mu = sp.symbols("x v r psi mu", real=True)
OSCILLATOR = System(states=(x, v), derivatives=(v, mu * (1 - x**2) * v - x), parameters=(mu,))


def slow(order: int) -> Averaging:
    """The averaged equations of amplitude and phase, x = r cos(t + psi)."""
    return averaged(with_amplitude_and_phase(OSCILLATOR, x, v, sp.S.One, r, psi), mu, order)


def largest_error(order: int, value: float = 0.05) -> float:
    """Largest error of x, with the fast part restored, up to t = 1/mu, from r = 1, psi = 0 of the averaged equations."""
    time = np.linspace(0, 1 / value, 201)
    flow = compile_system(slow(order).system)
    run = integrate(flow, [1.0, 0.0], {"mu": value}, time)
    approximation = flow.outputs(time, run.states, run.final_parameter_values)
    exact = integrate(compile_system(OSCILLATOR), [approximation["x"][0], approximation["v"][0]], {"mu": value}, time)
    return float(abs(approximation["x"] - exact.states[0]).max())


if __name__ == "__main__":
    for order in (1, 2):
        result = slow(order)
        for state, rate in zip(result.system.states, result.system.derivatives, strict=True):
            print(f"order {order}: {state}' = {sp.factor(rate)}")
        print(f"order {order}: largest error of x at mu = 0.05 up to t = 20: {largest_error(order):.1e}")
