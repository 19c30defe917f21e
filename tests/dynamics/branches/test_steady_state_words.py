"""What steady states of machines and equations are called, why their branches end, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from tests.refusals import refused

import wucht
from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.branches import equilibrium_branches, first_orbits, steady_states
from wucht.dynamics.branches.averaged_equilibria import AveragedEquilibria
from wucht.dynamics.branches.bifurcation_diagram import BranchCase
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch, describe_end, is_duplicate
from wucht.dynamics.branches.first_orbits import orbit_near
from wucht.dynamics.branches.modulated_motion import ModulatedMotion
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.dynamics.branches.second_parameter import SecondParameter, curve_through
from wucht.dynamics.branches.steady_states import Kind, SystemEquilibria
from wucht.errors import RunError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.system import TIME, System

X, Y, P, S = sp.symbols("x y p s", real=True)
CUSP = wucht.UserSystem(System((X,), (P + S * X - X**3,), (P, S)), {"p": 0.0, "s": 1.0})
TABLE = "drozdetskaya-2020/table-5.1"


def cusp() -> SystemEquilibria:
    return SystemEquilibria.of(CUSP, "p", (-2.0, 2.0), {"x": (-2.0, 2.0)})


def table(**settings: Any) -> AveragedEquilibria:
    return AveragedEquilibria.of(load_machine(TABLE), "u", (0.5, 4.0), **settings)


def test_what_a_machine_draws_in_words() -> None:
    """The speed of the main rotor by default; a phase is drawn in radians, by 1 radian; a speed by the fastest one."""
    states = table()
    phase, speed = (next(n for n in states.names if n.endswith(end)) for end in (".phase", ".speed"))
    words = [table(show=show).labels for show in (None, phase, speed)]
    assert [w.ordinate for w in words] == [
        "speed of the main rotor", f"phase of {phase.removesuffix('.phase')}", f"speed of {speed.removesuffix('.speed')}"
    ]  # fmt: skip
    assert table(show=phase).ordinate_size == 1.0 and table(show=speed).ordinate_size == states.fastest
    low, high = states.limits
    assert states.speed_limit_reason(False) == f"no drive can keep more than {high:.4g}"
    assert states.speed_limit_reason(True).startswith(f"below {low:.4g} a rotor hardly turns") and high == pytest.approx(
        1.01 * states.fastest
    )


def test_a_phase_with_units_is_in_radians() -> None:
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03},
            {"kind": "pendulum", "name": "ball", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.05},
        ],
        "drive": {"on": "drum", "kind": "linear", "slope": 0.01, "no_load_speed": 200.0},
    })  # fmt: skip
    show = next(n for n in AveragedEquilibria.of(machine, "drive.slope", (0.01, 0.02)).names if "phase" in n)
    states = AveragedEquilibria.of(machine, "drive.slope", (0.01, 0.02), show=show)
    assert (states.labels.unit, states.labels.ordinate) == ("rad", "phase of ball")
    none = AveragedEquilibria.of(machine, "drive.no_load_speed", (-100.0, 200.0)).find_equilibria(0.0)
    assert none.points == () and none.families == () and "nothing drives the machine there" in str(none)


def test_phases_of_a_state_are_those_to_the_main_rotor_of_bodies_on_the_others_too() -> None:
    exciter = {"kind": "rotor", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03}
    ball = {"kind": "pendulum", "name": "ball", "about": "second", "mass": 0.1, "length": 0.1, "damping": 0.05}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
        "bodies": [exciter | {"name": "first"}, exciter | {"name": "second"}, ball],
        "drives": [{"on": on, "kind": "linear", "slope": 0.01, "no_load_speed": 200.0} for on in ("first", "second")],
    })  # fmt: skip
    states = AveragedEquilibria.of(machine, "carrier.damping", (100.0, 300.0))
    assert states.model_at(200.0).torques.names == ("first", "second", "ball")
    there = State(190.0, np.array([0.0, 1.0, 3.0]))
    assert states.state(states.point(there, 200.0)).phases == pytest.approx(there.phases)


def test_ranges_of_speeds_and_angles_in_which_steady_states_are_searched() -> None:
    """Of a machine from 0.02 to 1.15 of its fastest speed."""
    machine, states = load_machine(TABLE), table()
    motion = ModulatedMotion.of(machine, "u", states.bounds, states, together=True)
    turning, fastest = motion.subject.turning, states.ordinate_size
    assert motion.box[:, turning].tolist() == [[0.0] * turning.sum(), [2 * np.pi] * turning.sum()]
    np.testing.assert_allclose(motion.box[:, ~turning].T, [[0.02 * fastest, 1.15 * fastest]] * (~turning).sum())
    assert motion.whole is not None and len(motion.whole.turning) > len(turning)
    assert motion.starts(4).shape == (4, len(motion.whole.turning))


def test_equations_that_depend_on_time_have_no_equilibria() -> None:
    forced = wucht.UserSystem(System((X,), (P - X + sp.cos(TIME),), (P,)), {"p": 0.0})
    with refused("system", given=None):
        SystemEquilibria.of(forced, "p", (-1.0, 1.0), {"x": (-1.0, 1.0)})
    for key, given in (("only", ("together",)), ("inertia", False)):
        with refused(f"study.{key}", given=given):
            BranchCase.of(CUSP, "p", (-1.0, 1.0), **{key: given})  # type: ignore[arg-type]


def test_a_state_that_passes_far_beyond_its_range() -> None:
    """One width of it, on either side."""
    states = cusp()
    for x in (-6.5, 6.5):
        assert (
            states.end_reason(np.array([x, 0.0]))
            == f"x passes {x:.5g}, far outside the range in which equilibria were searched"
        )
    assert states.end_reason(np.array([5.9, 0.0])) == "a state leaves its limits"


def test_why_a_branch_ends_in_words() -> None:
    """At a limit of a state first; at the range's end, near to it, or for another reason."""
    equilibria = cusp().equilibria

    def end(x: float, p: float) -> str:
        return describe_end(equilibria, "p = here", lambda unknowns: f"leaves at {unknowns[0]:g}", np.array([x, p]), "stuck")

    assert end(6.0, 1.0) == "leaves at 6" and end(-6.0, 2.0) == "leaves at -6"
    assert end(0.0, 2.0) == end(0.0, -2.0) == "the range ends"
    assert end(0.0, 1.0) == "at p = here: stuck"


def branch_of(*kinds: str) -> EquilibriumBranch:
    unknowns = np.array([np.zeros(len(kinds)), np.arange(float(len(kinds)))])
    return EquilibriumBranch(unknowns, np.zeros((1, len(kinds)), complex), kinds, ("", ""))


@pytest.mark.parametrize(
    ("met", "kind"),
    [
        ((Kind("a", "I", (2, 1), 3), Kind("a", "I", (2, 1), 3)), Kind("a", "I", (2, 1), 3)),
        ((Kind("a", "I", (2, 1), 3), Kind("a", "II", (2, 1), 6)), Kind(None, None, (2, 1), 6)),
        ((Kind("a", "I", (2, 1), 3), Kind("a", "I", (1, 1), 1)), Kind("a", "I", None, 3)),
    ],
)
def test_the_name_of_a_branch_is_what_its_points_share(met: tuple[Kind, Kind], kind: Kind) -> None:
    """Special points do not count."""
    states: Any = SimpleNamespace(kind=lambda unknowns: {0.0: met[0], 2.0: met[1]}[unknowns[-1]])
    assert equilibrium_branches._kind(states, branch_of("", "fold", "")) == kind


def test_a_point_is_no_branch_of_its_own() -> None:
    states: Any = SimpleNamespace(equilibria=SimpleNamespace(equations=SimpleNamespace(scale=np.ones(2))))
    assert is_duplicate(states, [], branch_of("fold")) and is_duplicate(states, [], branch_of("fold", "hopf"))
    assert not is_duplicate(states, [], branch_of("", "", ""))


def test_branches_that_do_not_switch_have_no_offshoots() -> None:
    def lost(_: Any) -> None:
        raise RunError("none")

    states: Any = SimpleNamespace(switch_branch=lost)
    assert equilibrium_branches._offshoots(states, None) == []  # type: ignore[arg-type]


def test_a_curve_that_cannot_be_followed_says_why() -> None:
    """An equation of one state has no Hopf points."""
    states = SystemEquilibria.of(replace(CUSP, values={"p": 0.0, "s": -3.0}), "p", (-2.0, 2.0), {"x": (-2, 2)})
    with pytest.raises(RunError, match="no pair of complex eigenvalues near this state: there is no Hopf point nearby"):
        curve_through(states, SecondParameter("s", (-4.0, -2.0), -3.0), "hopf", Kind(), np.array([1.9, 0.0]))


class Run:
    """Of which the one that is asked for fails."""

    def __init__(self, fails: bool) -> None:
        self.failure = "it overflows" if fails else None
        self.states, self.time = np.array([[0.0, 1.0, 0.0, 1.0]]), np.arange(4.0)

    def reraise_interrupt(self) -> Run:
        return self


@pytest.mark.parametrize("fails", [0, 1, None])
def test_a_run_that_fails_is_said_and_one_that_has_not_settled_goes_on(
    monkeypatch: pytest.MonkeyPatch, fails: int | None
) -> None:
    """The first run, or that over a period; where Newton's method finds nothing it goes on, twice as long each time."""
    runs, spans = iter(range(99)), list[float]()

    def integrated(_: Any, __: Any, ___: Any, times: np.ndarray) -> Run:
        spans.append(float(times[-1]))
        return Run(next(runs) == fails)

    def lost(*_: Any) -> None:
        raise RunError("no orbit near it")

    monkeypatch.setattr(first_orbits, "integrate", integrated)
    monkeypatch.setattr(first_orbits, "is_at_rest", lambda _: False)
    monkeypatch.setattr(first_orbits, "recurrence", lambda *_: SimpleNamespace(turns=np.zeros(1, int), period=0.5))
    monkeypatch.setattr(first_orbits, "cycle_near", lost)
    problem = OrbitProblem.of(CUSP, "p", (-1.0, 1.0))
    made = orbit_near(problem, 0.25, np.zeros(1), lambda: None, lambda _: 10.0, runs=3)
    assert made.orbit is None and not made.is_steady
    if fails is None:
        assert spans == [10.0, 0.5, 20.0, 0.5, 40.0, 0.5]
        assert made.sentence == "at p = 0.25 it has settled neither in a steady state nor on an orbit after 70"
    else:
        assert made.sentence == "at p = 0.25 the run fails: it overflows" and len(spans) == fails + 1


def test_states_are_the_same_but_for_whole_turns_of_angles() -> None:
    """In units of the ranges' widths, 4 and 2; an angle in radians; by name an angle is within a turn."""
    theta = sp.Symbol("theta", real=True)
    system = System((theta, X), (P - sp.sin(theta), -X), (P,), angles=frozenset({theta}))
    states = SystemEquilibria.of(wucht.UserSystem(system, {"p": 0.5}), "p", (0.0, 2.0), {"x": (-1.0, 3.0)}, show="x")
    u, near = np.array([1.0, 0.5, 0.25]), steady_states._SAME
    for k, size in ((0, 1.0), (1, 4.0), (2, 2.0)):
        for way in (1, -1):
            assert states.is_same(u, u + 0.99 * way * near * size * np.eye(3)[k])
            assert not states.is_same(u, u + 1.01 * way * near * size * np.eye(3)[k])
    turned = u + np.array([2 * np.pi, 0.0, 0.0])
    assert states.is_same(u, turned) and states.is_same(turned, u) and states.is_same(u, u - 3 * (turned - u))
    assert not states.is_same(u, u + np.array([np.pi, 0.0, 0.0])) and not states.is_same(u, u + np.array([0.0, 2 * np.pi, 0.0]))
    assert states.state_by_name(turned) == {"theta": pytest.approx(1.0), "x": 0.5}
    assert states.ordinate(u[:, None]).tolist() == [0.5] and states.ordinate_size == 4.0
    assert states.labels.state == "x" and states.nominal_value == 0.5 and states.equilibria.limits == {1: (-5.0, 7.0)}
