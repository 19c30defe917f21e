"""Narrow transitions that Taylor's method sees from afar.

A Taylor step knows of what lies ahead only what the coefficients at its beginning show. Those of tanh(u) decay with
exp(-2 abs(u)): many widths away from u = 0 it is flat to the last bit, and a step may pass the whole transition without a
trace. The logarithm of 1 + u^2 is steep nowhere, but singular at u = +-i, and its coefficients of order p decay with
abs(u -+ i)^-p alone. heyoka's steps are accurate for the states and for all functions that are watched for events, relative to
the largest of them. So for each tanh a function is watched that never has a zero: it holds a step to a part of the distance
from the transition.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import sympy as sp

from wucht.numerics.flow.program import Program

# The function stays below the states' size up to abs(u) of 1e6, so that it does not lower their accuracy; at any tolerance that
# a question may have it is large enough to be felt.
_WEIGHT = 1 / 32


def arguments(program: Program) -> tuple[sp.Expr, ...]:
    """What the program takes tanh of, in its lines' and states' symbols and constants."""
    expressions = [*(e for _, e in program.lines), *program.results]
    found = set[sp.Expr]().union(*({t.args[0] for t in e.atoms(sp.tanh)} for e in expressions))
    return tuple(sorted(found, key=sp.default_sort_key))


def sentinels(program: Program, variables: Sequence[Any], translate: Callable[[sp.Expr], Any]) -> list[Any]:
    """The functions to be watched, as heyoka's expressions. translate: has seen the lines."""
    import heyoka as hy

    size = hy.sqrt(1.0 + hy.sum([s * s for s in variables]))
    watched = [translate(u) for u in arguments(program)]
    return [_WEIGHT * size * (1.0 + hy.log(1.0 + u * u)) for u in watched]


def unheard(*_: Any) -> None:
    """What happens at the zeros of a function that has none."""
