"""Orbits between equilibria by collocation: test functions of special points, extension in time, ends of curves."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.earlier_names import with_earlier_names
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.collocation.solutions import CollocationSolution

NEUTRAL_SADDLE, SADDLE_FOCUS, THREE_LEADING = "neutral-saddle", "saddle-focus", "three-leading"

_MOST_ADDED = 100  # intervals of a mesh
_NEAR = 1e-7  # of the orbit's size: distance from a saddle to which an orbit is extended
SADDLE_NODE = "the saddle becomes a saddle-node"
LEFT_TWICE = "the saddle becomes unstable in a second direction"
HOPF = "the saddle is no longer reached: it has a Hopf point"
BOGDANOV_TAKENS = "it shrinks to its saddle: a Bogdanov-Takens point"
STANDSTILL = "it stays ever longer near another equilibrium or orbit, while the parameters no longer change"
LONG = 20  # consecutive points at which the parameters stand still: then they do so permanently
_STILL = 1e-4  # largest share of the parameters in a step, where they stand still
_VANISHING = 0.02  # of their largest value: where both leading eigenvalues are smaller, both vanish
_ROUNDING = 1e-9  # of the largest eigenvalue: a smaller real part is not significant


@with_earlier_names
@dataclass(frozen=True, eq=False)
class Connection(CollocationSolution):
    """Orbit between equilibria, or back to one.

    Attributes
    ----------
    curve : Curve
        With the collocation problem on the orbit's mesh.
    point : CurvePoint
        All unknowns.
    time : float
        Duration of the orbit.
    equilibria : ndarray, (e, n)
        Where it begins and ends, one where that is the same.
    eigenvalues : ndarray of complex, (e, n)
        Of the equilibria, the largest real part first.
    parameter_values : ndarray
        Their values, in the order in which they are varied.
    kind : str
        ``""``, or that of a special point of an orbit that returns to a saddle. ``"neutral-saddle"``: the saddle quantity is
        zero. ``"saddle-focus"``: both slowest eigenvalues of those with which the saddle is reached are one; on one side of
        this point they are complex. ``"three-leading"``: a complex pair is as slow as the slowest real one.
        ``"unresolved"``: one of these lies between the point before and this one, and was not located.
    """

    time: float
    equilibria: np.ndarray
    eigenvalues: np.ndarray
    parameter_values: np.ndarray
    kind: str = ""

    @property
    def saddle_quantity(self) -> float:
        """Sum of the leaving and of the slowest reaching eigenvalue: nearby orbits are stable where it is < 0."""
        return float((self.eigenvalues[0, 0] + self.eigenvalues[-1, 1]).real)


def _two_slowest(connection: Connection) -> float:
    """Return the squared difference of the two slowest reaching eigenvalues: negative where they are complex."""
    reaching = connection.eigenvalues[-1, 1:3]
    alike = len(reaching) == 2 and len(set(reaching.imag != 0)) == 1
    return float(((reaching[0] - reaching[1]) ** 2).real) if alike else math.nan


def _pair_behind(connection: Connection) -> float:
    """Return the difference of the slowest real and the slowest complex reaching eigenvalues."""
    reaching = connection.eigenvalues[-1, 1:]
    real_rates, complex_rates = reaching.real[reaching.imag == 0], reaching.real[reaching.imag != 0]
    return float(real_rates.max() - complex_rates.max()) if len(real_rates) and len(complex_rates) else math.nan


TESTS: Mapping[str, Callable[[Connection], float]] = {
    NEUTRAL_SADDLE: lambda connection: connection.saddle_quantity,
    SADDLE_FOCUS: _two_slowest,
    THREE_LEADING: _pair_behind,
}
"""Functions of a connection that pass zero at a kind of point, nan where that does not apply."""


def end_distances(connection: Connection, scale: np.ndarray, advance: np.ndarray) -> tuple[float, float]:
    """Return the distances of an orbit's ends from its equilibria, in terms of its size.

    scale (n,): of the states. advance (n,): of its end by whole turns.
    """
    away = (connection.states - connection.equilibria[0][:, None]) / scale[:, None]
    last = (connection.states[:, -1] - advance - connection.equilibria[-1]) / scale
    size = float(np.linalg.norm(away, axis=0).max())
    return float(np.linalg.norm(away[:, 0])) / size, float(np.linalg.norm(last)) / size


def missing_times(connection: Connection, scale: np.ndarray, advance: np.ndarray, least: float) -> np.ndarray:
    """Return the extra times (2,), before its begin and after its end, in which an orbit comes near to its saddles.

    least: of the whole time; what is missing of it is shared so that both ends come about equally near. Limited where a
    saddle is reached by very many turns.
    """
    rates = np.array([connection.eigenvalues[0, 0].real, -connection.eigenvalues[-1, 1].real])
    if not (rates > 0).all():
        return np.zeros(2)
    extra_times = np.log(np.maximum(np.array(end_distances(connection, scale, advance)) / _NEAR, 1.0)) / rates
    spare = least - connection.time - extra_times.sum()
    extra_times = extra_times + max(spare, 0.0) * rates[::-1] / rates.sum()
    return np.asarray(np.minimum(extra_times, _MOST_ADDED / _slowest(connection)))


def lengthen_orbit(
    connection: Connection, more: np.ndarray, matrix: np.ndarray, advance: np.ndarray
) -> tuple[Mesh, np.ndarray, np.ndarray]:
    """Extend an orbit at both ends by the linearised equations: return a mesh, and states and tangent at its nodes (K, n).

    more (2,): extra times. matrix (n, n): of these equations, where it ends. The tangent is zero on the extensions.
    """
    from scipy.linalg import expm

    problem, time = connection.problem, connection.time
    mesh, (y, _), (tangent, _) = problem.mesh, problem.split(connection.point.unknowns), problem.split(connection.point.tangent)
    whole, leaving = time + float(more.sum()), float(connection.eigenvalues[0, 0].real)
    before, after = (_edges(span, rate) for span, rate in zip(more, _slowest(connection), strict=True))
    edges = np.concatenate([before[:-1], more[0] + time * mesh.edges, more[0] + time + after[1:]]) / whole
    edges[-1] = 1.0
    longer = Mesh(edges, mesh.degree)
    at, first = longer.nodes * whole, mesh.degree * (len(before) - 1)
    last = first + len(y) - 1
    begin, end = connection.equilibria[0], connection.equilibria[-1] + advance
    # It leaves in one direction: any other component at its begin is an error, which would grow backwards in time.
    earlier = begin + (y[0] - begin) * np.exp(leaving * (at[:first, None] - more[0]))
    # Nor may the leaving component at its end grow: with this matrix it decays.
    decaying_matrix = _without_leaving(matrix)
    later = [end + expm(decaying_matrix * (t - more[0] - time)) @ (y[-1] - end) for t in at[last + 1 :].tolist()]
    states = np.concatenate([earlier, y, np.reshape(later, (-1, len(begin)))])
    changes = np.zeros_like(states)
    changes[first : last + 1] = tangent
    return longer, states, changes


def _without_leaving(matrix: np.ndarray) -> np.ndarray:
    """Return the matrix with the sign of its largest eigenvalue, real and positive, reversed."""
    values, right_vectors = np.linalg.eig(matrix)
    k = int(values.real.argmax())
    left_values, left_vectors = np.linalg.eig(matrix.T)
    along, across = right_vectors[:, k].real, left_vectors[:, int(left_values.real.argmax())].real
    return np.asarray(matrix - 2 * values[k].real * np.outer(along, across) / (along @ across))


def _edges(span: float, rate: float) -> np.ndarray:
    """Return edges of intervals over a time, fine enough for changes with a rate."""
    return np.linspace(0.0, span, 1 + math.ceil(span * rate))


def _slowest(connection: Connection) -> np.ndarray:
    """Return the rates (2,) with which an orbit changes at its begin and its end."""
    return np.asarray(np.abs([connection.eigenvalues[0, 0], connection.eigenvalues[-1, 1]]))


def leading_rate(connection: Connection) -> float:
    """Return the larger magnitude of the leaving and the slowest reaching eigenvalue."""
    return float(np.abs(connection.eigenvalues[0, :2]).max())


def end_reason(folds: Sequence[bool], start: Connection, there: Connection, largest: float) -> str:
    """Return why a curve ends before a point, empty where it does not.

    folds: True for saddle-nodes. start: of the curve. largest: value of ``leading_rate`` on the way.
    """
    for first, now, fold in zip(start.eigenvalues, there.eigenvalues, folds, strict=True):
        if fold:
            continue
        if not now[0].real > 0:
            return SADDLE_NODE
        # A real part that is zero everywhere, by a symmetry, does not end the curve.
        has_decay = len(now) > 1 and first[1].real < -_ROUNDING * float(np.abs(first).max())
        if has_decay and not now[1].real < 0:
            return HOPF if now[1].imag else LEFT_TWICE
    returns = len(folds) == 1 and not folds[0] and there.eigenvalues.shape[1] > 1
    return BOGDANOV_TAKENS if returns and leading_rate(there) < _VANISHING * largest else ""


def is_standstill(here: Connection, there: Connection, scale: np.ndarray) -> bool:
    """True if from one point to the next the orbit changes, but not the parameters, in units of a scale (m,)."""
    parameter_change = np.linalg.norm((there.parameter_values - here.parameter_values) / scale)
    return bool(parameter_change < _STILL * (there.point.length - here.point.length))


def standstill_sentence(names: Sequence[str], at: Connection) -> str:
    """Return the sentence for the end at a point where the parameters, by their names, stand still."""
    return f"{STANDSTILL}, {', '.join(f'{name} = {value:.7g}' for name, value in zip(names, at.parameter_values, strict=True))}"
