"""A System refuses what would make a name or a symbol stand for two things."""

import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.system import TIME, Output, System, needed_definitions, substitute_definitions

x, y, a, d = sp.symbols("x y a d", real=True)


@pytest.mark.parametrize(
    "arguments, refusal",
    [
        ({"states": (x, x), "derivatives": (x, x)}, rejected("name-twice", "x")),
        ({"states": (x,), "derivatives": (x,), "parameters": (sp.Symbol("x"),)}, rejected("name-twice", "x")),
        ({"states": (sp.Symbol("t"),), "derivatives": (sp.S.One,)}, rejected("time-taken", "t")),
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


TWO = System(
    states=(x, y),
    derivatives=(y, d - a * x),
    parameters=(a, sp.Symbol("k", real=True)),
    definitions=((sp.Symbol("c", real=True), 2 * x), (d, sp.Symbol("c", real=True) ** 2 + y)),
    outputs=(Output("force", d), Output("place", 3 * x)),
    quadratures=(Output("work", d * y, jump=x),),
    angles=frozenset({x}),
)


def test_definitions_within_definitions_are_put_in():
    assert sp.expand(TWO.explicit(d - a * x) - (4 * x**2 + y - a * x)) == 0
    assert TWO.explicit(a * x) == a * x


def test_only_definitions_that_are_used_are_needed_in_their_order():
    b, c, e = sp.symbols("b c e", real=True)
    definitions = ((b, x), (c, b + 1), (d, y), (e, 2 * c))
    assert needed_definitions(definitions, [e]) == [(b, x), (c, b + 1), (e, 2 * c)]
    assert needed_definitions(definitions, [c * d]) == [(b, x), (c, b + 1), (d, y)]
    assert needed_definitions(definitions, [x]) == []
    assert substitute_definitions(e + d, definitions) == 2 * (x + 1) + y


@pytest.mark.parametrize(
    ("place", "refusal"),
    [
        ({"definitions": ((d, a), (a, x))}, rejected("unknown-symbol", "d", "a")),
        ({"definitions": ((x, a),), "parameters": (a,)}, rejected("defined-twice", "x")),
        ({"outputs": (Output("p", y),)}, rejected("unknown-symbol", "p", "y")),
        ({"quadratures": (Output("p", x, jump=y),)}, rejected("unknown-symbol", "p", "y")),
    ],
)
def test_every_place_is_searched_for_what_is_not_known(place, refusal):
    with refusal:
        System((x,), (x,), **place)


def test_an_output_or_a_quadrature_by_its_name():
    assert [TWO.output(n).expression for n in ("place", "force", "work")] == [3 * x, d, d * y]
    with pytest.raises(KeyError):
        TWO.output("power")
