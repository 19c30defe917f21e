"""A System refuses what would make a name or a symbol stand for two things."""

import pytest
import sympy as sp
from pytest import raises

from wucht.errors import WuchtError
from wucht.system import TIME, Output, System

x, y, a, d = sp.symbols("x y a d", real=True)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"states": (x, x), "derivatives": (x, x)}, "two times a state or parameter of the name x"),
        ({"states": (x,), "derivatives": (x,), "parameters": (a, a)}, "name a"),
        ({"states": (x,), "derivatives": (x,), "parameters": (x,)}, "name x"),
        ({"states": (x,), "derivatives": (x,), "parameters": (sp.Symbol("x"),)}, "name x"),
        ({"states": (TIME,), "derivatives": (TIME,)}, "t is the time"),
        ({"states": (sp.Symbol("t"),), "derivatives": (sp.S.One,)}, "t is the time"),
        ({"states": (x,), "derivatives": (x,), "outputs": (Output("p", x), Output("p", 2 * x))}, "output or quadrature .* p"),
        ({"states": (x,), "derivatives": (x,), "outputs": (Output("p", x),), "quadratures": (Output("p", x),)}, "name p"),
        ({"states": (x,), "derivatives": (x,), "definitions": ((d, x), (d, x))}, "d is defined twice"),
        ({"states": (x,), "derivatives": (x, x)}, "1 states but 2 derivatives"),
        ({"states": (x,), "derivatives": (y,)}, "the derivative of x uses y"),
        ({"states": (x,), "derivatives": (x,), "angles": frozenset({y})}, "are no states"),
    ],
)
def test_what_is_not_one_system_is_refused(arguments, sentence):
    with raises(WuchtError, match=sentence):
        System(**arguments)
