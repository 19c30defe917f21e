"""Plan -> findings: the fixed points of each portrait, the separatrices, trajectories, and the closed curves that they meet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.sections import Section
from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.phase_plane.closed_curves import ClosedCurve
from wucht.numerics.phase_plane.fixed_points import SADDLE, FixedPoints, fixed_points
from wucht.numerics.phase_plane.manifolds import Manifold, manifold
from wucht.numerics.phase_plane.phase_curves import PhaseCurve, Portrait
from wucht.numerics.phase_plane.plane import Plane
from wucht.studies.phase_portrait.prepare import Case, Plan
from wucht.system import Output

_KEPT = 3  # every so manyth sample of a curve: a figure shows no more
_GOLDEN = 1.32471795724474602596  # x^3 = x + 1: M. Roberts' evenly spread sequence in the plane
_TURNED = "turned"
_LEAST = 4  # curves that are followed both ways, drawn or not: they meet closed curves


@dataclass(frozen=True, eq=False)
class Found:
    """A portrait. transverse: of each fixed point of a machine, the eigenvalues out of the section. trajectories: forwards and
    backwards from each start. followed: how many curves were, those among them that are not drawn. turned: the angle of the
    main rotor in a period of each closed curve."""

    fixed: FixedPoints
    transverse: tuple[np.ndarray, ...]
    separatrices: tuple[Manifold, ...]
    trajectories: tuple[tuple[PhaseCurve, PhaseCurve], ...]
    closed: tuple[ClosedCurve, ...]
    followed: int
    turned: tuple[float, ...]


@dataclass(frozen=True)
class Findings:
    """The portraits that are done."""

    portraits: tuple[Found, ...]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Portrait by portrait."""
    done: list[Found] = []
    for k, case in enumerate(plan.cases):
        part = work.part(f"portrait {k + 1}", k / len(plan.cases), (k + 1) / len(plan.cases))
        done.append(part.unit("curves", partial(_found, plan, case, part)))
        yield Findings(tuple(done))


def _found(plan: Plan, case: Case, work: Work) -> Found:
    work.report(0.0, f"fixed points {case.label}".strip())
    plane, made = case.plane, case.section
    fixed = fixed_points(plane, partial(work.report, 0.0, "fixed points"))
    portrait = Portrait(plane, fixed.points, plan.spec.length, watch=partial(work.report, 0.1, "separatrices"))
    separatrices: list[Manifold] = []
    for k, point in enumerate(fixed.points):
        for stable, side in ((False, 1), (False, -1), (True, 1), (True, -1)) if point.kind == SADDLE else ():
            separatrices.append(manifold(portrait, k, stable, side))
    trajectories: list[tuple[PhaseCurve, PhaseCurve]] = []
    starts = _places(plan, plane, plan.count) if plan.given is None else plan.given
    drawn = starts.shape[1]
    if drawn < _LEAST:
        starts = np.concatenate([starts, _places(plan, plane, _LEAST)[:, drawn:]], axis=1)
    for k, start in enumerate(starts.T):
        portrait.watch = partial(work.report, 0.2 + 0.8 * k / starts.shape[1], "trajectories")
        both = _thinned(portrait.follow(start, True)), _thinned(portrait.follow(start, False))
        trajectories += [both] if k < drawn else []
    return Found(
        fixed,
        tuple(made.transverse(p.state) for p in fixed.points) if made is not None else (),
        tuple(replace(m, curve=_thinned(m.curve)) for m in separatrices),
        tuple(trajectories),
        tuple(portrait.closed),
        len(separatrices) + 2 * starts.shape[1],
        tuple(_turned(made, c) for c in portrait.closed) if made is not None else (),
    )


def _places(plan: Plan, plane: Plane, count: int) -> np.ndarray:
    """Evenly spread starts (2, k), the first where the seed says."""
    first = np.random.default_rng(plan.spec.seed).uniform(size=2)
    steps = np.array([1 / _GOLDEN, 1 / _GOLDEN**2])
    share = np.remainder(first[:, None] + steps[:, None] * np.arange(count), 1.0)
    return np.asarray(plane.low[:, None] + share * plane.scale[:, None])


def _thinned(curve: PhaseCurve) -> PhaseCurve:
    keep = np.unique(np.concatenate([np.arange(0, curve.states.shape[1], _KEPT), [curve.states.shape[1] - 1]]))
    return replace(curve, states=curve.states[:, keep], time=curve.time[keep])


def _turned(made: Section, curve: ClosedCurve) -> float:
    """The angle by which the main rotor turns in a period."""
    if made.turning < 0:
        return abs(made.speed or 0.0) * curve.period
    system = replace(made.system, outputs=(), quadratures=(Output(_TURNED, made.system.states[made.turning]),))
    ends = np.array([0.0, curve.period])
    run_ = integrate(compile_system(system), curve.states[:, 0], made.system.values(made.values), ends)
    if run_.failure is not None:
        raise WuchtError(run_.failure)
    return abs(float(run_.quadratures[_TURNED][-1]))
