"""O. Drozdetskaya, dissertation, KIT Karlsruhe 2020, end of section 5.2 and chapter 7: how does the modulated motion disappear?

At a saddle-node on the orbit or at a saddle connection: where does the one change into the other? Table 5.1, the pendulums
together.

The curves of the study ``stability-map`` are solutions of boundary value problems. Here they are met by integration alone: the
orbit that leaves a saddle-node is followed, and by bisection over beta_r that one is found which arrives at the other end.
What passes a saddle-node closely seems to rest for a long time, so that the root depends on how long is waited: that of the
first curve is 1.021236, 1.020859, 1.0208246, 1.0208234 after 3e5, 3e6, 3e7, 3e8; that of the point 0.386996, 0.386406,
0.386357 after the first three.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

from wucht import StabilityMap, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.sections import section_of
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.orbit_endings import OrbitEnding, ending_at
from wucht.files.catalogue import load_machine
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.recurrence import is_at_rest
from wucht.studies.study_file import read_study

DOUBLE = (0.3863518, 0.06728885, 3.6873885)  # beta_r, sigma, u where the three regions meet
ONCE, HALF = 3 * np.pi, 4.0  # back at the saddle-node psi has fallen by 2 pi, at the upper one by 1.77
LOWER, UPPER = (4.62, 0.84), (2.845, 1.468)  # psi, omega near the folds u1*, u2*


@cache
def _planar() -> tuple[Any, dict[str, float]]:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    made = section_of(averaged_equations_of(machine, False), True)
    return made.system, dict(machine.values)


@cache
def _equations() -> EquilibriumEquations:
    system, values = _planar()
    fixed = {n: v for n, v in values.items() if n not in ("u", "beta_r", "sigma")}
    return EquilibriumEquations.from_system(system, ("u", "beta_r", "sigma"), fixed)


def _fold(near: tuple[float, float], u: float, sigma: float) -> np.ndarray:
    """psi, omega, u of a fold: it does not depend on beta_r."""

    def conditions(z: np.ndarray) -> np.ndarray:
        f, derivatives = _equations().values(np.array([*z, 0.1, sigma]))
        return np.array([*f, np.linalg.det(derivatives[:, :2])])

    return np.asarray(fsolve(conditions, [*near, u], xtol=1e-13))


def _leaving(fold: np.ndarray, beta_r: float, sigma: float, distance: float = 2e-3) -> list[float]:
    """A state beside a saddle-node, on the side on which it is left: psi falls."""
    derivatives = _equations().values(np.array([*fold, beta_r, sigma]))[1][:, :2]
    values, vectors = np.linalg.eig(derivatives)
    v = vectors[:, np.abs(values).argmin()].real
    return list(fold[:2] - distance * v * np.sign(v[0]))


def _arrives(fold: np.ndarray, beta_r: float, sigma: float, angle: float, until: float = 3e6) -> bool:
    """Whether the orbit that leaves a saddle-node comes to rest before psi has fallen by an angle."""
    system, values = _planar()
    parameters = system.values(values | {"u": fold[2], "beta_r": beta_r, "sigma": sigma})
    start = _leaving(fold, beta_r, sigma)
    states = integrate(compile_system(system, 1e-13), start, parameters, np.linspace(0.0, until, 3001)).states
    return bool(states[0, -1] > start[0] - angle)


def _changes(left: Callable[[float], bool], at: float, within: float) -> bool:
    """Whether what holds on the left of a value ends there."""
    return left(at - within) and not left(at + within)


def test_both_folds_coincide() -> None:
    first, second = _fold(LOWER, 3.68, DOUBLE[1]), _fold(UPPER, 3.68, DOUBLE[1])
    assert first[2] == pytest.approx(DOUBLE[2], rel=1e-6)
    assert second[2] == pytest.approx(DOUBLE[2], rel=1e-6)


def test_first_curve_by_integration() -> None:
    """At sigma = 0.1 and u = u2*: left of 1.0208205 the orbit comes back to the saddle-node, right of it passes by."""
    fold = _fold((2.6986, 1.4927), 5.8710372, 0.1)
    assert _changes(lambda b: _arrives(fold, b, 0.1, ONCE, 1e7), 1.0208205, 2e-5)


def test_third_curve_by_integration() -> None:
    """At sigma = 0.05324 and u = u1*: left of beta_r = 1.19211 what leaves the saddle-node comes to the upper node."""
    fold = _fold((4.6, 0.86), 5.33, 0.05324)
    assert fold[2] == pytest.approx(5.33, abs=5e-3)
    assert _changes(lambda b: _arrives(fold, b, 0.05324, HALF), 1.19211, 2e-4)


def test_the_point_where_they_meet_by_integration() -> None:
    """At u1* = u2*: the orbit from the lower saddle-node passes the upper one on different sides."""
    sigma = float(brentq(lambda s: _fold(LOWER, 3.68, s)[2] - _fold(UPPER, 3.68, s)[2], 0.0672, 0.0674, xtol=1e-15))
    assert sigma == pytest.approx(DOUBLE[1], rel=1e-6)
    fold = _fold(LOWER, DOUBLE[2], sigma)
    assert _changes(lambda b: _arrives(fold, b, sigma, HALF), DOUBLE[0], 1e-4)


@cache
def _case() -> EndingMapCase:
    study = read_study("drozdetskaya-2020/how-the-rotating-orbit-disappears")
    assert isinstance(study.spec, StabilityMap)
    _, case = study.spec.prepare(study.subject)
    assert isinstance(case, EndingMapCase)
    return case


def _ending(beta_r: float, sigma: float) -> OrbitEnding:
    case = _case()
    there = case.motion.with_values({"beta_r": beta_r, "sigma": sigma})
    return ending_at(there, (beta_r, sigma), lambda: None)


@pytest.mark.parametrize(
    ("beta_r", "sigma", "kind"),
    [
        (0.99, 0.10, "saddle-node-on-orbit"), (1.05, 0.10, "saddle-connection"),  # beside the first curve
        pytest.param(1.00, 0.06, "saddle-connection", marks=pytest.mark.slow), (0.93, 0.06, "none"),  # beside the third
        pytest.param(0.25, 0.075, "saddle-node-on-orbit", marks=pytest.mark.slow),  # beside sigma = 0.0672888
        pytest.param(0.25, 0.062, "none", marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_regions_beside_their_boundaries(beta_r: float, sigma: float, kind: str) -> None:
    assert _ending(beta_r, sigma).kind == kind


def test_saddle_connection_of_the_middle_region() -> None:
    """Its value of u, at beta_r = 1.3 and sigma = 0.1, is between runs along the saddle's unstable manifold that differ."""
    end = _ending(1.3, 0.1).end
    assert end.value == pytest.approx(6.1950292, rel=1e-6)
    system, values = _planar()
    rotates = []
    for unknowns in (6.1945, 6.1955):
        x = fsolve(
            lambda s, unknowns=unknowns: _equations().values(np.array([*s, unknowns, 1.3, 0.1]))[0], end.equilibrium, xtol=1e-13
        )
        rates, vectors = np.linalg.eig(_equations().values(np.array([*x, unknowns, 1.3, 0.1]))[1][:, :2])
        v = vectors[:, rates.real.argmax()].real
        parameters = system.values(values | {"u": unknowns, "beta_r": 1.3, "sigma": 0.1})
        start = list(x - 1e-6 * v * np.sign(v[0]))
        states = integrate(compile_system(system, 1e-12), start, parameters, np.linspace(0, 4e4, 4001)).states
        rotates.append(not is_at_rest(states[:, -500:]))
    assert rotates == [True, False]


@pytest.mark.slow
def test_the_whole_map() -> None:
    study = read_study("drozdetskaya-2020/how-the-rotating-orbit-disappears")
    summary = run(study.spec, study.subject).wucht.summary
    (point,) = summary["points"]
    assert (point["beta_r"], point["sigma"], point["u"]) == pytest.approx(DOUBLE, rel=1e-6)
    assert sorted(summary["boundaries"]) == [
        "saddle connection | no modulated motion",
        "saddle-node on the orbit | no modulated motion",
        "saddle-node on the orbit | saddle connection",
    ]
    assert summary["against"] == 0
    first = np.array(summary["boundaries"]["saddle-node on the orbit | saddle connection"])
    first = first[np.argsort(first[:, 1])]
    assert np.interp(0.1, first[:, 1], first[:, 0]) == pytest.approx(1.0208205, abs=1e-4)
    third = np.array(summary["boundaries"]["saddle connection | no modulated motion"])
    third = third[np.argsort(third[:, 0])]
    assert np.interp(1.19211, third[:, 0], third[:, 1]) == pytest.approx(0.05324, abs=1e-4)
    json.dumps(summary)


@pytest.mark.slow
def test_figure_5_9a() -> None:
    """002 figure 5.9a: the folds u1*, u2*, and the loss of stability of delta = 0 through (3.0800128, 0.1) (cases.md)."""
    study = read_study("drozdetskaya-2020/figure-5.9a")
    summary = run(study.spec, study.subject).wucht.summary
    folds = [np.array(v) for n, v in summary["boundaries"].items() if n.startswith("fold: together")]
    for sigma, values in ((0.1, (1.8331080, 5.8710372)), (0.05, (2.6739155, 5.8600817))):
        at = sorted(float(np.interp(sigma, f[:, 1], f[:, 0])) for f in (f[np.argsort(f[:, 1])] for f in folds))
        assert at == pytest.approx(values, rel=2e-3)
    (crossing,) = summary["points"]
    assert (crossing["u"], crossing["sigma"]) == pytest.approx((3.6873885, 0.0672888), rel=1e-6)
    lost = np.array(summary["boundaries"]["modulated motion: loses stability sideways"])
    assert np.interp(0.1, lost[:, 1], lost[:, 0]) == pytest.approx(3.0800128, abs=2e-3)
    assert summary["against"] == 0
