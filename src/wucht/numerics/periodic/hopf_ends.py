"""Hopf points at which branches of periodic orbits shrink to an equilibrium, confirmed by their eigenvalues."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from wucht.errors import RunError
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import CurvePoint, Equations
from wucht.numerics.continuation.equilibria import HOPF, Equilibria, Equilibrium
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.periods import equilibrium_equations

SHRINKS = "it shrinks to an equilibrium: a Hopf point"
VANISHES = "it shrinks to a point, at which no Hopf point was confirmed"

_POINTS = 40  # of the equilibria, each way, among which a special one is searched
_STEPS = Steps(first=1e-3, most=0.05, points=_POINTS)
_AGREE_FREQUENCY = 0.1  # relative, of the last orbit and the Hopf point
_NEAR = 0.5  # of the size of the last orbit but one: largest distance of the Hopf point from the last one


def equilibria_of(orbits: Equations) -> Equilibria:
    """Return the equilibria of the System whose orbits have these equations, without bounds, in short steps."""
    return Equilibria(equilibrium_equations(orbits), (-math.inf, math.inf), _STEPS)


def nearest_special(equilibria: Equilibria, start: CurvePoint, kind: str) -> Equilibrium | None:
    """Return the nearest point of a kind, either way, on the branch of equilibria through a point."""

    def ways() -> Iterator[Equilibrium]:
        for point in (start, equilibria.curve.backwards(start)):
            special = next((p for p in islice(equilibria.walk(point), _POINTS) if p.kind == kind), None)
            if special is not None:
                yield special

    return min(ways(), key=lambda p: abs(p.point.length), default=None)


def hopf_point(orbits: Equations, last: Sequence[Cycle]) -> Equilibrium | None:
    """Return the Hopf point at which shrinking orbits end, or None where there is none.

    A pair of eigenvalues crosses the imaginary axis there, with the frequency of the orbits, and its distance from the last
    orbit agrees with the square of the orbits' size, which is linear in the parameter.

    orbits: the equations y' = T f(y, p). last: the last orbits of the branch, two or more where there are as many.
    """
    here, before = last[-1], last[-2:][0]
    value, size = here.parameter, math.sqrt(_square(before))
    if len(last) > 1:
        a, b, p, q = _square(before), _square(here), before.parameter, here.parameter
        if b > a:
            return None
        value = q if a == b else (a * q - b * p) / (a - b)
    equilibria, (mean, mean_before) = equilibria_of(orbits), (c.states @ c.problem.mesh.shares for c in (here, before))
    try:  # from beside it, where the crossing can be detected
        hopf = nearest_special(equilibria, equilibria.start(mean_before, before.parameter), HOPF)
    except RunError:
        return None
    if hopf is None or abs(hopf.frequency * here.period / (2 * math.pi) - 1) > _AGREE_FREQUENCY:
        return None
    away = (hopf.unknowns - np.append(mean, value)) / equilibria.equations.scale
    parameter_change = abs(here.parameter - before.parameter) / equilibria.equations.scale[-1]
    near = np.linalg.norm(away[:-1]) < _NEAR * size and abs(away[-1]) < max(parameter_change, _NEAR * size)
    return hopf if near else None


def _square(cycle: Cycle) -> float:
    """Return the mean square of an orbit's deviation from its mean, by its sizes."""
    shares, y = cycle.problem.mesh.shares, cycle.states / cycle.problem.sizes[:-2, None]
    return float((((y - (y @ shares)[:, None]) ** 2) @ shares).sum())
