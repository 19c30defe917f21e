"""What a speed curve states of equations with a closed form: sentences, lines, tables, and what is drawn of them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.interrupting import stop_at

from wucht import SpeedCurve, UserSystem, draw, load_machine, report, run
from wucht.files.building import machine_from
from wucht.plots.style import COLOURS


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
    both = asked({"x": "x^2 - mu^2"}).wucht.sentence
    assert both == "2 branches of steady states, 1 of them stable somewhere; no special point"
    saddles = asked({"x": "x^2 - mu^2", "y": "y"}).wucht.sentence
    assert saddles == "2 branches of steady states, none of them stable anywhere; no special point"
    assert line(ranges={"x": (50.0, 60.0)}).wucht.sentence == "no steady states were found, between mu = 1 and 10"


def test_what_is_not_finished_is_told() -> None:
    begun = line(progress=stop_at(2, "searching at"))
    assert "one branch is followed; the search is not finished" in begun.wucht.warnings
    none = line(ranges={"x": (50.0, 60.0)}, progress=stop_at(2, "searching at"))
    assert none.wucht.sentence == "the study was interrupted before the first branch"
    assert "0 branches are followed; the search is not finished" in none.wucht.warnings


def test_the_lines_of_a_report() -> None:
    assert report(line())[2:4] == [
        "  branch 1     steady states, from 1 to 10: stable at mu from 1 to 10 (1 to 10)", "  stable       at mu = 5: x = 5",
    ]  # fmt: skip
    (warning,) = line().wucht.warnings
    assert warning.startswith("it is not proved that all states are known: deflated Newton's method from 64 starts")
    unstable = report(asked({"x": "x - mu"}))
    assert unstable[2].endswith(": nowhere stable") and unstable[3] == "  unstable     at mu = 5: x = 5"
    ends = report(asked({"x": "mu - x - 1e-3*x^3"}, (1.0, 2000.0), ranges={"x": (-1.0, 1.0)}))
    assert ends[3].startswith("               its end: x passes ")
    many = report(at_second(*(0.25 * k for k in range(18))))
    assert many[18] == "  and 2 more branches" and many[35] == "  and 2 more special points: see the Dataset"


def test_of_a_hopf_point_the_frequency_is_told() -> None:
    """Of the pair that grows there; another pair oscillates faster."""
    made = asked({"x": "(mu - 2)*x - 3*y", "y": "3*x + (mu - 2)*y", "u": "-5*u - 7*v", "v": "7*u - 5*v"})
    (point,) = made.wucht.summary["special_points"]
    assert (point["kind"], point["value"]) == ("hopf", pytest.approx(2.0)) and point["frequency"] == pytest.approx(3.0)
    assert report(made)[3] == "  hopf         mu = 2: x = 0, oscillation with 3"
    assert np.unique(made.unstable.values[made.at_special.values == 0]).tolist() == [0, 2]
    (own,) = made.wucht.summary["states"]
    exponents = np.array([[3, 3], [3, -3], [-5, 7], [-5, -7]], float)
    assert not own["stable"] and np.array(own["exponents"]) == pytest.approx(exponents)
    assert made.own_growth.values == pytest.approx([3.0]) and made.own_stable.values.tolist() == [0]


def test_branches_at_values_of_the_second_parameter_state_them() -> None:
    made = at_second(0.5, 2.0)
    assert [b["shift"] for b in made.wucht.summary["branches"]] == [0.5, 2.0]
    assert [(p["shift"], p["second_value"]) for p in made.wucht.summary["special_points"]] == [(0.5, 0.5), (2.0, 2.0)]
    assert made.second_value.values.tolist() == [0.5, 2.0] and made.wucht.summary["states"] == []
    assert "  fold         mu = -0.5, shift = 0.5: x = 0" in report(made)


def test_curves_have_their_ranges_and_the_points_where_a_second_condition_holds() -> None:
    """The cusp of x' = mu - 0.3 + (shift - 0.6) x - x^3: its folds are at 4 (shift - 0.6)^3 = 27 (mu - 0.3)^2."""
    subject = UserSystem.from_formulas({"x": "mu - 0.3 + (shift - 0.6)*x - x^3"}, {"mu": 0.3, "shift": 1.35})
    keys: dict[str, Any] = {"along": "mu", "range": (-0.7, 1.3), "ranges": {"x": (-2.0, 2.0)}, "points": 1}
    made = run(SpeedCurve(**keys, second="shift", second_range=(0.1, 1.6)), subject)
    (curve,) = made.wucht.summary["curves"]
    assert curve["of"] == "fold" and curve["second_range"] == [pytest.approx(0.6, abs=1e-8), pytest.approx(1.6)]
    assert curve["range"] == pytest.approx([0.3 - np.sqrt(4 / 27), 0.3 + np.sqrt(4 / 27)], rel=1e-6)
    (cusp,) = curve["special_points"]
    assert [cusp[name] for name in ("value", "mu", "second_value", "shift")] == pytest.approx([0.3, 0.3, 0.6, 0.6], abs=1e-7)
    assert cusp["kind"] == "cusp" and cusp["state"]["x"] == pytest.approx(0.0, abs=1e-4) and cusp["coefficients"]
    assert 4 * (made.curve_second.values - 0.6) ** 3 == pytest.approx(27 * (made.curve_value.values - 0.3) ** 2, abs=1e-8)
    assert made.wucht.summary["second_value"] == 1.35 and "second_value" not in made.wucht.summary["branches"][0]
    assert made.wucht.sentence.endswith("; 2 folds; one curve of them in mu and shift with one cusp")
    plane = draw(made).axes[-1]
    _, mark, guide = plane.get_lines()
    assert (mark.get_xdata(), mark.get_ydata()) == (pytest.approx([0.3], abs=1e-6), pytest.approx([0.6], abs=1e-6))
    assert list(guide.get_ydata()) == [1.35, 1.35] and plane.get_ylabel() == "$shift$"


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
    """The compensating state of a rotor without friction runs at the no-load speed."""
    axis, amplitude, *_ = draw(rotor()).axes
    assert " / " in axis.get_ylabel() and amplitude.get_ylabel() == "amplitude of the axis (mm)"
    (level,) = [one for one in axis.lines if one.get_color() == COLOURS[2] and one.get_linestyle() == "-"]
    assert np.asarray(level.get_ydata()) == pytest.approx(1.0, abs=1e-9)
    prescribed = rotor().assign(speed=rotor().speed.copy(data=rotor().value.values))
    assert " / " not in draw(prescribed).axes[0].get_ylabel()
    assert " / " not in draw(rotor().assign_attrs(along_unit="N")).axes[0].get_ylabel()


def test_the_states_of_a_rotor_have_units_and_exponents_over_its_angle() -> None:
    """The fastest first, as they are stored; exponents by angle are those by time over the speed."""
    states = rotor().wucht.summary["states"]
    speeds = [state["speed"] for state in states]
    assert speeds == sorted(speeds, key=lambda w: -abs(w)) == rotor().own_speed.values.tolist()
    for state in states:
        per_angle = np.array(state["exponents"]) / abs(state["speed"])
        assert np.array(state["exponents_phi"]) == pytest.approx(per_angle)
    told = next(text for text in report(rotor()) if text.startswith(("  stable ", "  unstable ")) and "no_load_speed" in text)
    assert f": {states[0]['name']}, speed {speeds[0]:.5g} rad/s (" in told
    assert told.partition(", amplitude ")[2].rpartition(" ")[2] in ("mm", "µm")


def test_a_curve_is_smooth_at_its_fold() -> None:
    """Near the fold of x' = mu + x^2 the lines that are drawn lie on x^2 = -mu."""
    drawn = draw(asked({"x": "mu + shift + x^2"}, (-1.0, 1.0), ranges={"x": (-2.0, 2.0)})).axes[0]
    lines = [one for one in drawn.lines if len(one.get_xdata()) > 20]
    assert len(lines) == 2
    for one in lines:
        assert np.asarray(one.get_ydata()) ** 2 == pytest.approx(-np.asarray(one.get_xdata()), abs=2e-4)


def test_stable_is_solid_and_unstable_dashed() -> None:
    """Table 5.1 of 002: type I stable, type III unstable, type II stable up to its fold, cases.md."""
    made = run(SpeedCurve(along="u", range=(0.5, 8.0)), load_machine("drozdetskaya-2020/table-5.1"))
    lines = [one for one in draw(made).axes[0].lines if one.get_linestyle() not in ("None", ":")]
    drawn = {(COLOURS.index(one.get_color()), one.get_linestyle() == "-") for one in lines if one.get_color() in COLOURS}
    assert {(0, True), (0, False), (1, False), (2, True)} <= drawn and not {(1, True), (2, False)} & drawn
    solid = [one for one in lines if one.get_color() == COLOURS[0] and one.get_linestyle() == "-"]
    assert max(x for one in solid for x in one.get_xdata()) == pytest.approx(1.8331080, abs=1e-6)


def test_many_values_have_the_colours_of_a_scale_and_some_names() -> None:
    values = [0.5 * k for k in range(9)]
    (axis, *_) = draw(at_second(*values[::-1])).axes
    solid = [one for one in axis.lines if one.get_linestyle() == "-"]
    colours = {round(float(np.max(one.get_ydata())) ** 2 - 10, 6): one.get_color() for one in solid}
    assert sorted(colours) == pytest.approx(values) and len(set(colours.values())) == 9
    names = [t.get_text() for t in axis.get_legend().get_texts()][:7]
    assert names == [f"$shift$ = {v}" for v in ("0", "0.5", "1.5", "2", "2.5", "3.5", "4")]
