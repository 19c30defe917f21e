"""Why a curve of connections does not go on: what its saddle becomes, and where its orbit winds up."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wucht.numerics.periodic.connection import Connection

SADDLE_NODE = "the saddle becomes a saddle-node"
LEFT_TWICE = "the saddle comes to be left in a second direction, too"
HOPF = "the saddle is no longer reached: it has a Hopf point"
BOGDANOV_TAKENS = "it shrinks to its saddle: a Bogdanov-Takens point"
STANDS = "it stays ever longer near something else on its way, while the parameters no longer change"

LONG = 20  # points one after another at which the parameters stand: then they do for good

_STILL = 1e-4  # share of the parameters in a step, at most, where they stand
_VANISHED = 0.02  # of the largest that they were: where both leading eigenvalues are smaller, both vanish
_ROUNDING = 1e-9  # of the largest eigenvalue: a real part that is smaller says nothing


def leading(connection: Connection) -> float:
    """The larger one of the leaving and the slowest reaching eigenvalue."""
    return float(np.abs(connection.eigenvalues[0, :2]).max())


def ended(folds: Sequence[bool], start: Connection, there: Connection, largest: float) -> str:
    """Why a curve does not last to a point, empty where it does.

    folds: which equilibria are saddle-nodes. start: where it begins. largest: what ``leading`` has been on the way.
    """
    for first, now, fold in zip(start.eigenvalues, there.eigenvalues, folds, strict=True):
        if fold:
            continue
        if not now[0].real > 0:
            return SADDLE_NODE
        # A real part that is zero everywhere, by a symmetry, is no end.
        reached = len(now) > 1 and first[1].real < -_ROUNDING * float(np.abs(first).max())
        if reached and not now[1].real < 0:
            return HOPF if now[1].imag else LEFT_TWICE
    returns = len(folds) == 1 and not folds[0] and there.eigenvalues.shape[1] > 1
    return BOGDANOV_TAKENS if returns and leading(there) < _VANISHED * largest else ""


def stands(here: Connection, there: Connection, scale: np.ndarray) -> bool:
    """Whether from one point to the next the orbit changes, but not the parameters, measured by sizes (m,)."""
    moved = np.linalg.norm((there.parameters - here.parameters) / scale)
    return bool(moved < _STILL * (there.point.length - here.point.length))


def standing(names: Sequence[str], at: Connection) -> str:
    """The sentence for the end at a point where the parameters, by their names, stand."""
    return f"{STANDS}, {', '.join(f'{name} = {value:.7g}' for name, value in zip(names, at.parameters, strict=True))}"
