"""What tests of averaging share: a System run by SciPy at a tight tolerance, its outputs, and the order of errors."""

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp

from wucht.system import TIME


def run(system, values, start, time):
    """The states (n, N) at the times, to 1e-12; shares nothing with wucht's own numerics."""
    at = {p: sp.Float(values[p.name], 17) for p in system.parameters}
    rates = sp.lambdify((TIME, system.states), [system.explicit(f).xreplace(at) for f in system.derivatives], "math", cse=True)
    solution = solve_ivp(rates, (time[0], time[-1]), start, "DOP853", t_eval=time, rtol=1e-12, atol=1e-12)
    assert solution.success
    return solution.y


def evaluate(system, expressions, values, time, states):
    """Expressions in a System's symbols (m, N) along a run."""
    at = {p: sp.Float(values[p.name], 17) for p in system.parameters}
    called = sp.lambdify((TIME, system.states), [system.explicit(e).xreplace(at) for e in expressions], "numpy", cse=True)
    return np.array([np.broadcast_to(v, time.shape) for v in called(time, states)])


def full(slow, names, values, time, states):
    """The outputs ``full.<name>`` of an averaged System along its run."""
    return evaluate(slow, [slow.output(f"full.{n}").expression for n in names], values, time, states)


def order(small, errors):
    """The exponent p of errors ~ small^p, by least squares."""
    return float(np.polyfit(np.log(small), np.log(errors), 1)[0])
