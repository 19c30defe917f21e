"""Steady states at a value of the second parameter, and the branch of orbits where one direction leads out of a section."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.branches import state_rows
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.first_orbits import SeedOrbit
from wucht.dynamics.branches.orbit_endings import NO_MOTION, BranchToEnd, OrbitEnd
from wucht.dynamics.branches.state_rows import OrbitRow, RowCase, steady_row
from wucht.errors import RunError
from wucht.numerics.collocation.mesh import Mesh

SEED = SeedOrbit(Mesh(np.array([0.0, 1.0]), 2), np.zeros((3, 2)), 4.0, 0.3, np.array([1, 0]), np.ones(3), np.empty(0), "", 40.0)


@dataclass(frozen=True)
class Subject:
    """Of a section of two states of three."""

    width: float
    embedding: np.ndarray


def orbit(value: float, kind: str = "", unstable: int = 0, is_trusted: bool = True, period: float = 4.0) -> Any:
    return SimpleNamespace(
        parameter=value, kind=kind, unstable=unstable, is_trusted=is_trusted, period=period, states=np.full((2, 3), value),
        problem=SimpleNamespace(mesh=SEED.mesh),
    )  # fmt: skip


@pytest.fixture
def row(monkeypatch: pytest.MonkeyPatch) -> OrbitRow:
    """Orbits from 0.1 to 0.6, unstable in the section beyond 0.5; the exponent is p - 0.23.

    Those from 0.2 to 0.5 were followed both ways from 0.3; the next ones follow up to the longest period, which is 40.

    The multipliers at 0.1 are not accurate: there the exponent alone counts.
    """
    sides = {way: OrbitEnd(NO_MOTION, value, "", SEED, np.empty(0)) for way, value in ((-1, 0.05), (1, 0.65))}
    walked = {1: [orbit(0.3), orbit(0.4), orbit(0.5)], -1: [orbit(0.3), orbit(0.2)]}
    further = {
        0.5: [orbit(0.55, "fold"), orbit(0.6, unstable=1), orbit(0.62, period=41.0), orbit(0.64)],
        0.2: [orbit(0.1, unstable=1, is_trusted=False)],
    }
    cycles: Any = SimpleNamespace(walk=lambda c: further[c.parameter])
    monkeypatch.setattr(
        state_rows, "branch_to_end", lambda _motion, _seed, way, _watch: BranchToEnd(cycles, tuple(walked[way]), sides[way])
    )
    monkeypatch.setattr(RowCase, "_orbit_within", lambda _self, _seed, _half, _value: replace(SEED, period=SEED.longest / 3))
    monkeypatch.setattr(state_rows, "transverse_exponent", lambda _motion: lambda cycle: cycle.parameter - 0.23)
    motion: Any = SimpleNamespace(subject=Subject(1.0, np.zeros((3, 2))), lift=lambda seed: seed)
    made = RowCase(motion, "s", 7.0, lambda: None).row_through(SEED)
    assert isinstance(made, OrbitRow)
    return made


def test_its_ends_and_orbits_stand_in_order(row: OrbitRow) -> None:
    assert row.second == 7.0
    assert [side.value for side in row.sides] == [0.05, 0.65]
    assert row.values.tolist() == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]


def test_it_is_stable_where_no_direction_grows(row: OrbitRow) -> None:
    assert row.stable.tolist() == [True, True, False, False, False, False]
    assert [row.state_at(p) for p in (0.04, 0.12, 0.21, 0.35, 0.64, 0.66)] == [0, 2, 2, 1, 1, 0]
    assert (
        row.has_orbit(0.12, np.array([1, 0]))
        and not row.has_orbit(0.12, np.array([0, 1]))
        and not row.has_orbit(0.35, np.array([1, 0]))
    )


def test_stability_is_lost_where_the_exponent_is_zero(row: OrbitRow) -> None:
    (special,) = row.special
    assert (special.kind, special.value) == ("branch-point", pytest.approx(0.23, rel=1e-12))


def test_the_last_orbit_of_a_branch_is_a_regular_one() -> None:
    """One way or the other; a special orbit behind it does not count, and where there is none it is the first."""
    walks = {1: [orbit(0.4), orbit(0.5), orbit(0.55, "fold")], -1: [orbit(0.2), orbit(0.15, "torus")], 0: [orbit(0.1, "fold")]}
    first = orbit(0.3)
    cycles: Any = SimpleNamespace(backwards=lambda _: -1, walk=lambda c: walks[-1 if c == -1 else 1])
    assert state_rows._last_of(cycles, first, True).parameter == 0.5
    assert state_rows._last_of(cycles, first, False).parameter == 0.2
    assert state_rows._last_of(cycles, first, True, 1).parameter == 0.4
    none: Any = SimpleNamespace(walk=lambda _: walks[0])
    assert state_rows._last_of(none, first, True) is first


def test_beyond_the_point_where_it_is_lost_a_state_is_not_stable() -> None:
    """A branch that is stable up to a Hopf point at p = 1, beside one that is stable everywhere."""
    unknowns, everywhere = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 2.0]]), np.full((1, 3), -1.0 + 0j)
    lost = EquilibriumBranch(unknowns, np.array([[-1.0, 0.0, 1.0]], complex), ("", "hopf", ""), ("range", "range"))
    row = steady_row(
        3.0, [lost, EquilibriumBranch(unknowns, everywhere, ("", "", ""), ("range", "range"))], np.array([0.5, 1.5])
    )
    assert [(place.x, place.y, place.names) for place in row] == [
        (0.5, 3.0, ("2 stable states",)), (1.5, 3.0, ("one stable state",))
    ]  # fmt: skip


@pytest.mark.parametrize(("value", "state"), [(0.05, 0), (0.06, 2), (0.24, 2), (0.26, 1), (0.6, 1), (0.65, 0), (0.7, 0)])
def test_a_branch_of_orbits_has_none_at_its_ends_and_beyond(row: OrbitRow, value: float, state: int) -> None:
    assert row.state_at(value) == state
    assert row.has_orbit(value, np.array([1, 0])) is (state == 2) and not row.has_orbit(value, np.array([0, 0]))


def test_steady_states_at_a_point_of_a_branch_and_beside_it() -> None:
    """Between two points both must be stable; a value at a point lies in both pieces beside it."""
    exponents = np.array([[-1.0, -1.0, 1.0, 1.0, -1.0, -1.0]], complex)
    branch = EquilibriumBranch(np.array([np.zeros(6), np.arange(6.0)]), exponents, ("",) * 6, ("", ""))
    found = steady_row(7.0, [branch], np.array([0.0, 0.5, 1.0, 1.5, 2.5, 3.5, 4.5, 5.0, 5.5]))
    counts = [len(place.names) for place in found]
    assert counts == [1, 1, 1, 0, 0, 0, 1, 1, 0] and {place.y for place in found} == {7.0}


def test_a_special_orbit_is_the_one_of_its_kind_at_its_value() -> None:
    """Within 1e-3 of the range, 2, on the side on which it lies."""
    walks = {1: [orbit(0.4, "torus"), orbit(0.4, "fold"), orbit(0.4021, "fold")], -1: [orbit(0.2, "fold")]}
    cycles: Any = SimpleNamespace(backwards=lambda _: -1, walk=lambda c: walks[-1 if c == -1 else 1], bounds=(-1.0, 1.0))

    def value(kind: str, at: float) -> float:
        special: Any = SimpleNamespace(kind=kind, value=at)
        return state_rows._locate_special(cycles, orbit(0.3), special).parameter

    assert (
        value("fold", 0.3985) == value("fold", 0.4001) == 0.4 and value("fold", 0.40205) == 0.4021 and value("fold", 0.2) == 0.2
    )
    for kind, at in (("fold", 0.405), ("torus", 0.2), ("fold", 0.29)):
        with pytest.raises(RunError):
            value(kind, at)


def test_a_curve_both_ways_has_its_start_once() -> None:
    """Backwards in reverse; of three parameters the first two; no more than 401 points a way."""

    def at(x: float) -> Any:
        return SimpleNamespace(parameter_values=np.array([x, 10 * x, 9.0]))

    walks = {"start": [at(x) for x in (1.0, 2.0)], "back": [at(-x) for x in (1.0, 2.0, 3.0)]}
    start = at(0.0)
    curves: Any = SimpleNamespace(backwards=lambda _: "back", walk=lambda c: iter(walks["back" if c == "back" else "start"]))
    found = state_rows._curve_both_ways("torus", curves, start)
    assert (found.kind, found.x.tolist()) == ("torus", [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0])
    assert found.y.tolist() == (10 * found.x).tolist()
    walks["start"] = [at(1.0)] * 999
    assert len(state_rows._curve_both_ways("torus", curves, start).x) == 3 + 1 + 401
