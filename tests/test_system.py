"""A System refuses what would make a name or a symbol stand for two things."""

import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.system import TIME, Output, System

x, y, a, d = sp.symbols("x y a d", real=True)


@pytest.mark.parametrize(
    "arguments, refusal",
    [
        ({"states": (x, x), "derivatives": (x, x)}, rejected("name-twice", "x")),
        ({"states": (x,), "derivatives": (x,), "parameters": (a, a)}, rejected("name-twice")),
        ({"states": (x,), "derivatives": (x,), "parameters": (x,)}, rejected("name-twice", "x")),
        ({"states": (x,), "derivatives": (x,), "parameters": (sp.Symbol("x"),)}, rejected("name-twice", "x")),
        ({"states": (TIME,), "derivatives": (TIME,)}, rejected("time-taken", "t")),
        ({"states": (sp.Symbol("t"),), "derivatives": (sp.S.One,)}, rejected("time-taken", "t")),
        ({"states": (x,), "derivatives": (x,), "outputs": (Output("p", x), Output("p", 2 * x))}, rejected("name-twice", "p")),
        (
            {"states": (x,), "derivatives": (x,), "outputs": (Output("p", x),), "quadratures": (Output("p", x),)},
            rejected("name-twice", "p"),
        ),
        ({"states": (x,), "derivatives": (x,), "definitions": ((d, x), (d, x))}, rejected("defined-twice", "d")),
        ({"states": (x,), "derivatives": (x, x)}, rejected("count", "1", "2")),
        ({"states": (x,), "derivatives": (y,)}, rejected("unknown-symbol", "x", "y")),
        ({"states": (x,), "derivatives": (x,), "angles": frozenset({y})}, rejected("no-angle")),
    ],
)
def test_what_is_not_one_system_is_refused(arguments, refusal):
    with refusal:
        System(**arguments)


def test_time_may_occur_in_a_definition_alone():
    forced = sp.Symbol("f", real=True)
    assert System((x,), (x + forced,), definitions=((forced, sp.sin(TIME)),)).depends_on_time
    assert System((x,), (x * TIME,)).depends_on_time
    assert not System((x,), (x + forced,), definitions=((forced, x**2),)).depends_on_time
