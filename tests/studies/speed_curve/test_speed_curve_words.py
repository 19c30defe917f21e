"""What a speed curve states of equations with a closed form: sentences, lines, tables, and what is drawn of them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import to_hex
from tests.interrupting import stop_at

from wucht import SpeedCurve, UserSystem, draw, load_machine, report, run
from wucht.files.building import machine_from
from wucht.plots.style import COLOURS, GREY

DOUBT = "deflated Newton's method from 64 starts within the ranges of the states: completeness is not proved"


def asked(states: dict[str, str], bounds: tuple[float, float] = (1.0, 10.0), progress: Any = None, **keys: Any) -> Any:
    """Over mu, which is 5, with 3 searches; another parameter is called shift, and is 0."""
    subject = UserSystem.from_formulas(states, {"mu": 5.0, "shift": 0.0})
    box = dict.fromkeys(states, (-22.0, 22.0))
    return run(SpeedCurve(**{"along": "mu", "range": bounds, "ranges": box, "points": 1} | keys), subject, progress=progress)


def line(**keys: Any) -> Any:
    return asked({"x": "mu + shift - x"}, **keys)


@cache
def at_second(*values: float) -> Any:
    """x^2 = mu + shift: a fold for each value."""
    return asked({"x": "mu + shift - x^2"}, (-20.0, 10.0), second="shift", second_values=values)


def test_sentences() -> None:
    assert line().wucht.sentence == "one branch of steady states, stable somewhere; no special point"
    assert asked({"x": "x - mu"}).wucht.sentence == "one branch of steady states, nowhere stable; no special point"
    both = asked({"x": "x^2 - mu^2"}).wucht.sentence
    assert both == "2 branches of steady states, 1 of them stable somewhere; no special point"
    saddles = asked({"x": "x^2 - mu^2", "y": "y"}).wucht.sentence
    assert saddles == "2 branches of steady states, none of them stable anywhere; no special point"
    assert line(ranges={"x": (50.0, 60.0)}).wucht.sentence == "no steady states were found, between mu = 1 and 10"


def test_what_is_not_finished_is_told() -> None:
    begun = line(progress=stop_at(2, "searching at"))
    assert begun.wucht.sentence == "one branch of steady states, stable somewhere; no special point"
    assert "one branch is followed; the search is not finished" in begun.wucht.warnings
    none = line(ranges={"x": (50.0, 60.0)}, progress=stop_at(2, "searching at"))
    assert none.wucht.sentence == "the study was interrupted before the first branch"
    assert "0 branches are followed; the search is not finished" in none.wucht.warnings


def test_the_lines_of_a_report() -> None:
    assert report(line())[2:5] == [
        "  branch 1     steady states, from 1 to 10: stable at mu from 1 to 10 (1 to 10)",
        "  stable       at mu = 5: x = 5",
        f"  complete     not proved at 3 values of mu: {DOUBT}; only branches between these values may be missing",
    ]
    assert line().wucht.warnings == [f"it is not proved that all states are known: {DOUBT}"]
    unstable = report(asked({"x": "x - mu"}))
    assert unstable[2].endswith(": nowhere stable") and unstable[3] == "  unstable     at mu = 5: x = 5"
    ends = report(asked({"x": "mu - x - 1e-3*x^3"}, (1.0, 2000.0), ranges={"x": (-1.0, 1.0)}))
    assert ends[3].startswith("               its end: x passes ")


def test_of_a_hopf_point_the_frequency_is_told() -> None:
    """Of the pair that grows there; another pair oscillates faster."""
    made = asked({"x": "(mu - 2)*x - 3*y", "y": "3*x + (mu - 2)*y", "u": "-5*u - 7*v", "v": "7*u - 5*v"})
    (point,) = made.wucht.summary["special_points"]
    assert (point["kind"], point["value"]) == ("hopf", pytest.approx(2.0)) and point["frequency"] == pytest.approx(3.0)
    assert report(made)[3] == "  hopf         mu = 2: x = 0, oscillation with 3"
    assert made.wucht.sentence.endswith("; one Hopf point")
    growing = np.unique(made.unstable.values[made.at_special.values == 0])
    assert growing.tolist() == [0, 2]
    (own,) = made.wucht.summary["states"]
    assert not own["stable"] and np.array(own["exponents"]) == pytest.approx(
        np.array([[3, 3], [3, -3], [-5, 7], [-5, -7]], float)
    )
    assert made.own_growth.values == pytest.approx([3.0]) and made.own_stable.values.tolist() == [0]


def test_branches_and_special_points_beyond_sixteen_are_counted() -> None:
    lines = report(at_second(*(0.25 * k for k in range(18))))
    assert lines[17].startswith("  branch 16 ") and lines[18] == "  and 2 more branches"
    assert lines[34].startswith("  fold ") and lines[35] == "  and 2 more special points: see the Dataset"


def test_branches_at_values_of_the_second_parameter_state_them() -> None:
    made = at_second(0.5, 2.0)
    assert [b["shift"] for b in made.wucht.summary["branches"]] == [0.5, 2.0]
    assert [(p["shift"], p["second_value"]) for p in made.wucht.summary["special_points"]] == [(0.5, 0.5), (2.0, 2.0)]
    assert made.second_value.values.tolist() == [0.5, 2.0] and made.wucht.summary["states"] == []
    lines = report(made)
    assert lines[2].startswith(
        "  branch 1     steady states at shift = 0.5, from -0.5 to 10: stable at mu from -0.5 to 10 (0 to "
    )
    assert lines[4:6] == ["  fold         mu = -0.5, shift = 0.5: x = 0", "  fold         mu = -2, shift = 2: x = 0"]


def test_curves_have_their_ranges_and_the_points_where_a_second_condition_holds() -> None:
    """The cusp of x' = mu + shift x - x^3: its folds are at 4 shift^3 = 27 mu^2."""
    subject = UserSystem.from_formulas({"x": "mu + shift*x - x^3"}, {"mu": 0.0, "shift": 0.75})
    keys: dict[str, Any] = {"along": "mu", "range": (-1.0, 1.0), "ranges": {"x": (-2.0, 2.0)}, "points": 1}
    made = run(SpeedCurve(**keys, second="shift", second_range=(-0.5, 1.0)), subject)
    (curve,) = made.wucht.summary["curves"]
    assert curve["of"] == "fold" and curve["second_range"] == [pytest.approx(0.0, abs=1e-8), pytest.approx(1.0)]
    assert curve["range"] == pytest.approx([-np.sqrt(4 / 27), np.sqrt(4 / 27)], rel=1e-6)
    (cusp,) = curve["special_points"]
    assert [cusp[name] for name in ("value", "mu", "second_value", "shift")] == pytest.approx([0.0] * 4, abs=1e-7)
    assert cusp["kind"] == "cusp" and cusp["state"]["x"] == pytest.approx(0.0, abs=1e-4) and cusp["coefficients"]
    assert 4 * made.curve_second.values**3 == pytest.approx(27 * made.curve_value.values**2, abs=1e-8)
    assert made.wucht.summary["second_value"] == 0.75 and "second_value" not in made.wucht.summary["branches"][0]
    assert made.wucht.sentence.endswith("; 2 folds; one curve of them in mu and shift with one cusp")
    at = next(k for k, text in enumerate(report(made)) if text.startswith("  curve"))
    assert report(made)[at].startswith("  curve of folds: mu from -0.3849 to 0.3849, shift from ")
    assert report(made)[at + 1].startswith("    cusp             mu = ")
    plane = draw(made).axes[-1]
    folds, cusp_mark, guide = plane.get_lines()
    assert (folds.get_label(), folds.get_linestyle(), cusp_mark.get_label()) == ("folds", "-", "cusp")
    assert list(guide.get_ydata()) == [0.75, 0.75] and plane.get_ylabel() == "$shift$"


def test_values_of_a_second_parameter_have_the_colours_of_a_scale() -> None:
    """Which differ in grey, too; in the legend they are samples, wider than the lines that show what is stable."""
    (axis, *_) = draw(at_second(0.5, 2.0)).axes
    solid = [one for one in axis.lines if one.get_linestyle() == "-"]
    assert list(dict.fromkeys(one.get_color() for one in solid)) == ["#440154", to_hex(colormaps["viridis"](0.9))]
    assert [one.get_linewidth() for one in axis.get_legend().legend_handles[:2]] == [4.0, 4.0]
    names = [t.get_text() for t in axis.get_legend().get_texts()]
    assert names == ["$shift$ = 0.5", "$shift$ = 2", "stable", "unstable", "fold"]
    legend = axis.get_legend()
    colours = {text.get_text(): one.get_color() for text, one in zip(legend.get_texts(), legend.get_lines(), strict=True)}
    assert colours["stable"] == GREY and " ".join(axis.get_xlabel().split()) == "$\\mu$"
    with_units = draw(at_second(0.5, 2.0).assign_attrs(along_unit="m", second_unit="N")).axes[0].get_legend()
    assert with_units.get_texts()[0].get_text() == "$shift$ = 0.5\N{NO-BREAK SPACE}N"


def test_values_of_the_second_parameter_have_four_digits_or_six_where_those_are_alike() -> None:
    for values, words in (((0.0672888, 0.1), ("0.06729", "0.1")), ((0.0672888, 0.0672911), ("0.0672888", "0.0672911"))):
        texts = draw(at_second(*values)).axes[0].get_legend().get_texts()
        assert [t.get_text() for t in texts[:2]] == [f"$shift$ = {v}" for v in words]


def test_many_values_have_the_colours_of_a_scale_and_some_names() -> None:
    values = [0.5 * k for k in range(9)]
    (axis, *_) = draw(at_second(*values[::-1])).axes
    solid = [one for one in axis.lines if one.get_linestyle() == "-"]
    colours = {round(float(np.max(one.get_ydata())) ** 2 - 10, 6): one.get_color() for one in solid}
    assert sorted(colours) == pytest.approx(values)
    assert colours[0.0] == "#440154" and len(set(colours.values())) == 9
    assert colours[4.0] == to_hex(colormaps["viridis"](0.9))
    names = [t.get_text() for t in axis.get_legend().get_texts()][:7]
    assert names == [f"$shift$ = {v}" for v in ("0", "0.5", "1.5", "2", "2.5", "3.5", "4")]


def test_a_single_branch_gives_what_is_stable_its_colour() -> None:
    (axis, *_) = draw(line()).axes
    legend = axis.get_legend()
    colours = {text.get_text(): one.get_color() for text, one in zip(legend.get_texts(), legend.get_lines(), strict=True)}
    assert colours["stable"] == COLOURS[0] and list(colours) == ["stable", "as it is:\n$\\mu$ = 5"]
    assert axis.get_ylim()[0] == 0 and axis.get_xlim() == (1.0, 10.0)
    assert draw(asked({"x": "-mu - x"})).axes[0].get_ylim()[0] < -8, "what is below zero is drawn"


def test_contacts_that_are_left_out_are_told() -> None:
    ball = {"kind": "pendulum", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.05, "track": "ring", "diameter": 0.01}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-3, "inertia": 0.03},
            *({"name": name} | ball for name in ("p", "q")),
        ],
        "drive": {"on": "drum", "kind": "constant-speed", "speed": 200.0},
    })  # fmt: skip
    made = run(SpeedCurve(along="drive.speed", range=(195.0, 205.0), points=1, only="compensating"), machine)
    assert made.wucht.warnings == ["contacts on the track ring are left out: this holds while its bodies do not touch"]


@cache
def rotor() -> Any:
    asked = SpeedCurve(along="drive.no_load_speed", range=("100 rad/s", "300 rad/s"), points=1)
    return run(asked, load_machine("drozdetskaya-2020/r1"))


def test_a_range_of_two_decades_is_drawn_by_its_logarithm() -> None:
    """Of a machine; of other equations a range is drawn as it is."""
    for made, low, scale in ((rotor(), 3.0, "log"), (rotor(), 3.1, "linear"), (line(), 0.1, "linear")):
        (axis, *_) = draw(made.assign_attrs(low=low)).axes
        assert axis.get_xscale() == scale and axis.get_xlim()[0] == low


def test_the_ratio_to_a_speed_is_drawn_but_where_that_is_prescribed() -> None:
    assert " / " in draw(rotor()).axes[0].get_ylabel()
    prescribed = rotor().assign(speed=rotor().speed.copy(data=rotor().value.values))
    assert " / " not in draw(prescribed).axes[0].get_ylabel()
    assert " / " not in draw(rotor().assign_attrs(along_unit="N")).axes[0].get_ylabel()


def test_amplitudes_have_a_panel_in_their_printed_unit() -> None:
    amplitude = draw(rotor()).axes[1]
    assert amplitude.get_ylabel() == "amplitude of the axis (mm)" and amplitude.get_ylim()[0] == 0
    drawn = np.concatenate([np.asarray(one.get_ydata(), float) for one in amplitude.lines if one.get_linestyle() == "-"])
    stable = rotor().amplitude.values[rotor().stable.values > 0]
    assert drawn.max() == pytest.approx(1e3 * stable.max(), rel=1e-6)


def test_the_states_of_a_rotor_have_units_and_exponents_over_its_angle() -> None:
    """The fastest first, as they are stored; exponents by angle are those by time over the speed."""
    s, lines = rotor().wucht.summary, report(rotor())
    speeds = [state["speed"] for state in s["states"]]
    assert speeds == sorted(speeds, key=lambda w: -abs(w)) == rotor().own_speed.values.tolist()
    for state in s["states"]:
        per_angle = np.array(state["exponents"]) / abs(state["speed"])
        assert np.array(state["exponents_phi"]) == pytest.approx(per_angle)
    (first, *_) = s["states"]
    told = next(text for text in lines if text.startswith(("  stable ", "  unstable ")) and "at drive.no_load_speed" in text)
    assert f"at drive.no_load_speed = 200 rad/s: {first['name']}, speed {first['speed']:.5g} rad/s (" in told
    assert told.partition(", amplitude ")[2].rpartition(" ")[2] in ("mm", "µm")
    assert any(" rad/s (" in text and " rpm) to " in text for text in lines if text.startswith("  branch "))
    assert [text[:15] for text in lines if text.startswith(("  stability", "  left out"))] == [
        "  stability    ",
        "  left out     ",
    ]
