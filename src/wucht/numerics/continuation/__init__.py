"""Continuation: branches of equilibria and of what changes along them, for any System or any residual given as a function.

The equilibria of x' = p + 3 x - x^3, which turn at p = 2 and p = -2:

>>> import sympy as sp
>>> from wucht.numerics.continuation import EquilibriumContinuation, EquilibriumEquations, System
>>> x, p = sp.symbols("x p", real=True)
>>> equations = EquilibriumEquations.from_system(System((x,), (p + 3 * x - x**3,), (p,)), ["p"], {})
>>> problem = EquilibriumContinuation(equations, bounds=(-4.0, 4.0))
>>> branch = problem.follow_branch(problem.start([-2.0], -2.0))
>>> [f"{point.kind} at p = {point.parameter:.4f}, x = {point.x[0]:.4f}" for point in branch.special]
['fold at p = 2.0000, x = -1.0000', 'fold at p = -2.0000, x = 1.0000']

Equations: ``System``, ``EquilibriumEquations``, ``FunctionProblem``. Over one parameter: ``EquilibriumContinuation``,
``Equilibrium``, ``Branch``, and branches that touch no other: ``disconnected_branches``, ``equilibria_at``, ``random_starts``.
Normal form of a Hopf point: ``hopf_form``, ``HopfForm``. Over two parameters: ``Folds``, ``Fold``, ``HopfPoints``,
``HopfPoint``, ``SpecialCurve``. Any curve: ``Curve``, ``CurvePoint``, ``Steps``, ``Walk``.
"""

import lazy_loader

from wucht.earlier_names import provide_earlier_names

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
provide_earlier_names(__name__)
