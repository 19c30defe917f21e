"""Programs as JavaScript: the numbers of Python, each repeated expression once, no name of a file in the code."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import sympy as sp
from tests.node import run_in_node

from wucht.errors import RunError
from wucht.numerics.flow.javascript import javascript_code, missing_functions
from wucht.numerics.flow.program import lower
from wucht.piecewise import ABSOLUTE, PiecewiseCubic
from wucht.system import TIME, System

x, y, k, m = sp.symbols("x y k m", real=True)
EXPRESSIONS = [
    x, -x, 2 * x - y, -x - y, k * x / m, -k * x / (m * (y**2 + 1)), x**2 - y**3, (x + y) ** 5, 1 / x, 1 / (x + y) ** 2,
    (x**2 + 1) ** sp.Rational(-1, 2), sp.sqrt(x**2 + y**2 + k), (x**2 + 1) ** sp.Rational(7, 3), (y**2 + 1) ** k, x**11,
    sp.sin(x) * sp.cos(x), sp.sin(2 * x) - sp.cos(x - y) ** 2, sp.tan(x), sp.exp(-x * y), sp.log(x**2 + m), sp.sinh(x),
    sp.cosh(y), sp.tanh(k * x), sp.atan(x), sp.asin(sp.sin(x) / 2), sp.acos(sp.cos(y) / 2), sp.atan2(y, -x), sp.Abs(x - y),
    sp.pi * x - sp.Rational(1, 3), -sp.Float(2.5) * x * y, x - (y - (x - k * (y - m))), -(x + y) * -(x - y) / -m,
    TIME * x - TIME, k**2 - m, sp.S.Zero, sp.Float(1e-300) * x, -(k + m) * x - (k + m) * y,
]  # fmt: skip


def test_numbers_are_those_of_python() -> None:
    program = lower(System((x, y), (y, x), (k, m)), EXPRESSIONS)
    generator = np.random.default_rng(38)
    points = [generator.uniform(-2.0, 2.0, 3).tolist() + generator.uniform(0.5, 2.0, 2).tolist() for _ in range(50)]
    script = f"""const code = {javascript_code(program)};
        const rows = {json.dumps(points)}.map(([t, x, y, k, m]) => {{
            const constants = new Float64Array(code.constantCount), results = new Float64Array({len(EXPRESSIONS)});
            code.constants([k, m], constants);
            code.values(t, [x, y], constants, results);
            return [...results];
        }});
        console.log(JSON.stringify(rows));"""
    rows = json.loads(run_in_node("-e", script))
    function = program.function("math")
    for (time, *state, stiffness, mass), values in zip(points, rows, strict=True):
        expected = function(state, time, program.constant_values([stiffness, mass]).tolist())
        assert values == pytest.approx(expected, rel=1e-12, abs=1e-300)


def test_a_sine_that_is_needed_often_is_computed_once() -> None:
    results = [sp.sin(x) * y, sp.sin(x) ** 2 + sp.cos(x), k * sp.cos(x) / (1 + sp.sin(x))]
    code = javascript_code(lower(System((x, y), (y, x), (k,)), results))
    assert (code.count("Math.sin("), code.count("Math.cos(")) == (1, 1)


def test_no_name_of_a_file_is_in_the_code() -> None:
    state, velocity, stiffness = (sp.Symbol(name, real=True) for name in ("x]; process.exit(1) //", "'v", "k</script>"))
    energy = sp.Symbol("`energy", real=True)
    system = System((state, velocity), (velocity, -energy), (stiffness,), ((energy, stiffness * state**2),))
    code = javascript_code(lower(system, [velocity, -energy]))
    words = set(re.findall(r"[A-Za-z_]\w*", code))
    assert words <= {"constantCount", "constants", "values", "t", "x", "p", "c", "r", "const", "v0", "v1"}
    assert not set(code) & set("\"'`<#$@\\")


def test_what_javascript_lacks_is_refused() -> None:
    system = System((x, y), (y, x), (k,))
    assert missing_functions([sp.gamma(x) + PiecewiseCubic(x, ABSOLUTE), sp.sin(sp.erf(y))]) == ["erf", "gamma"]
    with pytest.raises(RunError, match="JavaScript has no function 'gamma'"):
        javascript_code(lower(system, [sp.gamma(x)]))
    with pytest.raises(RunError, match="not finite"):
        javascript_code(lower(system, [x + sp.Float("inf")]))
