"""Findings of ``orbit-branch`` that are made by hand: what is missing, doubtful or too much."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.hand_made import five_functions, titled, warnings_of, with_answer
from tests.refusals import refused

from wucht.dynamics.branches.orbit_diagram import MOST_BRANCHES, OrbitFindings
from wucht.dynamics.branches.steady_states import Labels
from wucht.dynamics.work import Work
from wucht.files.user_system import equations_from
from wucht.numerics.periodic.branch_ends import significant_value
from wucht.studies.orbit_branch import computation
from wucht.studies.orbit_branch import dataset as orbit_dataset
from wucht.studies.orbit_branch import figure as orbit_figure
from wucht.studies.orbit_branch.dataset import _orbit_entry as orbit_entry
from wucht.studies.orbit_branch.orbit_tables import orbit_quantities
from wucht.studies.orbit_branch.spec import OrbitBranch

STUDY = five_functions("orbit-branch")
CIRCLE = {
    "parameters": {"mu": 1.0},
    "definitions": {"s": "mu - x^2 - y^2", "w": "2 + mu"},
    "states": {"x": "s*x - w*y", "y": "w*x + s*y"},
}


@cache
def circles() -> tuple[Any, OrbitFindings]:
    """A plan, and all that is found of circles of radius sqrt mu."""
    bounds = {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}
    asked = OrbitBranch(along="mu", range=(-1.0, 2.0), at=1.0, values=(0.5, 1.5), start={"x": 0.5}, ranges=bounds)
    plan = STUDY.prepare(asked, equations_from(CIRCLE, "a test"))
    *_, last = STUDY.run(plan, Work())
    return plan, last


def result(**other: Any) -> xr.Dataset:
    plan, found = circles()
    given = {name: getattr(found, name) for name in ("steady", "runs", "branches", "orbits", "omissions", "complete")}
    return titled(STUDY.dataset(plan, OrbitFindings(**given | other)), dimensionless=True)


def test_before_the_first_orbit() -> None:
    made = result(branches=(), orbits=(), complete=False)
    assert made.wucht.summary["sentence"] == "the study was interrupted before the first orbit"
    assert warnings_of(made)[-1] == "the search is not finished"
    assert result(branches=(), orbits=()).wucht.summary["sentence"].startswith("no modulated motion was found: ")


def test_a_whole_search_has_no_warnings() -> None:
    assert warnings_of(result()) == []
    assert warnings_of(result(complete=False)) == ["the search is not finished"]


def test_what_is_lost_or_left_out_is_told() -> None:
    lost = tuple(f"lost {k}" for k in range(4 + 2))
    assert warnings_of(result(omissions=lost)) == [*lost[:-2], "and 2 more"]
    assert warnings_of(result(omissions=lost[:-2])) == list(lost[:-2])
    _, found = circles()
    many = warnings_of(result(branches=found.branches * MOST_BRANCHES))
    assert many == [f"more than {MOST_BRANCHES} branches: the others are left out"]
    assert warnings_of(result(branches=found.branches * (MOST_BRANCHES - 1))) == []


def test_branches_are_counted() -> None:
    _, found = circles()
    assert not result().wucht.summary["sentence"].endswith("more branches")
    for count, words in ((2, "; one more branch"), (3, "; 2 more branches")):
        assert result(branches=found.branches * count).wucht.summary["sentence"].endswith(words)


def test_values_of_which_there_is_no_orbit() -> None:
    _, found = circles()
    assert len(found.orbits) == 2
    none = "there is no orbit of a known branch at mu = 0.5, 1.5"
    assert warnings_of(result(orbits=())) == [none]
    assert warnings_of(result(orbits=found.orbits[:1])) == ["there is no orbit of a known branch at mu = 1.5"]
    assert none not in warnings_of(result(orbits=(), complete=False))


def test_orbits_whose_fastest_decays_are_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    branch = type(circles()[1].branches[0])
    real = branch.whole_array

    def whole_array(self: Any, name: str) -> np.ndarray:
        values = real(self, name)
        if name == "product_error":
            wrong = np.zeros(len(values))
            wrong[:3] = 1.5 * 0.1
            return wrong
        if name == "is_trusted":
            return np.arange(len(values)) != 1
        return values

    monkeypatch.setattr(branch, "whole_array", whole_array)
    assert warnings_of(result()) == [
        "of 2 orbits the fastest decays are unknown: the product of the multipliers differs from that which the divergence of "
        "the equations demands"
    ]


def test_the_lines_that_end_the_report() -> None:
    made = result()
    orbit = made.wucht.summary["orbits"][0]
    whole = STUDY.report(made)
    many = STUDY.report(with_answer(made, orbits=[orbit] * 40))
    shown = len(many) - 1 - (len(whole) - 2)
    assert many[-1] == f"  and {40 - shown} more orbits: see the Dataset" and 1 < shown < 40
    assert STUDY.report(with_answer(made, orbits=[orbit] * shown))[-1] == many[-2]
    rotor = made.assign_attrs(rotor=1)
    for section, of in ((False, "all disturbances"), (True, "disturbances with equal phases of the bodies only")):
        last = STUDY.report(with_answer(rotor, section=section, orbits=[]))[-1]
        assert last == f"  stability    in the averaged equations, of {of}; exponents: per unit of time"
    assert not STUDY.report(with_answer(rotor, branches=[], orbits=[]))[-1].startswith("  stability")


def test_exponents_are_complex() -> None:
    _, found = circles()
    (branch, orbit), _ = found.orbits
    made = result(orbits=((branch, replace(orbit, exponents=np.array([-0.25 + 0.75j]))),))
    assert (made.orbit_exponent_re.item(), made.orbit_exponent_im.item()) == (-0.25, 0.75)


def test_the_turns_of_a_branch_are_in_its_line() -> None:
    (branch,) = circles()[1].branches
    for winding, turns, expected in (
        ([0, 0], {}, ""),
        ([0, 1], {"y": 1}, "; turns a period: y +1"),
        ([1, -2], {"x": 1, "y": -2}, "; turns a period: x +1, y -2"),
    ):
        made = result(branches=(replace(branch, seed=replace(branch.seed, winding=np.array(winding))),))
        assert made.wucht.summary["branches"][0]["winding"] == turns
        line = STUDY.report(made)[2]
        assert line.endswith(expected) and "all angles return" not in line  # there is no angle
        turning = STUDY.report(made.assign_attrs(angles=1))[2]
        assert turning.endswith(expected or "; all angles return")


def test_exponents_of_a_rotor_per_angle_are_those_per_time_over_its_speed() -> None:
    """Half a unit of time a unit of angle: each exponent is half as large."""
    plan, found = circles()
    (branch, one), *_ = found.orbits
    problem = SimpleNamespace(shows_rotor_speed=True, labels=SimpleNamespace(state=None))
    rotating: Any = SimpleNamespace(problem=problem, along=plan.along)
    entry = orbit_entry(rotating, branch, replace(one, period=2.0, period_phi=4.0, exponents=np.array([-0.5 + 1.0j])))
    assert entry["exponents"] == [[-0.5, 1.0]] and entry["exponents_phi"] == [[-0.25, 0.5]]


@pytest.mark.parametrize(
    ("stable", "special", "expected"),
    [
        ([1, 1, 0, 1], [0, 0, 0, 0], [(0, 2), (3, 4)]),
        ([0, 1, 0, 0], [1, 0, 1, 0], [(0, 3)]),  # with the special orbits at its ends
        ([0, 0, 0, 1], [0, 1, 0, 0], [(3, 4)]),  # a special orbit alone is none
        ([0, 0], [0, 0], []),
        ([], [], []),
    ],
)
def test_stable_stretches_reach_to_special_orbits(stable: list[int], special: list[int], expected: Any) -> None:
    assert orbit_dataset._stretches(np.array(stable, bool), np.array(special, bool)) == expected


def entry_of(stable: list[int], end: str = "range", backward: bool = True, last: float = 6.0) -> dict[str, Any]:
    """Of a branch over 3, 1, 2, 5, 4, which ends at 0.5 before its first orbit and at ``last`` behind its last."""
    arrays = {"values": np.array([3.0, 1.0, 2.0, 5.0, 4.0]), "stable": np.array(stable, bool)}
    branch = SimpleNamespace(
        whole_array=arrays.__getitem__, kinds=[""] * 5, seed=SimpleNamespace(origin="a run", winding=None),
        onward=SimpleNamespace(end=SimpleNamespace(parameter=last, kind=end)),
        backward=SimpleNamespace(end=SimpleNamespace(parameter=0.5)) if backward else None,
    )  # fmt: skip
    plan: Any = SimpleNamespace(problem=SimpleNamespace(turns=lambda winding: {}, bounds=(0.0, 6.0)))
    (entry,) = orbit_dataset._branch_entries(plan, SimpleNamespace(branches=[branch]))  # type: ignore[arg-type]
    return entry


def test_ranges_of_stable_orbits_go_to_the_ends_of_the_branch() -> None:
    assert entry_of([1, 1, 0, 1, 1]) == {
        "begun": "a run",
        "range": [1.0, 5.0],
        "winding": {},
        "stable": [[0.5, 3.0], [4.0, 6.0]],
    }
    assert entry_of([0, 1, 1, 1, 0])["stable"] == [[1.0, 5.0]]
    assert entry_of([1, 0, 0, 0, 0], backward=False)["stable"] == [[3.0, 3.0]]
    assert entry_of([1, 1, 0, 1, 1], orbit_dataset.CLOSED_BRANCH, False)["stable"] == [[1.0, 6.0]], (
        "on either side of the first"
    )
    assert entry_of([1, 0, 1, 1, 0], orbit_dataset.CLOSED_BRANCH, False)["stable"] == [[3.0, 3.0], [2.0, 5.0]]
    assert entry_of([0, 1, 0, 1, 1], orbit_dataset.CLOSED_BRANCH, False)["stable"] == [[1.0, 1.0], [4.0, 6.0]]
    assert entry_of([1, 1, 0, 1, 1], orbit_dataset.CLOSED_BRANCH, False, 0.25)["stable"] == [[0.25, 5.0]]


def test_the_rotor_turns_through_a_positive_angle_in_a_period() -> None:
    """Of a rotor that turns backwards too; of equations there is no such angle."""
    labels = Labels("speed of the main rotor", "rad/s", None)
    arrays = {"periods": np.array([2.0, 5.0]), "mean": np.array([3.0, -2.0]), "logarithms": np.zeros((1, 2))}
    plan, branch = circles()[0], SimpleNamespace(
        whole_array=lambda name: arrays.get(name, np.zeros(2)), kinds=("", ""),
    )  # fmt: skip
    for one, expected in ((labels, [6.0, 10.0]), (plan.problem.labels, None)):
        problem = SimpleNamespace(labels=one, system=plan.problem.system)
        of: Any = SimpleNamespace(along=plan.along, problem=problem)
        by_name = {q.name: q.value for q in orbit_quantities(of, [cast("Any", branch)])}
        turned = by_name.get("period_phi")
        assert turned is None if expected is None else np.asarray(turned).tolist() == expected


def test_every_orbit_of_the_circles_in_closed_form() -> None:
    """Radius sqrt mu, once round at the speed 2 + mu, exponent -2 mu: of the whole branch and of the reported orbits."""
    made = result()
    for prefix, value in (("", "value"), ("orbit_", "orbit_value")):
        mu = made[value].values
        assert made[f"{prefix}period"].values == pytest.approx(2 * np.pi / (2 + mu), rel=1e-4)
        assert f"{prefix}period_phi" not in made
        assert made[f"{prefix}max_x"].values == pytest.approx(np.sqrt(mu), rel=1e-3, abs=1e-6)
        assert made[f"{prefix}min_x"].values == pytest.approx(-np.sqrt(mu), rel=1e-3, abs=1e-6)
        assert made[f"{prefix}exponent_re"].values[0] == pytest.approx(-2 * mu, rel=1e-3, abs=1e-6)
    assert (
        made.orbit_time.values[:, -1] == pytest.approx(made.orbit_period.values) and (made.orbit_time.values[:, 0] == 0).all()
    )


def of_branch(values: list[float], stable: list[int], kinds: list[str], ends: tuple[Any, Any]) -> Any:
    """A branch whose ends are behind its first and behind its last orbit."""
    arrays = {"values": np.array(values), "stable": np.array(stable, bool)}
    return SimpleNamespace(
        whole_array=arrays.__getitem__, kinds=kinds, seed=SimpleNamespace(origin="a run", winding=None),
        backward=ends[0] and SimpleNamespace(end=ends[0]), onward=SimpleNamespace(end=ends[1]),
    )  # fmt: skip


def end_at(value: float, kind: str = "range") -> Any:
    return SimpleNamespace(parameter=value, kind=kind)


SYSTEM: Any = SimpleNamespace(
    along=SimpleNamespace(sentence_name="mu", path="mu", unit="N m"), case=SimpleNamespace(no_steady_reason=""),
    problem=SimpleNamespace(turns=lambda winding: {}, embedding=None, shows_rotor_speed=False, bounds=(-9.0, 4.0),
        system=SimpleNamespace(state_names=("x", "y"))),
)  # fmt: skip


def test_a_special_orbit_alone_is_no_stable_stretch() -> None:
    branch = of_branch([1.0, 2.0, 3.0], [0, 1, 0], ["", "torus", ""], (None, end_at(4.0)))
    (entry,) = orbit_dataset._branch_entries(SYSTEM, SimpleNamespace(branches=[branch]))  # type: ignore[arg-type]
    assert entry["stable"] == []


def test_a_closed_branch_is_stable_on_either_side_of_its_first_orbit() -> None:
    """The larger of both sides, whichever it is."""
    for values in ([5.0, 6.0, 3.0, 4.0], [4.0, 5.0, 3.0, 6.0]):
        closed = of_branch(values, [1, 1, 0, 1], [""] * 4, (None, end_at(values[0], orbit_dataset.CLOSED_BRANCH)))
        (entry,) = orbit_dataset._branch_entries(SYSTEM, SimpleNamespace(branches=[closed]))  # type: ignore[arg-type]
        assert entry["stable"] == [[4.0, 6.0]]


@pytest.mark.parametrize("backwards", [False, True])
def test_the_sentence_goes_from_the_lower_end_to_the_upper_one(backwards: bool) -> None:
    values, ends = [1.0, 2.0, 3.0], (end_at(0.5, "hopf"), end_at(3.25, "saddle-connection"))
    values, ends = (values[::-1], ends[::-1]) if backwards else (values, ends)
    branch = of_branch(values, [1, 1, 1], [""] * 3, ends)
    findings: Any = SimpleNamespace(branches=[branch], complete=True)
    sentence = orbit_dataset._sentence(SYSTEM, findings, [(0, ends[0]), (0, ends[1]), (1, end_at(-9.0))])
    assert sentence == (
        "periodic orbits at mu from 0.5 to 3.25 N m, stable from 0.5 to 3.25 N m; it ends at a Hopf point and at a saddle "
        "connection"
    )


def test_a_rounding_error_is_no_value_of_the_parameter() -> None:
    """In the sentence, in the report and of an end: 0, where it is below 1e-12 of the range; a greater number is a value."""
    branch = of_branch([1e-6, 2.0], [1, 1], ["", ""], (end_at(-8e-55, "hopf"), end_at(3.0)))
    findings: Any = SimpleNamespace(branches=[branch], complete=True)
    sentence = orbit_dataset._sentence(SYSTEM, findings, [(0, branch.backward.end), (0, branch.onward.end)])
    assert sentence.startswith("periodic orbits at mu from 0 to 3 N m, stable from 0 to 3 N m;")
    (entry,) = orbit_dataset._branch_entries(SYSTEM, SimpleNamespace(branches=[branch]))  # type: ignore[arg-type]
    assert (entry["range"], entry["stable"]) == ([1e-6, 2.0], [[0.0, 3.0]])
    lines = STUDY.report(with_answer(result(), branches=[entry], along_unit="N m"))
    assert "mu from 1e-06 to 2 N m, stable at mu from 0 to 3 N m" in lines[2]
    values = [significant_value(value, (-9.0, 4.0)) for value in (-8e-55, -8e-12, 1e-11, -8.76543)]
    assert values == [0.0, 0.0, 1e-11, -8.76543]
    assert significant_value(-8e-55, (-np.inf, np.inf)) == -8e-55, "without a range no number is small"


def test_the_law_of_a_saddle_connection_has_the_rate_of_the_saddle() -> None:
    """T = T_0 - ln|mu - mu_c|/rate: a factor of 4 s is a rate of 0.25/s."""
    laws = {name: SimpleNamespace(critical=1.0, error=0.1, factor=4.0, residual=0.01) for name in ("node", "connection")}
    end: Any = SimpleNamespace(
        kind="saddle-connection", error=0.1, period=9.0, sentence="", equilibrium=np.array([1.0, 2.0]), parameter=1.5,
        eigenvalues=np.array([0.25, -1.0 + 2.0j]), saddle_node=laws["node"], connection=laws["connection"],
    )  # fmt: skip
    entry = orbit_dataset._end_entry(SYSTEM, 0, end)
    assert (entry["laws"]["connection"]["rate"], entry["laws"]["saddle-node"]["factor"]) == (0.25, 4.0)
    assert entry["state"] == {"x": 1.0, "y": 2.0} and entry["eigenvalues"] == [[0.25, 0.0], [-1.0, 2.0]]
    assert orbit_dataset._end_entry(SYSTEM, 0, SimpleNamespace(**vars(end) | {"connection": None}))["laws"] is None  # type: ignore[arg-type]


def test_each_orbit_has_the_number_of_its_branch() -> None:
    """Of branches of two orbits and three; each value says of which it is."""
    plan, _ = circles()

    def counted(k: int, count: int) -> Any:
        values = 10.0 * k + np.arange(count)
        arrays = dict.fromkeys(("logarithms",), values[None] + 0j) | dict.fromkeys(
            ("is_trusted", "unstable", "stable"), values > 9
        )
        return SimpleNamespace(whole_array=lambda name: arrays.get(name, values), kinds=["", "torus", ""][:count])

    by_name = {q.name: np.asarray(q.value) for q in orbit_quantities(plan, [counted(1, 2), counted(2, 3)])}
    assert by_name["branch"].tolist() == [0, 0, 1, 1, 1] and by_name["value"].tolist() == [10, 11, 20, 21, 22]
    assert by_name["at_special"].tolist() == [0, 1, 0, 1, 0]
    assert by_name["exponent_re"][0] == pytest.approx(1.0), "the logarithm over the period"


def test_values_at_the_ends_of_the_range_are_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computation, "values_of", lambda subject, along, values, key: values)
    subject: Any = None
    assert computation._values_in_range(subject, subject, (1.0, 2.0), (2.0, 1.0, 2.0), "at") == (2.0, 1.0)
    with refused("study.at[1]", given=2.1):
        computation._values_in_range(subject, subject, (1.0, 2.0), (1.0, 2.1), "at")


def test_orbits_are_drawn_in_the_space_of_two_states() -> None:
    """Circles of radius sqrt mu, solid as they are stable, and dashed if they were not; their states are in the result."""
    made = result()
    assert made.orbit_states.dims == ("orbit", "state", "place") and made.state.values.tolist() == ["x", "y"]
    assert np.array_equal(made.orbit_states.sel(state="x").values, made.orbit_state.values)
    for show in ("x", "y"):
        for unstable in (False, True):
            shown = made.assign_attrs(state=show)
            shown["orbit_exponent_re"] = shown.orbit_exponent_re * (-1 if unstable else 1)
            axis = Figure().add_subplot()
            orbit_figure._phase_space(axis, shown, [0, 1])
            assert (axis.get_xlabel(), axis.get_ylabel()) == (show, {"x": "y", "y": "x"}[show])
            for line, mu, states in zip(axis.get_lines(), (0.5, 1.5), made.orbit_states.values, strict=True):
                x, y = (np.asarray(v, float) for v in line.get_data())
                assert np.array_equal(x, states[0 if show == "x" else 1])
                assert np.hypot(x, y) == pytest.approx(math.sqrt(mu), rel=1e-6)
                assert (line.get_linestyle() == "--") == unstable
    phase_space = STUDY.figure(made).axes[3]
    assert (phase_space.get_xlabel(), phase_space.get_ylabel()) == ("x", "y")


def test_the_second_state_is_one_that_is_no_angle() -> None:
    made = result()
    third = xr.concat([made.orbit_states, made.orbit_states.isel(state=[1])], "state").assign_coords(state=["x", "a", "z"])
    turned = made.drop_vars(["orbit_states", "turning", "state"])
    turned = turned.assign(orbit_states=third, turning=("state", np.array([0, 1, 0])))
    axis = Figure().add_subplot()
    orbit_figure._phase_space(axis, turned, [0])
    assert axis.get_ylabel() == "z"


def test_orbits_are_drawn_from_their_least_speed_over_one_period() -> None:
    """Circles of radius sqrt mu at the speed 2 + mu: x = -sqrt(mu) cos(2 + mu) t, and as stored, the period repeated."""
    made = result()
    for share in (False, True):
        axis = Figure().add_subplot()
        orbit_figure._runs(axis, made, [0, 1], "orbit_state", share)
        for k, (line, mu) in enumerate(zip(axis.get_lines(), made.orbit_value.values, strict=True)):
            x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
            turned = 2 * np.pi * x if share else (2 + mu) * x
            assert x[0] == 0.0 and turned[-1] == pytest.approx(2 * np.pi, rel=1e-4) and (np.diff(x) > 0).all()
            assert y == pytest.approx(-np.sqrt(mu) * np.cos(turned), abs=0.05 * np.sqrt(mu))
            time, stored = made.orbit_time.values[k], made.orbit_state.values[k]
            begin = time[stored[:-1].argmin()]
            assert y == pytest.approx(
                np.interp(begin + turned / turned[-1] * time[-1], time, stored, period=time[-1]), abs=1e-9
            )
