"""The table [system]: formulas mean what they mean on paper, and what is wrong is one sentence with file and key."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sympy as sp
from tests import refusals
from tests.refusals import rejected

from wucht.errors import InputError
from wucht.files.catalogue import load_equations
from wucht.files.formulas import formula
from wucht.files.user_system import UserSystem, equations_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import System

NAMES = {n: sp.Symbol(n, real=True) for n in ("x", "y", "lambda")}
TABLE: dict[str, Any] = {"states": {"x": "mu*x - x^3 - y", "y": "x"}, "parameters": {"mu": 0.5}}
KIND = 'kind = "phase-portrait"'
FILE = """\
title = "t"
[system]
states = { x = "mu*x - x^3 - y", y = "x" }
parameters = { mu = 0.5 }
[study]
kind = "phase-portrait"
"""


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("-x^2", -4.0),
        ("2^-2", 0.25),
        ("2^3^2", 512.0),
        ("2*-x", -4.0),
        ("lambda*x", 10.0),
        ("atan2(y, x)", math.atan2(3, 2)),
        ("max(x, y) - min(x, y)", 1.0),
        ("sign(x - y)", -1.0),
        ("exp(log(x))", 2.0),
        ("sin(pi*x/4)", 1.0),
    ],
)
def test_a_formula_means_what_it_means_on_paper(written: object, value: float) -> None:
    at = {NAMES["x"]: 2.0, NAMES["y"]: 3.0, NAMES["lambda"]: 5.0}
    assert float(formula(written, NAMES, "k").subs(at)) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("written", "says"),
    [
        ("2x", "an operator is missing before 'x' at character 2; a product is written with *"),
        ("x +", "it ends too early"),
        ("(x + 1", "the '(' at character 1 is not closed"),
        ("x)", "there is no '(' that matches the ')' at character 2"),
        ("x(2)", "x is not a function; a product is written with *"),
        ("sine(x)", "unknown function 'sine'; did you mean 'sin'?"),
        ("sin(x, y)", "sin has one argument, not 2"),
        ("atan2(x)", "atan2 has 2 arguments, not 1"),
        ("lamda*x", "unknown name 'lamda'; did you mean 'lambda'?"),
        ("x/0", "it divides by zero"),
        ("1e300*x", "a number in it is beyond 1e+30"),
        ("1e20*1e20*x", "a number in it is beyond 1e+30"),
        ("__import__('os').system('ls')", "is not allowed in a formula"),
        ("x.__class__", "'.' at character 2 is not allowed in a formula"),
        ("(" * 200 + "x" + ")" * 200, "more than 60 brackets or signs are nested"),
    ],
)
def test_what_is_no_formula_is_refused(written: object, says: str) -> None:
    with pytest.raises(InputError) as caught:
        formula(written, NAMES, "system.states.x")
    assert says in str(caught.value)
    assert str(caught.value).startswith("system.states.x: given")


@pytest.mark.parametrize(
    ("changes", "where", "says"),
    [
        ({"states": {}}, "system.states", "must be a table of derivatives"),
        ({"state": {}}, "system.state", "unknown key; did you mean 'states'?"),
        ({"states": {"t": "1"}}, "system.states.t", "t is the time"),
        ({"states": {"sin": "1"}}, "system.states.sin", "sin is a function of formulas"),
        ({"angles": ["z"]}, "system.angles", "unknown state"),
        ({"angles": "x"}, "system.angles", "must be a list of states"),
        ({"definitions": {"a": "b", "b": "x"}}, "system.definitions.a", "uses b, which is defined only after it"),
        ({"definitions": {"a": "a + 1"}}, "system.definitions.a", "uses itself"),
    ],
)
def test_what_is_wrong_in_the_table_is_told(changes: dict[str, Any], where: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        equations_from({**TABLE, **changes})
    assert str(caught.value).startswith(f"{where}:")
    assert says in str(caught.value)


def test_the_equations_have_names_angles_and_values() -> None:
    table = {
        "states": {"theta": "omega", "omega": "-k*s - c*omega"}, "angles": ["theta"],
        "parameters": {"k": 4, "c": 0.1}, "definitions": {"s": "sin(theta)"}, "set": {"c": 0.2},
    }  # fmt: skip
    own = equations_from(table, "pendulum")
    s = own.system
    assert (s.state_names, s.parameter_names, own.title, own.values) == (
        ("theta", "omega"), ("k", "c"), "pendulum", {"k": 4.0, "c": 0.2},
    )  # fmt: skip
    assert [a.name for a in s.angles] == ["theta"]
    assert own.with_values({"k": 9.0}).values == {"k": 9.0, "c": 0.2}
    assert own.parameters["k"].value == 4.0
    with rejected("no-value", "k"):
        UserSystem(s, {"c": 1.0})
    with rejected("unknown-parameter", "d"):
        own.with_values({"d": 1.0})


def test_kinks_are_met_exactly() -> None:
    """x' = |x - 1| + 1 from 0: 2 - x decays to 1 in ln 2, then x grows exponentially; the integral of |t - 1| to 2 is 1."""
    own = equations_from({"states": {"x": "abs(x - 1) + 1", "y": "abs(t - 1)"}})
    for engine in ("compiled", "radau"):
        run = integrate(compile_system(own.system, engine=engine), [0.0, 0.0], {}, [0.0, math.log(2), 2.0])
        assert run.failure is None
        x, y = run.states[:, -1]
        assert y == pytest.approx(1.0, abs=1e-11)
        assert (run.states[0, 1], x) == (pytest.approx(1.0, abs=1e-11), pytest.approx(math.exp(2 - math.log(2)), rel=1e-10))


def test_another_file_is_used_with_values_set(here: Path) -> None:
    Path("first.toml").write_text(FILE)
    Path("second.toml").write_text('[system]\nuse = "first.toml"\nset = { mu = 2 }\ntitle = "second"\n')
    assert load_equations("first.toml").values == {"mu": 0.5}
    second = load_equations("second.toml")
    assert (second.values, second.title) == ({"mu": 2.0}, "second")
    assert load_equations("second.toml", {"mu": 3}).values == {"mu": 3.0}
    assert load_equations("drozdetskaya-2020/figure-2.13", {"mu": 1.2}).values == {"mu": 1.2}
    assert second.system == load_equations("first.toml").system


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("[study]", "[machine]\n[study]"), "study.toml: system: a study has one subject"),
        (('y = "x" }', 'y = "x", z = "x" }'), "study.ranges.x: this key is missing"),
        (('y = "x" }', 'y = "x*t" }'), "study.toml: system: these equations depend on time"),
        ((KIND, 'along = "nu"\nvalues = [1]'), "study.along: given 'nu'; unknown parameter"),
        ((KIND, "ranges = { x = [1, 0] }"), "must be a pair [low, high] with low below"),
        ((KIND, "trajectories = [{ x = 1 }]"), "study.trajectories[0].y: this key is missing"),
    ],
)
def test_bad_files(here: Path, refused: Callable[..., str], change: tuple[str, str], says: str) -> None:
    old, new = change
    assert old in FILE
    Path("study.toml").write_text(FILE.replace(old, f"{KIND}\n{new}" if old == KIND else new, 1))
    refused("run", "study.toml", says=(says,))


def test_a_system_of_python_is_asked_too() -> None:
    import wucht

    x, y = sp.symbols("x y", real=True)
    own = wucht.UserSystem(System((x, y), (y, -x)), {}, "spring")
    result = wucht.run(wucht.PhasePortrait(trajectories=0, ranges={"x": (-1, 1), "y": (-1, 1)}), own)
    assert result.wucht.summary["fixed_points"][0]["kind"] == "centre"
    with refusals.refused("machine", "wucht.UserSystem", given=3):
        wucht.run(wucht.PhasePortrait(), 3)


@pytest.mark.parametrize(
    ("states", "wrong"),
    [({"x": "x", "y": "-y"}, "x"), ({"x": "sin(x/2)", "y": "-y"}, "x"), ({"x": "y", "y": "x - sin(x)"}, "y"),
     ({"x": "sin(x/2)^2", "y": "-y"}, ""), ({"x": "y", "y": "sin(3*x) - y"}, "")],
)  # fmt: skip
def test_an_angle_is_the_same_after_a_turn(states: dict[str, str], wrong: str) -> None:
    """wrong: the state whose derivative is another one after a turn."""
    described = {"states": states, "angles": ["x"]}
    if not wrong:
        assert equations_from(described).system.angles
        return
    with refusals.refused("system.angles", f"derivative of {wrong}", given="x"):
        equations_from(described)


def test_set_and_print(here: Path, wucht: Callable[..., Any], refused: Callable[..., str]) -> None:
    Path("study.toml").write_text(FILE)
    shown = wucht("equations", "study.toml", "--set", "mu=0.25").out
    assert "x' = mu*x - x**3 - y" in shown and "mu = 0.25" in shown
    assert "\\dot{x} &= \\mu x" in wucht("equations", "study.toml", "--latex").out
    refused("equations", "study.toml", "--slow", says=("allowed only for a machine",))
