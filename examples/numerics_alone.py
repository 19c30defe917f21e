"""The numerics without any machine: a van der Pol oscillator, compiled once, run for three damping values, with its zeros.

python examples/numerics_alone.py
"""

import numpy as np
import sympy as sp

from wucht.numerics.flow import Event, System, compile_system, integrate


def periods(values: tuple[float, ...] = (0.1, 1.0, 5.0)) -> list[float]:
    """Periods of the limit cycle, from the last two upward zeros of x."""
    x, v, mu = sp.symbols("x v mu", real=True)
    oscillator = System(states=(x, v), derivatives=(v, mu * (1 - x**2) * v - x), parameters=(mu,))
    flow = compile_system(oscillator, events=(Event("upward zero", x, direction=+1),))
    result = []
    for value in values:
        run = integrate(flow, [2.0, 0.0], {"mu": value}, np.linspace(0, 200, 11))
        result.append(run.hits[-1].time - run.hits[-2].time)
    return result


if __name__ == "__main__":
    for value, period in zip((0.1, 1.0, 5.0), periods(), strict=True):
        print(f"mu = {value}: period {period:.9f}")
