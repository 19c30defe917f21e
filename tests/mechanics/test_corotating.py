"""The equations in the turning frame against those at rest, rotated by hand, at states drawn at random."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from tests.refusals import Refusal, rejected

from wucht.mechanics.corotating import Turning, corotating, refuse_oriented
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate, equations_of_motion, first_order
from wucht.numerics.flow.program import Evaluator
from wucht.system import System

X, Y, PHI, THETA = (Coordinate.from_names(n, f"v{n}", angle=n in ("phi", "theta")) for n in ("x", "y", "phi", "theta"))
K, L, G, B = sp.symbols("k l g b", real=True)
PLANE = Turning((X, Y), (PHI, THETA))


def part(c: Coordinate, unbalance: float, inertia: float) -> Energies:
    """A body on the axis."""
    push = c.velocity * (-X.velocity * sp.sin(c.position) + Y.velocity * sp.cos(c.position))
    return Energies(kinetic=unbalance * push + inertia * c.velocity**2 / 2)


SUPPORT = Energies(
    kinetic=(X.velocity**2 + Y.velocity**2) / 2,
    potential=K * (X.position**2 + Y.position**2) / 2,
    dissipation=B * (X.velocity**2 + Y.velocity**2) / 2,
)
PARTS = (
    SUPPORT,
    part(PHI, 0.3, 2.0),
    part(THETA, 0.2, 1.0),
    Energies(dissipation=L * (PHI.velocity - THETA.velocity) ** 2 / 2),
)


def system(parts: tuple[Energies, ...], prescribed: Any = None) -> System:
    phi = Coordinate(PHI.position, PHI.velocity, True, prescribed)
    coordinates = [X, Y, phi, THETA]
    return first_order(equations_of_motion(parts, coordinates), coordinates, (K, L, G, B))


def rates(equations: System, states: np.ndarray) -> dict[str, np.ndarray]:
    values = equations.values({"k": 1.3, "l": 0.2, "g": 0.0, "b": 0.4})
    found = Evaluator.of_rates(equations).array(np.zeros(states.shape[1]), states, values)
    return dict(zip(equations.state_names, found, strict=True))


@pytest.mark.parametrize("prescribed", [None, sp.Float(1.7)], ids=["free", "held"])
def test_the_rates_are_those_at_rest_rotated(prescribed: Any) -> None:
    """z = exp(-i phi)(x + i y): z' = exp(-i phi)(v - i phi' (x + i y)), and so on."""
    fixed = system(PARTS, prescribed)
    turned = corotating(fixed, PLANE)
    assert turned.state_names == ("carrier.along", "carrier.across", "theta.phase", "carrier.valong", "carrier.vacross") + (
        ("vphi", "vtheta") if prescribed is None else ("vtheta",)
    )
    assert {s.name for s in turned.angles} == {"theta.phase"}
    states = np.random.default_rng(3).normal(size=(len(fixed.states), 20))
    of = dict(zip(fixed.state_names, states, strict=True))
    vphi = of.get("vphi", np.full(20, 1.7))
    back = np.exp(-1j * of["phi"])
    z, v = (of["x"] + 1j * of["y"]) * back, (of["vx"] + 1j * of["vy"]) * back
    seen = {"carrier.along": z.real, "carrier.across": z.imag, "theta.phase": of["theta"] - of["phi"]}
    seen |= {"carrier.valong": v.real, "carrier.vacross": v.imag, "vphi": vphi, "vtheta": of["vtheta"]}
    f = rates(fixed, states)
    dz, dv = v - 1j * vphi * z, (f["vx"] + 1j * f["vy"]) * back - 1j * vphi * v
    expected = {"carrier.along": dz.real, "carrier.across": dz.imag, "theta.phase": of["vtheta"] - vphi}
    expected |= {"carrier.valong": dv.real, "carrier.vacross": dv.imag, "vphi": f.get("vphi", 0.0), "vtheta": f["vtheta"]}
    for name, rate in rates(turned, np.array([seen[name] for name in turned.state_names])).items():
        np.testing.assert_allclose(rate, expected[name], rtol=1e-12, atol=1e-12, err_msg=name)


@pytest.mark.parametrize(
    ("odd", "refusal"),
    [
        (Energies(potential=K * X.position**2), rejected("not-symmetric", "k", "potential")),
        (Energies(potential=G * sp.sin(PHI.position)), rejected("not-symmetric", "g", "potential")),
        (Energies(dissipation=L * Y.velocity**2), rejected("not-symmetric", "l", "dissipation")),
        (Energies(kinetic=X.velocity * Y.velocity), rejected("not-symmetric", "kinetic")),
    ],
)
def test_what_feels_being_turned_is_refused(odd: Energies, refusal: Refusal) -> None:
    refuse_oriented(PARTS, PLANE)
    with refusal:
        refuse_oriented((*PARTS, odd), PLANE)


def test_a_parameter_that_is_zero_disturbs_nothing_and_is_left_out() -> None:
    parts = (*PARTS, Energies(potential=G * sp.sin(PHI.position)))
    refuse_oriented(parts, PLANE, (G,))
    turned = corotating(system(parts), PLANE, (G,))
    assert "g" not in turned.parameter_names
