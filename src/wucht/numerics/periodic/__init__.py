"""Periodic orbits: branches in one parameter, Floquet multipliers, and curves of their bifurcations in two parameters.

Van der Pol's oscillator, from a nearly circular orbit at mu = 0.1 to mu = 1:

>>> import numpy as np
>>> import sympy as sp
>>> from wucht.numerics.periodic import Cycles, System, cycle_near
>>> x, y, mu = sp.symbols("x y mu", real=True)
>>> cycles = Cycles.of(System((x, y), (y, mu * (1 - x**2) * y - x), (mu,)), "mu", {}, bounds=(0.1, 1.0))
>>> time = np.linspace(0.0, 2 * np.pi, 50)
>>> first = cycle_near(cycles, time, 2 * np.array([np.cos(time), -np.sin(time)]), 0.1)
>>> *_, last = cycles.walk(first)
>>> f"at mu = {last.parameter:.1f} the period is {last.period:.6f}; {last.unstable} multipliers are unstable"
'at mu = 1.0 the period is 6.663287; 0 multipliers are unstable'

Branches: ``System``, ``Cycles``, ``Cycle``; of forced Systems by ``with_forcing_phase``. First orbits: ``cycle_near``,
``cycle_at_hopf``, ``cycle_at``, ``cycles_with``, ``doubled_branch``, ``crossing_branch``. Their ends: ``branch_end``,
``BranchEnd``. Over two parameters: ``CycleCurve``, ``CurveCycle``, and orbits between saddles: ``Connections``, ``Connection``,
``connection_from_excursion``. Other boundary value problems, by the same method: ``BoundaryValueProblem``, ``start_value``,
``end_value``, ``Solutions``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
