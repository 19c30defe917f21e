"""Findings of ``speed-curve`` that are made by hand: families that are stable in part, gaps, many values."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp
import xarray as xr
from matplotlib import colormaps
from matplotlib.colors import to_hex
from tests.hand_made import drawn, five_functions, titled, warnings_of, with_answer

from wucht.dynamics.branches.bifurcation_diagram import BranchFindings, NominalState, SearchedValue
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.second_parameter import BifurcationCurve
from wucht.dynamics.branches.steady_states import Kind, Labels, SystemEquilibria
from wucht.files.user_system import UserSystem
from wucht.plots.style import COLOURS, GREY
from wucht.studies.speed_curve import dataset as dataset_module
from wucht.studies.speed_curve import figure as figure_module
from wucht.studies.speed_curve import report as report_module
from wucht.studies.speed_curve.spec import SpeedCurve
from wucht.system import System

STUDY = five_functions("speed-curve")
X, MU, SHIFT = sp.symbols("x mu shift", real=True)
OWN = UserSystem(System((X,), (MU + SHIFT - X,), (MU, SHIFT)), {"mu": 5.0, "shift": 0.0})
ASKED: dict[str, Any] = {"along": "mu", "range": [1.0, 10.0], "ranges": {"x": [-2, 22]}}
SEARCHED = SearchedValue(5.0, None, 1, True, "as by hand")


@pytest.fixture(autouse=True)
def as_of_a_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """The equations have the names and keys of a machine of which a state is drawn."""
    labels = property(lambda one: Labels(f"state {one.show}", "", one.show))
    monkeypatch.setattr(SystemEquilibria, "labels", labels)


def plan(**asked: Any) -> Any:
    return STUDY.prepare(SpeedCurve(**ASKED | asked), OWN)


def branch(low: float, high: float, *shares: float, **other: Any) -> EquilibriumBranch:
    """Ten points; x is twice the parameter."""
    values = np.linspace(low, high, 10)
    exponents = np.full((1, 10), -1.0, complex)
    made = EquilibriumBranch(np.stack([2 * values, values]), exponents, ("",) * 10, ("the range ends", "it is closed"))
    return replace(made, stable_share=shares, **{"dimension": 1 if shares else 0} | other)


def result(*branches: EquilibriumBranch, of: Any = None, dimensionless: bool = True, **other: Any) -> xr.Dataset:
    found = BranchFindings((SEARCHED,), branches, complete=True)
    return titled(STUDY.dataset(of or plan(), replace(found, **other)), dimensionless)


SOME = (0.0,) * 3 + (0.25, 0.5, 0.75, 0.875) + (1.0,) * 3
NEVER_ALL = (0.0,) * 5 + (0.25, 0.5, 0.5, 0.5, 0.125)


# --- sentences and warnings ---


def test_sentences() -> None:
    unstable = branch(1.0, 10.0, exponents=np.full((1, 10), 1.0, complex))
    words = {
        "one branch of steady states, stable somewhere; no special point": (branch(1, 10),),
        "one branch of steady states, nowhere stable; no special point": (unstable,),
        "2 branches of steady states, 1 of them stable somewhere; no special point": (branch(1, 10), unstable),
        "2 branches of steady states, none of them stable anywhere; no special point": (unstable, unstable),
        "one branch of steady states, stable somewhere, one family with members that are stable and others that are not; "
        "no special point": (branch(1, 10, *SOME),),
        "2 branches of steady states, none of them stable with all members, 2 families with members that are stable and others "
        "that are not; no special point": (branch(1, 10, *NEVER_ALL), branch(1, 9, *NEVER_ALL)),
    }  # fmt: skip
    for sentence, branches in words.items():
        assert result(*branches).wucht.summary["sentence"] == sentence
    assert result().wucht.summary["sentence"] == "no steady states were found, between mu = 1 and 10"
    interrupted = result(complete=False)
    assert interrupted.wucht.summary["sentence"] == "the study was interrupted before the first branch"
    assert warnings_of(interrupted)[-1] == "0 branches are followed; the search is not finished"
    assert warnings_of(result(branch(1, 10), complete=False))[-1] == "one branch is followed; the search is not finished"


def test_warnings() -> None:
    lost = tuple(f"lost {k}" for k in range(5))
    assert warnings_of(result(omissions=lost)) == ["lost 0", "lost 1", "lost 2", "and 2 more states"]
    assert warnings_of(result(omissions=lost[:3])) == list(lost[:3])
    changing = replace(branch(1.0, 10.0), exponents=np.array([[-1.0] * 4 + [1.0] * 3 + [-1.0] * 3], complex))
    where = "between mu = 4 and 5, and at 1 more places"
    assert warnings_of(result(branch(1, 10), changing)) == [
        f"on branch 2 stability changes {where}: no fold, Hopf or branch point was located there"
    ]
    once = replace(changing, exponents=np.array([[-1.0] * 4 + [1.0] * 6], complex))
    assert warnings_of(result(once))[0].startswith("on branch 1 stability changes between mu = 4 and 5: no fold")
    families = warnings_of(result(branch(1, 10, *(1.0,) * 10), branch(1, 9, *(1.0,) * 10, dimension=2)))
    assert families == [
        "the states in which the unbalances compensate form families of dimension 1 and 2: one member represents each where a "
        "state is listed; its exponents are those transverse to the family"
    ]
    partly = warnings_of(result(branch(1, 10, *SOME)))
    assert partly[-1].startswith("of a family ") and partly[-1].endswith("the limits of rare members may be wider")


# --- the report ---


def lines(made: xr.Dataset) -> list[str]:
    told: list[str] = STUDY.report(made)
    return told


def test_the_lines_of_families() -> None:
    some = lines(result(branch(1, 10, *SOME)))[2]
    assert some == (
        "  branch 1     steady states (family of dimension 1), from 1 to 10: all members stable at mu from 8 to 10 (16 to 20); "
        "some members stable and others not from 4 to 7 (8 to 14), 25.0 to 87.5 % of them"
    )
    never = lines(result(branch(10, 1, *NEVER_ALL)))[2]
    assert never == (
        "  branch 1     steady states (family of dimension 1), from 1 to 10: nowhere are all members stable; some members "
        "stable and others not from 1 to 5 (2 to 10), 12.5 to 25.0 % of them"
    )
    none = lines(result(branch(1, 10, *(0.0,) * 10)))[2]
    assert none == "  branch 1     steady states (family of dimension 1), from 1 to 10: nowhere stable"
    isolated = lines(result(branch(1, 10, ends=("it stops", "it stops"))))
    assert isolated[2:] == [
        "  branch 1     steady states, from 1 to 10: stable at mu from 1 to 10 (2 to 20)",
        "               its end: it stops",
        "  complete     yes at one value of mu: as by hand; only branches between these values may be missing",
    ]
    assert lines(result(branch(1, 10), searches=()))[-1].startswith("  branch 1")


def test_the_state_as_it_is_of_a_family_may_be_stable_in_part() -> None:
    u, exponents = np.array([10.0, 5.0]), np.array([-1.0 + 0j])
    found = {share: NominalState(u, exponents, 0, share) for share in (None, 0.0, 0.125, 1.0)}
    told = {share: lines(result(branch(1, 10, *SOME), nominal=(one,)))[-2] for share, one in found.items()}
    assert told == {
        None: "  stable       at mu = 5: steady, x = 10",
        0.0: "  unstable     at mu = 5: steady, x = 10",
        0.125: "  partly       at mu = 5: steady, x = 10; 12.5 % of the family's members are stable",
        1.0: "  stable       at mu = 5: steady, x = 10",
    }


POINT = {"value": 2.5, "speed": 3.0, "amplitude": None, "frequency": None}


def test_the_lines_of_special_points_and_of_curves() -> None:
    made = result(branch(1, 10))
    points = [POINT | {"kind": "hopf", "frequency": 0.25}, POINT | {"kind": "some-stable", "amplitude": 0.5}]
    curve = {
        "of": "hopf", "name": None, "range": [1.0, 2.0], "second_range": [3.0, 4.0],
        "special_points": [{"kind": "cusp", "value": 1.25, "second_value": 3.5}],
    }  # fmt: skip
    curves = [curve, curve | {"of": "fold", "name": "together", "special_points": []}]
    told = lines(with_answer(made, special_points=points, curves=curves, second="shift", second_unit="N"))
    assert told[3:8] == [
        "  hopf         mu = 2.5: x = 3, oscillation with 0.25",
        "  some-stable  mu = 2.5: x = 3, amplitude 0.5; on one side some members of the family are stable, on the other none",
        "  curve of Hopf points: mu from 1 to 2, shift from 3 to 4 N",
        "    cusp             mu = 1.25, shift = 3.5 N",
        "  curve of folds, together: mu from 1 to 2, shift from 3 to 4 N",
    ]
    unit = result(branch(1, 10))
    unit.special_frequency.attrs["units"] = "rad/s"
    told = lines(with_answer(unit, special_points=[points[0] | {"second_value": 7.0}], second="shift", second_unit="N"))
    assert told[3] == "  hopf         mu = 2.5, shift = 7 N: x = 3, oscillation with 0.25 rad/s"
    many = lines(with_answer(made, special_points=[points[0]] * 18))
    assert many[3:20] == ["  hopf         mu = 2.5: x = 3, oscillation with 0.25"] * 16 + [
        "  and 2 more special points: see the Dataset"
    ]
    assert len(lines(with_answer(made, special_points=[points[0]] * 16))) == len(lines(made)) + 16


def test_what_is_drawn_has_its_unit() -> None:
    made = result(branch(1, 10), dimensionless=False)
    made.speed.attrs["units"], made.amplitude.attrs["units"] = "kg", "m"
    told = lines(with_answer(made, special_points=[POINT | {"kind": "fold", "amplitude": 0.5}]))
    assert told[2].endswith("stable at mu from 1 to 10 (2 kg to 20 kg)")
    assert told[3] == "  fold         mu = 2.5: x = 3 kg, amplitude 500 mm"
    speeds = lines(with_answer(made, special_points=[POINT | {"kind": "fold", "amplitude": 0.5}], show=None, inertia=True))
    assert speeds[3] == "  fold         mu = 2.5: speed 3 rad/s (29 rpm), amplitude 500 mm"
    assert [line[:15] for line in speeds[-2:]] == ["  stability    ", "  left out     "]


# --- the figure ---


def second(*values: float) -> xr.Dataset:
    """Branches at values of the second parameter, each farther up, with a fold."""
    made = plan(second="shift", second_values=values)
    kinds = ("",) * 4 + ("fold",) + ("",) * 5
    branches = []
    for value in values:
        one = branch(1, 10, second=value, kinds=kinds)
        branches.append(replace(one, unknowns=one.unknowns + np.array([[value], [0.0]])))
    return result(*branches, of=made)


def test_values_of_a_second_parameter_have_the_colours_of_a_scale() -> None:
    """Which differ in grey, too; in the legend they are samples, wider than the lines that show what is stable."""
    (axis, *_) = drawn("speed-curve", second(0.5, 2.0)).axes
    solid = [line for line in axis.lines if line.get_linestyle() == "-"]
    assert list(dict.fromkeys(line.get_color() for line in solid)) == ["#440154", to_hex(colormaps["viridis"](0.9))]
    assert [line.get_linewidth() for line in axis.get_legend().legend_handles[:2]] == [4.0, 4.0]
    names = [t.get_text() for t in axis.get_legend().get_texts()]
    assert names == ["$shift$ = 0.5", "$shift$ = 2", "stable", "fold"]
    assert " ".join(axis.get_xlabel().split()) == "$\\mu$"
    assert axis.get_xlim() == (1.0, 10.0) and axis.get_xscale() == "linear"


def test_a_value_of_the_second_parameter_has_its_unit_in_the_legend() -> None:
    made = second(0.5, 2.0).assign_attrs(along_unit="m", second_unit="N")
    assert [figure_module._key(made, k) for k in range(2)] == [f"$shift$ = {v}\N{NO-BREAK SPACE}N" for v in ("0.5", "2")]


def test_values_of_the_second_parameter_have_four_digits_or_six_where_those_are_alike() -> None:
    for values, words in (((0.0672888, 0.1), ("0.06729", "0.1")), ((0.0672888, 0.0672911), ("0.0672888", "0.0672911"))):
        made = second(*values)
        assert [figure_module._key(made, k) for k in range(2)] == [f"$shift$ = {v}" for v in words]


def test_many_values_have_the_colours_of_a_scale_and_some_names() -> None:
    values = [0.5 * k for k in range(9)]
    (axis, *_) = drawn("speed-curve", second(*values[::-1])).axes
    solid = [line for line in axis.lines if line.get_linestyle() == "-"]
    colours = {float(line.get_ydata()[0]) - 2.0: line.get_color() for line in solid if line.get_xdata()[0] == 1.0}
    assert sorted(colours) == pytest.approx(values)
    assert colours[0.0] == "#440154" and len(set(colours.values())) == 9
    assert colours[4.0] == to_hex(colormaps["viridis"](0.9))
    assert [t.get_text() for t in axis.texts] == []
    names = [t.get_text() for t in axis.get_legend().get_texts()]
    assert names == [*(f"$shift$ = {v}" for v in ("0", "0.5", "1.5", "2", "2.5", "3.5", "4")), "stable", "fold"]


def test_a_range_of_two_decades_is_drawn_by_its_logarithm() -> None:
    """Of a machine; of other equations a range is drawn as it is."""
    for low, scale, machine in ((0.1, "log", True), (0.11, "linear", True), (0.1, "linear", False)):
        made = result(branch(low, 10.0), of=plan(range=[low, 10.0]))
        if machine:
            made.attrs["input"] = '{"study": {}, "machine": {"bodies": [["rotor", "rotor", ""]]}}'
        (axis, *_) = drawn("speed-curve", made).axes
        assert axis.get_xscale() == scale and axis.get_xlim() == (low, 10.0)


def test_few_points_are_joined_by_straight_lines() -> None:
    short = EquilibriumBranch(
        np.array([[2.0, 9.0, 4.0], [1.0, 2.0, 10.0]]), np.full((1, 3), -1.0, complex), ("",) * 3, ("the range ends",) * 2
    )
    (axis, *_) = drawn("speed-curve", result(short)).axes
    (line,) = [line for line in axis.lines if line.get_linestyle() == "-"]
    assert (line.get_xdata().tolist(), line.get_ydata().tolist()) == ([1.0, 2.0, 10.0], [2.0, 9.0, 4.0])


def test_stretches_have_lines_by_what_is_stable() -> None:
    (axis, *_) = drawn(
        "speed-curve", result(branch(1, 10, *SOME), nominal=(NominalState(np.array([10.0, 5.0]), np.array([-1.0]), 0),))
    ).axes
    shown = [(line.get_linestyle(), float(line.get_xdata()[0]), float(line.get_xdata()[-1])) for line in axis.lines]
    assert [(a, b) for style, a, b in shown if style == "-"] == [(8.0, 10.0)]
    assert shown[-1] == (":", 5.0, 5.0)
    names = [t.get_text() for t in axis.get_legend().get_texts()]
    assert names == ["stable", "unstable", "some members of\nthe family stable", "as it is:\n$\\mu$ = 5"]


def test_curves_in_the_plane_of_two_parameters() -> None:
    made = plan(second="shift", second_range=[-1.0, 3.0], points=1)
    u = np.array([[2.0, 3.0, 4.0], [4.0, 5.0, 6.0], [0.0, 0.5, 1.0]])
    none: dict[str, float] = {}
    fold = BifurcationCurve("fold", Kind(), u, ("", "cusp", ""), (none,) * 3, ("the range ends",) * 2)
    hopf = BifurcationCurve("hopf", Kind("together"), u + 1, ("", "", "bogdanov-takens"), (none,) * 3, ("the range ends",) * 2)
    shown = result(branch(1, 10), of=made, curves=(fold, hopf))
    sentence = shown.wucht.summary["sentence"]
    assert sentence.endswith("; no special point; 2 curves of them in mu and shift with one cusp, one Bogdanov-Takens point")
    plane = drawn("speed-curve", shown).axes[-1]
    expected = [
        ("folds", "-", [4.0, 5.0, 6.0], [0.0, 0.5, 1.0]),
        ("Hopf points, together", "--", [5.0, 6.0, 7.0], [1.0, 1.5, 2.0]),
        ("cusp", "None", [5.0], [0.5]),
        ("Bogdanov-Takens", "None", [7.0], [2.0]),
    ]
    lines = plane.get_lines()
    assert [
        (" ".join(a.get_label().split()), a.get_linestyle(), list(a.get_xdata()), list(a.get_ydata())) for a in lines[:4]
    ] == expected
    assert lines[1].get_color() == GREY and list(lines[4].get_ydata()) == [0.0, 0.0]
    assert plane.get_ylabel() == "$shift$" and plane.get_xlim() == (1.0, 10.0)


def test_types_are_written_on_branches_that_have_no_second_value() -> None:
    typed = branch(1, 10, kind=Kind("together", "II"))
    (axis, *_) = drawn("speed-curve", result(typed)).axes
    (written,) = axis.texts
    assert written.get_text() == "II" and 1.0 < written.xy[0] < 10.0 and written.xy[1] == pytest.approx(2 * written.xy[0])
    made = result(replace(typed, second=0.5), of=plan(second="shift", second_values=(0.5,)))
    assert [t.get_text() for t in drawn("speed-curve", made).axes[0].texts] == []


def test_entries_of_what_is_stable_have_the_colour_of_the_branches_if_they_have_one() -> None:
    for made, expected in ((result(branch(1, 10)), COLOURS[0]), (second(0.5, 2.0), GREY)):
        (axis, *_) = drawn("speed-curve", made).axes
        legend = axis.get_legend()
        colours = {text.get_text(): line.get_color() for text, line in zip(legend.get_texts(), legend.get_lines(), strict=True)}
        assert colours["stable"] == expected


# --- what is stated where ---


def test_the_states_at_the_value_of_the_subject_are_the_fastest_first() -> None:
    """With their exponents from the fastest growth on; a state of a family has the name of its branch."""
    family = branch(1, 10, *(1.0,) * 10, kind=Kind("together", "II"))
    alone = branch(1, 10, kind=Kind("opposed", "III"))
    exponents = np.array([-3.0, -1.0 + 2j, np.nan, -1.0 - 2j, 0.5])
    nominal = (
        NominalState(np.array([4.0, 5.0]), np.array([-1.0 + 0j]), 0, 0.25), NominalState(np.array([-10.0, 5.0]), exponents, 1),
        NominalState(np.array([6.0, 5.0]), np.array([-2.0 + 0j]), 0, 1.0),
    )  # fmt: skip
    made = result(family, alone, nominal=nominal)
    states = made.wucht.summary["states"]
    assert [s["speed"] for s in states] == made.own_speed.values.tolist() == [-10.0, 6.0, 4.0]
    assert [(s["name"], s["type"]) for s in states] == [(None, None), ("together", "II"), ("together", "II")]
    assert [s["branch"] for s in states] == made.own_branch.values.tolist() == [1, 0, 0]
    assert [s["stable"] for s in states] == [False, True, False] and made.own_stable.values.tolist() == [0, 1, 0]
    assert [s["stable_share"] for s in states] == [None, 1.0, 0.25]
    assert made.own_stable_share.values[1:].tolist() == [1.0, 0.25]
    assert states[0]["exponents"] == [[0.5, 0.0], [-1.0, 2.0], [-1.0, -2.0], [-3.0, 0.0]]
    assert made.own_growth.values.tolist() == [0.5, -2.0, -1.0]
    assert (states[0]["state"], states[0]["exponents_phi"]) == ({"x": -10.0}, None), "x is no speed"


def test_exponents_over_the_angle_are_divided_by_the_speed_whatever_its_sign() -> None:
    of: Any = SimpleNamespace(case=SimpleNamespace(steady_states=SimpleNamespace(labels=SimpleNamespace(state=None))))
    exponents = np.array([-2.0 + 6j, -4.0])
    assert dataset_module._exponents_by_angle(of, exponents, -4.0) == [[-0.5, 1.5], [-1.0, 0.0]]
    assert dataset_module._exponents_by_angle(of, exponents, 0.0) is None


def test_special_points_of_several_branches_count_once_with_their_frequency() -> None:
    """That of a Hopf point is of the pair nearest to the imaginary axis, of those that oscillate."""
    exponents = np.full((4, 10), -1.0, complex)
    exponents[:, 4] = [-3.0 + 5j, -3.0 - 5j, 0.001 + 7j, 0.001 - 7j]
    exponents[0, 6] = np.nan
    hopf = branch(1, 10, kinds=("",) * 4 + ("hopf", "", "branch-point") + ("",) * 3, exponents=exponents)
    crossing = branch(7, 16, kinds=("branch-point",) + ("",) * 9)
    elsewhere = replace(crossing, unknowns=crossing.unknowns + np.array([[1.0], [0.0]]))
    found = BranchFindings((SEARCHED,), (hopf, crossing, elsewhere), complete=True)
    points = report_module.collect_special_points(plan(), found)
    assert [(p.kind, p.unknowns.tolist(), p.speed, p.branch, p.frequency) for p in points] == [
        ("hopf", [10.0, 5.0], 10.0, 0, 7.0), ("branch-point", [14.0, 7.0], 14.0, 0, None),
        ("branch-point", [15.0, 7.0], 15.0, 2, None),
    ]  # fmt: skip
    made = result(*(replace(one, exponents=one.exponents[:1]) for one in (crossing, elsewhere)))
    assert [(p["value"], p["speed"], p["branch"]) for p in made.wucht.summary["special_points"]] == [(7, 14, 0), (7, 15, 1)]
    assert made.special_value.values.tolist() == [7.0, 7.0] and made.special_speed.values.tolist() == [14.0, 15.0]
    assert made.special_state.values.tolist() == [[14.0, 15.0]] and made.special_branch.values.tolist() == [0, 1]
    assert made.wucht.summary["sentence"].endswith("; 2 branch points")


def test_limits_of_stable_members_have_a_frequency_if_what_grows_there_oscillates() -> None:
    exponents = np.full((4, 10), -1.0, complex)
    exponents[:, 4] = [-3.0 + 5j, -3.0 - 5j, 0.001 + 7j, 0.001 - 7j]
    exponents[:, 6] = [-3.0 + 5j, -3.0 - 5j, 0.001, -1.0]
    kinds = ("",) * 4 + ("some-stable", "", "all-stable") + ("",) * 3
    found = BranchFindings((SEARCHED,), (branch(1, 10, *SOME, kinds=kinds, exponents=exponents),), complete=True)
    points = report_module.collect_special_points(plan(), found)
    assert [(p.kind, p.frequency) for p in points] == [("some-stable", 7.0), ("all-stable", None)]


def test_points_of_branches_have_the_number_of_growing_disturbances() -> None:
    exponents = np.array([[1.0] * 5 + [-1.0] * 5, [2.0] * 3 + [1e-12] * 4 + [-1.0] * 3], complex)
    y, values = sp.Symbol("y", real=True), np.linspace(1.0, 10.0, 10)
    two = UserSystem(System((X, y), (MU + SHIFT - X, -y), (MU, SHIFT)), {"mu": 5.0, "shift": 0.0})
    of = STUDY.prepare(SpeedCurve(**ASKED | {"ranges": {"x": [-2, 22], "y": [-1, 1]}, "show": "x"}), two)
    one = replace(branch(1, 10), unknowns=np.stack([2 * values, 3 * values, values]), exponents=exponents)
    some = replace(one, stable_share=SOME, dimension=1, exponents=-exponents[::-1])
    made = result(one, some, of=of)
    assert made.unstable.values.tolist() == [2] * 3 + [1] * 2 + [0] * 5 + [0] * 5 + [1] * 2 + [2] * 3
    assert made.branch.values.tolist() == [0] * 10 + [1] * 10
    assert np.isnan(made.stable_share.values[:10]).all() and made.stable_share.values[10:].tolist() == list(SOME)
    assert made.state.values.tolist() == [[*(2 * values)] * 2, [*(3 * values)] * 2]
    assert made.exponent_re.values[:, 0].tolist() == [1.0, 2.0] and made.exponent_im.values[0, 0] == 0.0


def test_entries_of_branches_have_their_ends_from_the_lower_value_on() -> None:
    made = result(branch(10, 1, *SOME[::-1]))
    (entry,) = made.wucht.summary["branches"]
    assert (entry["range"], entry["family_dimension"], entry["multiplicity"]) == ([1.0, 10.0], 1, 1)
    assert (entry["stable"], entry["stable_speeds"]) == ([[8.0, 10.0]], [[16.0, 20.0]])
    assert (entry["partly_stable"], entry["partly_stable_speeds"]) == ([[4.0, 7.0]], [[8.0, 14.0]])
    assert entry["partly_stable_shares"] == [[0.25, 0.875]]
    assert (entry["ends"], entry["label"]) == (["the range ends", "it is closed"], "steady states")


def test_values_within_rounding_of_zero_are_zero() -> None:
    """To a billionth of the range, 9 here, and of the size of the ordinate."""
    of = plan()
    assert [dataset_module._snap_to_zero(of, x) for x in (8e-9, -8e-9, 10e-9)] == [0.0, 0.0, 10e-9]
    states: Any = SimpleNamespace(ordinate_size=20.0)
    assert [dataset_module._round_ordinate(states, x) for x in (-19e-9, 21e-9)] == [0.0, 21e-9]


def test_curves_have_their_ranges_and_the_points_where_a_second_condition_holds() -> None:
    made = plan(second="shift", second_range=[-1.0, 3.0], points=1)
    u = np.array([[2.0, 3.0, 4.0], [6.0, 5.0, 4.0], [0.0, 0.5, 1.0]])
    fold = BifurcationCurve("fold", Kind("together"), u, ("", "cusp", ""), ({}, {"c": 0.25}, {}), ("the range ends",) * 2)
    shown = result(branch(1, 10, second=None), of=made, curves=(fold,))
    (curve,) = shown.wucht.summary["curves"]
    assert (curve["range"], curve["second_range"], curve["of"]) == ([4.0, 6.0], [0.0, 1.0], "fold")
    (cusp,) = curve["special_points"]
    assert (cusp["value"], cusp["second_value"], cusp["speed"]) == (5.0, 0.5, 3.0)
    assert (cusp["mu"], cusp["shift"], cusp["coefficients"], cusp["state"]) == (5.0, 0.5, {"c": 0.25}, {"x": 3.0})
    assert shown.curve_value.values.tolist() == [6.0, 5.0, 4.0] and shown.curve_second.values.tolist() == [0.0, 0.5, 1.0]
    assert shown.curve_speed.values.tolist() == [2.0, 3.0, 4.0]
    assert shown.wucht.summary["second_value"] == 0.0, "where the curves begin"
    assert "second_value" not in shown.wucht.summary["branches"][0]


def test_branches_at_values_of_the_second_parameter_state_them() -> None:
    made = second(0.5, 2.0)
    assert [b["shift"] for b in made.wucht.summary["branches"]] == [0.5, 2.0]
    assert [(p["shift"], p["second_value"]) for p in made.wucht.summary["special_points"]] == [(0.5, 0.5), (2.0, 2.0)]
    assert made.second_value.values.tolist() == [0.5, 2.0]
    assert lines(made)[2].startswith("  branch 1     steady states at shift = 0.5, from 1 to 10")
    assert lines(made)[4].startswith("  fold         mu = 5, shift = 0.5: x = 10.5")


def test_searches_state_what_they_show_of_all_values() -> None:
    low, high = SearchedValue(1.0, None, 1, True, "first", (2.0, 8.0)), SearchedValue(3.0, None, 4, True, "second", (1.0, 7.0))
    failing = SearchedValue(2.0, None, 0, False, "", failure="why")
    made = result(branch(1, 10), searches=(low, failing, high, replace(failing, value=9.0)))
    s = made.wucht.summary
    assert (s["searched"], s["complete"]) == ([1.0, 3.0], False)
    assert s["shown"] == "first; over all of them speeds from 1 to 8"
    assert made.searched_value.values.tolist() == [1.0, 2.0, 3.0, 9.0] and made.searched_states.values.tolist() == [1, 0, 4, 0]
    assert warnings_of(made) == ["at 2 values of mu from 2 to 9 states could not be searched for: why"]
    doubtful = result(branch(1, 10), searches=(low, replace(high, complete=False)))
    assert doubtful.wucht.summary["shown"].startswith("second;")
    assert warnings_of(doubtful) == ["it is not proved that all states are known: second"]
    assert warnings_of(result(branch(1, 10), searches=(failing,))) == ["at mu = 2 states could not be searched for: why"]
    assert result(branch(1, 10), searches=(low, high)).wucht.summary["complete"]
    assert not result(branch(1, 10), searches=()).wucht.summary["complete"]


@pytest.mark.parametrize(
    ("kind", "label"),
    [
        ((None, "II", (3, 1)), "steady states"), (("opposed", None, (3, 1)), "opposed 3 : 1"),
        (("opposed", None, (1, 1)), "opposed"), (("together", None, (3, 1)), "together"),
        (("opposed", "III", (2, 1)), "type III: opposed"),
    ],
)  # fmt: skip
def test_labels_of_states(kind: Any, label: str) -> None:
    assert report_module.label_of(*kind) == label


def test_a_single_name_is_a_symbol_and_a_path_is_not() -> None:
    assert [dataset_module._symbol(path) for path in ("mu", "drive.slope")] == ["$\\mu$", "drive.slope"]


def with_amplitude() -> xr.Dataset:
    """Amplitudes of 1 to 10 mm over the parameter, of a machine that runs at twice its value."""
    made = result(branch(1, 10, kinds=("",) * 4 + ("fold",) + ("",) * 5), dimensionless=False)
    made.amplitude.values[:] = 1e-3 * made.value.values
    made.special_amplitude.values[:] = 5e-3
    made.amplitude.attrs["units"] = made.special_amplitude.attrs["units"] = "m"
    return made


def test_amplitudes_have_a_panel_in_their_printed_unit() -> None:
    speed, amplitude = drawn("speed-curve", with_amplitude()).axes[:2]
    solid = [line for line in amplitude.lines if line.get_linestyle() == "-"]
    x, y = (
        np.concatenate([np.asarray(values, float) for values in pair])
        for pair in zip(*(s.get_data() for s in solid), strict=True)
    )
    assert y == pytest.approx(x) and (x.min(), x.max()) == pytest.approx((1.0, 10.0))
    (fold,) = [line for line in amplitude.lines if line.get_linestyle() == "None"]
    assert (list(fold.get_xdata()), list(fold.get_ydata())) == ([5.0], [5.0])
    assert amplitude.get_ylabel() == "amplitude of the axis (mm)" and amplitude.get_ylim()[0] == 0
    (fold,) = [line for line in speed.lines if line.get_linestyle() == "None"]
    assert (list(fold.get_xdata()), list(fold.get_ydata())) == ([5.0], [10.0])


def test_the_ratio_to_a_speed_is_drawn_but_where_that_is_nearly_zero_or_prescribed() -> None:
    """A thousandth of the largest value, 10: not at 0.009."""
    made = with_answer(result(branch(1, 10)), show=None)
    made.attrs["along_unit"] = made.speed.attrs["units"] = "rad/s"
    ratio = figure_module._ratio(made)
    assert ratio is not None
    assert ratio(np.array([0.5, -4.0, 0.011]), np.array([1.0, 2.0, 0.022])) == pytest.approx([2.0, -0.5, 2.0])
    assert np.isnan(ratio(np.array([0.009, -0.009, 0.0]), np.ones(3))).all()
    prescribed = made.copy(deep=True)
    prescribed.speed.values[:] = prescribed.value.values
    assert figure_module._ratio(prescribed) is None
    made.attrs["along_unit"] = "N"
    assert figure_module._ratio(made) is None and figure_module._ratio(result(branch(1, 10))) is None


def test_named_states_have_colours_of_their_names_once() -> None:
    named = [
        branch(1, 10, kind=Kind(name, type_)) for name, type_ in (("opposed", "III"), ("compensating", "I"), ("opposed", "II"))
    ]
    colours = figure_module._colours(result(*named, branch(1, 9)))
    assert colours["type III: opposed"] == COLOURS[1] and colours["type I: compensating"] == COLOURS[2]
    assert colours["type II: opposed"] == COLOURS[3] and colours["steady states"] == COLOURS[4], "the free ones, in order"


def test_the_scale_begins_at_zero_if_nothing_is_below() -> None:
    below = replace(branch(1, 10), unknowns=branch(1, 10).unknowns - np.array([[10.0], [0.0]]))
    bottoms = [drawn("speed-curve", result(one)).axes[0].get_ylim()[0] for one in (branch(1, 10), below)]
    assert bottoms[0] == 0 and bottoms[1] < -8
