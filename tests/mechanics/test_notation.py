"""The equations of coordinates as they are written, of mass matrices and forces made by hand."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from wucht.mechanics.energies import InternalState, StateDescription
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.notation import Equation, Notation, equation_text, printed_equations, printed_state_rates
from wucht.system import TIME, SecondOrder

OMEGA = sp.Symbol("omega", real=True)


def texts(equations: Sequence[Equation], latex: bool = False) -> list[str]:
    return [equation_text(equation, latex) for equation in equations]


X, PHI = Coordinate.from_names("carrier.x", "carrier.vx"), Coordinate.from_names("p.angle", "p.speed", True)
M, ELL, K, B = sp.symbols("M l k b", real=True)
NAMES = Notation({"carrier.x": "x", "p.angle": "phi", "M": "M", "l": "l_p", "k": "k", "b": "b_carrier"})


def cart() -> SecondOrder:
    """Of a mass on a spring with something that turns: the mass matrix couples them, and signs differ."""
    mass = sp.ImmutableMatrix([[2 * M, -ELL * sp.cos(PHI.position)], [-ELL * sp.cos(PHI.position), M * ELL**2]])
    forces = sp.ImmutableMatrix([-K * X.position - B * X.velocity, -K * sp.sin(PHI.position)])
    return SecondOrder((X.position, PHI.position), (X.velocity, PHI.velocity), mass, forces)


def test_each_equation_has_its_own_inertia_forces_and_signs() -> None:
    rows = texts(printed_equations(cart(), [X, PHI], NAMES, (), latex=False, normalise=False))
    assert rows == ["2*M*x'' - l_p*phi''*cos(phi) = -b_carrier*x' - k*x", "M*l_p**2*phi'' - l_p*x''*cos(phi) = -k*sin(phi)"]


def test_a_normalised_equation_is_divided_by_its_inertia() -> None:
    rows = texts(printed_equations(cart(), [X, PHI], NAMES, (), latex=False, normalise=True))
    first = "x'' - l_p*phi''*cos(phi)/(2*M) = "
    assert rows[0].startswith(first)
    assert (
        sp.simplify(sp.sympify(rows[0].removeprefix(first).replace("x'", "v")) - sp.sympify("-(k*x + b_carrier*v)/(2*M)")) == 0
    )
    assert rows[1] == "phi'' - x''*cos(phi)/(M*l_p) = -k*sin(phi)/(M*l_p**2)"


def test_a_prescribed_speed_that_is_constant_has_no_acceleration_and_one_that_grows_has() -> None:
    """In the other equations, whose coupling stays in the second case alone."""
    for speed, coupled in ((OMEGA, False), (OMEGA * TIME, True)):
        driven = Coordinate.from_names("p.angle", "p.speed", True, speed)
        notation = Notation({**NAMES.names, "omega": "omega"})
        first, given, torque = texts(printed_equations(cart(), [X, driven], notation, (), latex=False, normalise=False))
        assert ("phi''" in first) is coupled
        assert given == f"phi' = {'omega*t' if coupled else 'omega'}"
        assert torque.endswith("= T_motor - k*sin(phi)")
        assert ("M*l_p**2*phi''" in torque) is coupled


def test_the_rate_of_an_internal_state() -> None:
    description = StateDescription("sum", "rad", "sum of deviations", "I")
    state = InternalState(description.at("drive"), OMEGA - PHI.velocity, description, sp.S.One)
    notation = Notation({**NAMES.names, "omega": "omega", "drive.sum": "I_drive"})
    assert state.path == "drive"
    assert state.change.name == "drive.sum.rate"
    assert texts(printed_state_rates([state], [PHI], notation, latex=False)) == ["I_drive' = omega - phi'"]
    assert texts(printed_state_rates([state], [PHI], notation, latex=True), True) == [
        r"\dot{I}_{\mathrm{drive}} &= - \dot{\varphi} + \omega"
    ]  # fmt: skip


# --- the symbols of machines ---
