"""How the catalogue's branches of orbits end, confirmed by integration: a formulation that knows nothing of collocation.

An orbit near an end is integrated from place to place, in legs so short that what grows has no time to: it is one if every leg
ends where the next begins. At a saddle connection and at a saddle-node on the orbit these orbits come ever nearer to the
equilibrium that the end names, which a run from there does not leave; at a saddle-node as the parameter does to its own value,
by the inverse square of their period.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from wucht.dynamics.branches.orbit_branches import BranchEnd, PeriodicBranch, StoredOrbit
from wucht.dynamics.branches.orbit_diagram import OrbitFindings, follow_orbits
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.dynamics.work import Work
from wucht.files.catalogue import load_document, names
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.studies.study_file import read_study

pytestmark = pytest.mark.slow

CLOSES = 1e-5  # of the extents of the states: orbits are right to 1e-7 of their sizes, which grows within a leg
NEAR = 0.05  # of the extents: how near the last orbit comes to the equilibrium
ROUNDING = 1e-6  # of the extents: nearer orbits are not told apart
STAYS = 1e-6  # of the extents: how far a run from the equilibrium goes, in a tenth of the time of its fastest growth
FILES = [name for name in names() if load_document(name)[0].get("study", {}).get("kind") == "orbit-branch"]


@cache
def branches(name: str) -> tuple[OrbitProblem, OrbitFindings]:
    study = read_study(name)
    _, case = study.spec.prepare(study.subject)
    *_, findings = follow_orbits(case, Work())
    return case.problem, findings


def gap(problem: OrbitProblem, orbit: StoredOrbit, growth: float) -> float:
    """By how much the legs of an orbit miss the next place, in terms of the extents of its states. growth: the fastest rate."""
    system = problem.system
    parameters = system.values({**problem.values, problem.path: orbit.value})
    compiled = compile_system(system, 1e-13)
    parts = [max(1, int(np.ceil((b - a) * orbit.period * growth))) for a, b in pairwise(orbit.mesh.edges)]
    inner = [np.linspace(a, b, k, endpoint=False) for (a, b), k in zip(pairwise(orbit.mesh.edges), parts, strict=True)]
    tau = np.append(np.concatenate(inner), 1.0)
    places = orbit.mesh.interpolate(orbit.states, tau)
    ends = [
        integrate(compiled, place, parameters, np.array([begin, end]) * orbit.period).states[:, -1]
        for place, (begin, end) in zip(places, pairwise(tau), strict=False)
    ]
    return float((np.abs(np.array(ends) - places[1:]) / extents(orbit)).max())


def extents(orbit: StoredOrbit) -> np.ndarray:
    return np.maximum(np.ptp(orbit.states, axis=0), 1e-3)


def distance(problem: OrbitProblem, orbit: StoredOrbit, equilibrium: np.ndarray) -> float:
    """From the nearest place of an orbit, angles but for whole turns."""
    tau = np.unique(np.concatenate([np.linspace(a, b, 400) for a, b in pairwise(orbit.mesh.edges)]))
    away = orbit.mesh.interpolate(orbit.states, tau) - equilibrium
    away -= np.where(problem.turning, 2 * np.pi * np.round(away / (2 * np.pi)), 0.0)
    return float(np.linalg.norm(away / extents(orbit), axis=1).min())


def ways_of(branch: PeriodicBranch) -> Iterator[tuple[BranchEnd, list[StoredOrbit]]]:
    """Each end of a branch, with the orbits on the way to it."""
    orbits = [o for o in branch.stored_orbits if not o.kind]
    return zip(reversed(branch.ends), (orbits, orbits[::-1]), strict=False)


@pytest.mark.parametrize("name", FILES)
def test_ends_are_those_of_orbits_that_integration_confirms(name: str) -> None:
    problem, findings = branches(name)
    ways = [way for branch in findings.branches for way in ways_of(branch)]
    for end, orbits in ways:
        last = orbits[-1]
        before = [o for o in orbits if o.period < last.period / 1.3]
        assert end.kind in {"saddle-node-on-orbit", "saddle-connection", "range"}, end.sentence
        rates = np.sort(end.eigenvalues.real) if len(end.eigenvalues) else np.ones(1)
        assert gap(problem, last, float(np.abs(rates).max())) < CLOSES
        if end.kind == "range":
            assert end.parameter in problem.bounds
            continue
        nearest, earlier = (distance(problem, orbit, end.equilibrium) for orbit in (last, before[-1]))
        if end.kind == "saddle-connection":
            assert rates[0] < 0 < rates[-1]
            assert nearest < min(NEAR, max(earlier, ROUNDING))
        else:
            assert np.abs(rates).min() < 1e-6 * np.abs(rates).max()
            assert nearest / earlier == pytest.approx((before[-1].period / last.period) ** 2, rel=0.25)
        system = problem.system
        parameters = system.values({**problem.values, problem.path: end.parameter})
        time = 0.1 / max(rates[-1], 1e-3 * np.abs(rates).max())
        there = integrate(compile_system(system, 1e-13), end.equilibrium, parameters, np.array([0.0, time])).states[:, -1]
        assert (np.abs(there - end.equilibrium) / extents(last)).max() < STAYS


def test_the_catalogue_has_branches() -> None:
    assert len(FILES) >= 7
