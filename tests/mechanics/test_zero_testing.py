"""Whether an expression is zero: identities that expanding does not see, and near misses that are none."""

import pytest
import sympy as sp

from wucht.mechanics.zero_testing import is_cancelled_sum, is_identically_zero

a, b = sp.symbols("a b", real=True)
p, q = sp.symbols("p q", positive=True)


@pytest.mark.parametrize(
    "expression",
    [
        (a**2 - b**2) / (a - b) - (a + b),
        1 / (1 / a + 1 / b) - a * b / (a + b),
        sp.sqrt(a**2 + 2 * a * b + b**2) - sp.Abs(a + b),
        sp.sin(a) ** 2 + sp.cos(a) ** 2 - 1,
        sp.sqrt(5 + 2 * sp.sqrt(6)) - sp.sqrt(2) - sp.sqrt(3),
        a - a * (sp.cos(1) ** 2 + sp.sin(1) ** 2),  # its atoms are rational, it is no rational polynomial
        sp.log(p * q) - sp.log(p) - sp.log(q),
    ],
)
def test_identities(expression):
    assert is_identically_zero(expression)


@pytest.mark.parametrize(
    "expression",
    [
        a - b,
        sp.sqrt(a**2 + 2 * a * b + b**2) - (a + b),  # zero where a + b > 0 only
        sp.sqrt(2) - sp.Rational(14142, 10000),
        sp.sin(a) - a + a**3 / 6,
        1 + sp.Rational(1, 10**15) - a / a,
        sp.Function("f")(a),
    ],
)
def test_what_is_zero_somewhere_or_nearly_is_not_zero(expression):
    assert not is_identically_zero(expression)


@pytest.mark.parametrize(
    "w, v, expected",
    [
        (100 * sp.pi, -sp.Rational("314.159265358979"), True),  # a decimal number's 15 digits
        (100 * sp.pi * a, -sp.Rational("314.159265358979") * a, True),
        (sp.sqrt(2), -sp.Rational("1.41421356237"), False),
        (sp.Integer(3), sp.Integer(-3), True),
        (sp.Integer(3), -sp.sqrt(2), False),
        (a, -b, False),
    ],
)
def test_frequencies_that_cancel(w, v, expected):
    assert is_cancelled_sum(w, v, sp.expand(w + v)) is expected
