"""A portrait of equations of more than two states, projected on two: question -> plan -> findings -> quantities."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.limit_sets.descriptions import numbers_of, sentence_of
from wucht.dynamics.limit_sets.limit_set import LimitSet
from wucht.dynamics.limit_sets.long_run import LongRun, long_run
from wucht.dynamics.system_states import refuse_machine_keys, state_range, state_row, states_from
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.files.user_system import UserSystem
from wucht.numerics.angles import TURN
from wucht.numerics.continuation.deflation import deflated_solutions, random_starts
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.results.formatting import report_lines
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.phase_portrait.spec import PhasePortrait

if TYPE_CHECKING:
    import xarray as xr

_KEYS_OF_MACHINES, _KEYS_OF_THE_PLANE = ("together", "speed", "inertia", "order"), ("along", "values", "nullclines", "length")
_SEARCHES = 200  # starts of Newton's method
_MOST_SAMPLES = 4000  # of a trajectory, and of what it tends to
_SETTLED_SHARE = 1.2  # of its settling time a trajectory is drawn
_OUTSIDE = 0.05  # of a range: an equilibrium farther outside is left out
_NEUTRAL = 1e-9  # of the largest eigenvalue


@dataclass(frozen=True, eq=False)
class ProjectionPlan:
    """Projection on two states. rows: of these. low, high: (n,), of all states. starts: (n, k), of trajectories."""

    spec: PhasePortrait
    subject: UserSystem
    rows: tuple[int, int]
    low: np.ndarray
    high: np.ndarray
    starts: np.ndarray


@dataclass(frozen=True, eq=False)
class ProjectionFindings:
    """equilibria: (n, e), with their eigenvalues. runs: the trajectories."""

    plan: ProjectionPlan
    equilibria: np.ndarray
    eigenvalues: tuple[np.ndarray, ...]
    runs: tuple[LongRun, ...]

    @property
    def limit_sets(self) -> list[LimitSet]:
        """What the trajectories tend to, each once."""
        distinct = list[LimitSet]()
        for run in self.runs:
            one = run.limit_set
            if one is not None and not any(k.is_same(one) for k in distinct):
                distinct.append(one)
        return distinct


def projection_plan(spec: PhasePortrait, subject: UserSystem) -> ProjectionPlan:
    """Return the plan. Raises ``InputError`` where a key does not fit, or a range is missing."""
    refuse_machine_keys(spec, _KEYS_OF_MACHINES)
    refuse_machine_keys(spec, _KEYS_OF_THE_PLANE, "allowed for two states only, not for a projection of more")
    system, names = subject.system, subject.system.state_names
    for name in (*spec.ranges, *spec.show):
        state_row(system, name, "study.ranges" if name in spec.ranges else "study.show")
    pairs = {s.name: (0.0, TURN) for s in system.angles} | {
        n: state_range(n, pair, f"study.ranges.{n}") for n, pair in spec.ranges.items()
    }
    for name in names:
        if name not in pairs:
            raise InputError(f"study.ranges.{name}", None, "this key is missing; give a pair [low, high]", code="missing")
    low, high = np.array([pairs[n] for n in names]).T
    shown_names = spec.show or names[:2]
    if isinstance(spec.trajectories, int):
        starts = random_starts(low, high, spec.trajectories, spec.seed) if spec.trajectories else np.empty((len(names), 0))
    else:
        states = [states_from(system, start, f"study.trajectories[{k}]") for k, start in enumerate(spec.trajectories)]
        starts = np.array(states).reshape(-1, len(names)).T
    return ProjectionPlan(spec, subject, (names.index(shown_names[0]), names.index(shown_names[1])), low, high, starts)


def compute_projection(plan: ProjectionPlan, work: Work) -> Iterator[ProjectionFindings]:
    """Yield the findings after each trajectory."""
    equilibria, eigenvalues = work.unit("equilibria", partial(_equilibria, plan))
    runs = list[LongRun]()
    for k, start in enumerate(plan.starts.T):
        work.report(k / plan.starts.shape[1], "trajectories")
        runs.append(work.unit(f"trajectory {k + 1}", partial(long_run, plan.subject, start)))
        yield ProjectionFindings(plan, equilibria, eigenvalues, tuple(runs))
    if not runs:
        yield ProjectionFindings(plan, equilibria, eigenvalues, ())


def _equilibria(plan: ProjectionPlan) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Return the equilibria (n, e) in the ranges to which Newton's method leads, with their eigenvalues."""
    system, n = plan.subject.system, len(plan.low)
    if system.depends_on_time:
        return np.empty((n, 0)), ()
    scale = dict(zip(system.state_names, (plan.high - plan.low).tolist(), strict=True))
    equations = EquilibriumEquations.from_system(system, (), plan.subject.values, scale)
    points = deflated_solutions(equations, (), random_starts(plan.low, plan.high, _SEARCHES)).points
    room = _OUTSIDE * (plan.high - plan.low)
    turning = np.array([s in system.angles for s in system.states])
    points = np.where(turning[:, None], np.remainder(points, TURN), points)
    inside = ((points >= (plan.low - room)[:, None]) & (points <= (plan.high + room)[:, None])) | turning[:, None]
    points = points[:, inside.all(axis=0)]
    return points, tuple(np.linalg.eigvals(equations.values(x)[1][:, :n]) for x in points.T)


def _kind(eigenvalues: np.ndarray) -> str:
    """Return the kind of an equilibrium by its eigenvalues."""
    limit = _NEUTRAL * float(np.abs(eigenvalues).max(initial=0.0))
    growing, decaying = (eigenvalues.real > limit).sum(), (eigenvalues.real < -limit).sum()
    if growing + decaying < len(eigenvalues):
        return "degenerate"
    return "stable" if not growing else "unstable" if not decaying else "saddle"


def projection_dataset(findings: ProjectionFindings) -> xr.Dataset:
    """Return the Dataset of a projected portrait."""
    plan, names = findings.plan, findings.plan.subject.system.state_names
    points = [
        {"state": dict(zip(names, x.tolist(), strict=True)), "kind": _kind(e), "stable": _kind(e) == "stable",
         "eigenvalues": [[float(v.real), float(v.imag)] for v in e]}
        for x, e in zip(findings.equilibria.T, findings.eigenvalues, strict=True)
    ]  # fmt: skip
    sets = findings.limit_sets
    rows = [{"kind": str(one.kind), "sentence": sentence_of(one.kind, one, names), **numbers_of(one, names)} for one in sets]
    parts = {"state": ("states", ""), "kind": ("kind", ""), "stable": ("whether nearby motions tend to it", "")}
    quantities = [
        *table("fixed_points", points, "equilibria", parts | {"eigenvalues": ("eigenvalues", "")}),
        *table("attractors", rows, "what the trajectories tend to", parts | {"sentence": ("what it is", "")}),
        Quantity("state", list(names), "state", "", "state"),
        Quantity("equilibria", findings.equilibria, "equilibrium", "", "state equilibrium"),
        Quantity("equilibrium_kind", np.array([p["kind"] for p in points], "U16"), "kind", "", "equilibrium"),
        Quantity("trajectories", _padded_curves([_drawn_part(r) for r in findings.runs], len(names)), "trajectory", "",
                 "trajectory state sample"),
        Quantity("limit_sets", _padded_curves([s.samples(_MOST_SAMPLES)[1] for s in sets], len(names)),
                 "state on what trajectories tend to", "", "limit_set state place"),
        Quantity("limit_set_kind", np.array([str(s.kind) for s in sets], "U16"), "kind", "", "limit_set"),
        Quantity("drawn", np.stack([plan.low, plan.high], axis=1), "range of the state", "", "state end"),
    ]  # fmt: skip
    counts = [f"{sum(p['kind'] == kind for p in points)} {kind}" for kind in dict.fromkeys(p["kind"] for p in points)]
    ends = [f"{sum(s.kind == kind for s in sets)} {kind}" for kind in dict.fromkeys(s.kind for s in sets)]
    sentence = f"equilibria: {', '.join(counts) or 'none'}; trajectories tend to: {', '.join(ends) or 'nothing known'}"
    turning = [int(s in plan.subject.system.angles) for s in plan.subject.system.states]
    evidence = f"equilibria are those to which Newton's method leads from {_SEARCHES} starts in the ranges: there may be more"
    return result_dataset(
        quantities, sentence, [], [evidence], abscissa=plan.rows[0], ordinate=plan.rows[1], turning=turning, subject="system"
    )


def _stride(states: np.ndarray) -> int:
    return int(max(1, -(-states.shape[1] // _MOST_SAMPLES)))


def _drawn_part(run: LongRun) -> np.ndarray:
    """Return the states (n, K) of a run until it has settled."""
    until = run.end_time if run.settling_time is None else _SETTLED_SHARE * run.settling_time
    states = run.states[:, run.time <= until]
    return states[:, :: _stride(states)]


def _padded_curves(curves: list[np.ndarray], states: int) -> np.ndarray:
    """Return curves (k, n, K), padded with NaN."""
    padded_curves = np.full((len(curves), states, max((c.shape[1] for c in curves), default=0)), np.nan)
    for k, curve in enumerate(curves):
        padded_curves[k, :, : curve.shape[1]] = curve
    return padded_curves


def projection_report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a projected portrait."""
    s = result.wucht.summary
    lines: list[tuple[str, Any]] = [
        (p["kind"], ", ".join(f"{name} {value:.7g}" for name, value in p["state"].items())) for p in s["fixed_points"]
    ]
    lines += [("attractor", a["sentence"]) for a in s["attractors"]]
    return report_lines(result, s["sentence"], lines)
