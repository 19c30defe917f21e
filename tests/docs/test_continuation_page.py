"""The page on following one's own equations: its blocks run and print what it says, and that is right by other means."""

from __future__ import annotations

import contextlib
import io
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

pytestmark = pytest.mark.slow  # all commands and blocks of the page are run
TEXT = (Path(__file__).parents[2] / "docs" / "continuation.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"```python\n(.*?)```\n(?:```text\n(.*?)```)?", re.DOTALL)


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Any]:
    """What the page's blocks define, run in order."""
    known: dict[str, Any] = {}
    with contextlib.chdir(tmp_path_factory.mktemp("page")):
        for code, said in BLOCK.findall(TEXT):
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(code, "docs/continuation.md", "exec"), known)
            assert printed.getvalue() == said, code
        assert Path("tank.png").stat().st_size > 10_000
    return known


def temperature(c: float, B: float) -> float:
    return B * c / 4


def damkoehler(c: float, B: float) -> float:
    """At rest, 0 = -c + r and 0 = -4 T + B r."""
    return c * math.exp(-temperature(c, B)) / (1 - c)


def test_equilibria_by_pencil(names: Mapping[str, Any]) -> None:
    """Folds where c (1 - c) = 4/B; Hopf points where the trace of [[-1/(1-c), c], [-B c/(1-c), B c - 4]] vanishes."""
    B = 18.0
    root = math.sqrt(1 / 4 - 4 / B)
    folds = [damkoehler(c, B) for c in (1 / 2 - root, 1 / 2 + root)]
    hopfs = [
        damkoehler(brentq(lambda c: B * c - 4 - 1 / (1 - c), *bracket, xtol=1e-15), B) for bracket in ((0.1, 0.6), (0.6, 0.99))
    ]
    found = {kind: [p.parameter for p in names["branch"].special if p.kind == kind] for kind in ("fold", "hopf")}
    assert found["fold"] == pytest.approx(folds, rel=1e-12)
    assert found["hopf"] == pytest.approx(hopfs, rel=1e-12)
    assert [p.parameter for p in names["special"]] == pytest.approx([p.parameter for p in names["branch"].special], rel=1e-12)
    assert [p.parameter for p in names["hopf"]] == pytest.approx([0.11115348, 0.18383461], rel=5e-8)  # AUTO-07p, demo ab


def test_the_map_by_pencil(names: Mapping[str, Any]) -> None:
    cusp, takens = sorted(names["fold_curve"].special, key=lambda p: p.parameter_values[1])
    assert cusp.unknowns == pytest.approx([1 / 2, 2, math.exp(-2), 16], rel=1e-9)
    # Trace and determinant vanish: c (1 - c) = 4/B and B c - 4 = 1/(1 - c), so 4/(1 - c) - 4 = 1/(1 - c), c = 1/4.
    assert takens.unknowns == pytest.approx([1 / 4, 4 / 3, damkoehler(1 / 4, 64 / 3), 64 / 3], rel=1e-10)
    c, _, D, B = names["hopf_curve"].unknowns
    assert np.abs(B * c - 4 - 1 / (1 - c)).max() < 1e-9
    assert pytest.approx([damkoehler(*each) for each in zip(c, B, strict=True)], rel=1e-9) == D
    assert names["points"][:, 1] == pytest.approx(4 / (names["points"][:, 0] * (1 - names["points"][:, 0])), rel=1e-10)


def rates(_: float, y: np.ndarray, D: float, B: float) -> list[float]:
    r = D * (1 - y[0]) * math.exp(y[1])
    return [-y[0] + r, -4 * y[1] + B * r]


def test_orbits_by_integration(names: Mapping[str, Any]) -> None:
    """SciPy, from a state of the orbit at the fold: it returns there after the period."""
    fold = names["fold"]
    begin = fold.states[:, 0]
    run = solve_ivp(rates, (0, fold.period), begin, args=(fold.parameter, 14.0), rtol=1e-11, atol=1e-12, method="DOP853")
    assert run.y[:, -1] == pytest.approx(begin, abs=1e-6)
    assert abs(fold.logarithms[0]) < 1e-6


def test_the_homoclinic_orbit_by_shooting(names: Mapping[str, Any]) -> None:
    """On one side of it the saddle's unstable manifold comes round within its stable one, on the other side outside."""
    c = brentq(lambda c: damkoehler(c, 18.0) - names["end"].parameter, 1 / 3, 2 / 3, xtol=1e-15)
    assert names["end"].equilibrium == pytest.approx([c, temperature(c, 18.0)], rel=1e-6)
    goes = [_runs_away(names["end"].parameter + d) for d in (-1e-8, 1e-8)]
    assert goes[0] != goes[1]


def _runs_away(D: float) -> bool:
    """Whether the unstable manifold of the saddle, begun towards lower temperatures, comes to burn."""
    B = 18.0
    c = brentq(lambda c: damkoehler(c, B) - D, 1 / 3, 2 / 3, xtol=1e-16)
    x = np.array([c, temperature(c, B)])
    matrix = np.array([[-1 / (1 - c), c], [-B * c / (1 - c), B * c - 4]])
    values, vectors = np.linalg.eig(matrix)
    out = vectors[:, values.argmax()]
    begin = x - 1e-6 * out * np.sign(out[1])

    def hot(_: float, y: np.ndarray, *__: float) -> float:
        return float(y[1]) - 3.0

    hot.terminal = True  # type: ignore[attr-defined]
    run = solve_ivp(rates, (0, 80), begin, args=(D, B), rtol=1e-11, atol=1e-13, events=hot)
    return bool(len(run.t_events[0]))


def test_bratu_by_closed_form(names: Mapping[str, Any]) -> None:
    """u(1/2) = 2 ln cosh(theta/4), theta = sqrt(2 lambda) cosh(theta/4); at the fold (theta/4) tanh(theta/4) = 1."""
    one, fold, other = names["wanted"]
    for s, bracket in ((one, (1.0, 2.0)), (other, (8.0, 14.0))):
        theta = brentq(lambda t: t - math.sqrt(2) * math.cosh(t / 4), *bracket, xtol=1e-14)
        assert s.states_at([0.5])[0, 0] == pytest.approx(2 * math.log(math.cosh(theta / 4)), abs=1e-9)
    quarter = brentq(lambda t: t * math.tanh(t) - 1, 1.0, 1.5, xtol=1e-15)
    assert fold.parameter_values[0] == pytest.approx(8 * (quarter / math.cosh(quarter)) ** 2, abs=1e-9)


def test_the_circuit_by_its_eigenvalues(names: Mapping[str, Any]) -> None:
    """More of it, by shooting: tests/numerics/periodic/test_connection_curves.py."""
    focus, neutral = names["met"]
    for c, check in ((focus, lambda e: abs(e[1] - e[2]) ** 2), (neutral, lambda e: (e[0] + e[1]).real)):
        nu, be = c.parameter_values
        matrix = [[-(be + nu) / 0.6, be / 0.6, 0.0], [be, -be, -1.0], [0.0, 1.0, 0.0]]
        eigenvalues = np.linalg.eigvals(matrix)
        assert check(eigenvalues[np.argsort(-eigenvalues.real)]) == pytest.approx(0.0, abs=1e-8)


def test_where_the_symmetry_breaks(names: Mapping[str, Any]) -> None:
    """Where one tank's Jacobian has an eigenvalue 2 k: what differs between both tanks grows then."""
    for p in names["crossings"]:
        c, B = p.x[0], 18.0
        matrix = np.array([[-1 / (1 - c), c], [-B * c / (1 - c), B * c - 4]])
        assert np.linalg.det(matrix - 0.6 * np.eye(2)) == pytest.approx(0, abs=1e-8)
        assert p.x[:2] == pytest.approx(p.x[2:], abs=1e-9)
    residuals = names["twins"].equations.values(np.array([p.unknowns for p in names["unequal"]]).T)[0]
    assert np.abs(residuals).max() < 1e-10
