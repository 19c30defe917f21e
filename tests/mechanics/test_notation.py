"""The equations of coordinates as they are written, of mass matrices and forces made by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pytest
import sympy as sp

from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.symbols import notation_of
from wucht.mechanics.energies import AppliedForce, Energies, InternalState, StateDescription
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.notation import Equation, Notation, equation_text, printed_equations, printed_state_rates
from wucht.system import TIME, SecondOrder

OMEGA = sp.Symbol("omega", real=True)


def texts(equations: Sequence[Equation], latex: bool = False) -> list[str]:
    return [equation_text(equation, latex) for equation in equations]


@pytest.mark.parametrize(
    ("angle", "latex", "expected"),
    [
        (True, False, ["q' = omega", "0 = T_motor - q'"]),
        (False, False, ["q' = omega", "0 = F_drive - q'"]),
        (True, True, [r"\dot{q} &= \omega", r"0 &= T_{\mathrm{motor}} - \dot{q}"]),
        (False, True, [r"\dot{q} &= \omega", r"0 &= F_{\mathrm{drive}} - \dot{q}"]),
    ],
)
def test_a_motion_that_is_prescribed_takes_the_torque_of_a_motor_or_the_force_of_a_drive(
    angle: bool, latex: bool, expected: list[str]
) -> None:
    """It acts with the other torques or forces, here with a drag."""
    c = Coordinate.from_names("d.position", "d.velocity", angle, OMEGA)
    motion = SecondOrder((c.position,), (c.velocity,), sp.ImmutableMatrix([[2]]), sp.ImmutableMatrix([-c.velocity]))
    notation = Notation({"d.position": "q", "omega": "omega"})
    assert texts(printed_equations(motion, [c], notation, (), latex, False), latex) == expected


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
    assert rows == [
        "2*M*x'' - l_p*phi''*cos(phi) = -b_carrier*x' - k*x",
        "M*l_p**2*phi'' - l_p*x''*cos(phi) = -k*sin(phi)",
    ]


def test_a_normalised_equation_is_divided_by_its_inertia() -> None:
    rows = texts(printed_equations(cart(), [X, PHI], NAMES, (), latex=False, normalise=True))
    first = "x'' - l_p*phi''*cos(phi)/(2*M) = "
    assert rows[0].startswith(first)
    assert (
        sp.simplify(sp.sympify(rows[0].removeprefix(first).replace("x'", "v")) - sp.sympify("-(k*x + b_carrier*v)/(2*M)")) == 0
    )
    assert rows[1] == "phi'' - x''*cos(phi)/(M*l_p) = -k*sin(phi)/(M*l_p**2)"


def test_terms_with_parameters_that_are_zero_are_left_out() -> None:
    rows = texts(printed_equations(cart(), [X, PHI], NAMES, [B, ELL], latex=False, normalise=False))
    assert rows == ["2*M*x'' = -k*x", "0 = -k*sin(phi)"]


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


def test_energies_add_formula_by_formula() -> None:
    force = AppliedForce(K, X.velocity)
    one = Energies(M, K, B, (force,), (), "a stop")
    other = Energies(ELL, 2 * K, 3 * B, (), (), "")
    both = one + other
    assert (both.kinetic, both.potential, both.dissipation) == (M + ELL, 3 * K, 4 * B)
    assert both.applied_forces == (force,)
    assert both.nonlinear == "a stop"
    assert both.symbols == {M, ELL, K, B, X.velocity}
    assert force.power == K * X.velocity


# --- the symbols of machines ---

ROTOR = {"kind": "rotor", "mass": 2.0, "unbalance": 0.01, "inertia": 0.05}
BALL = {"kind": "pendulum", "about": "a", "mass": 0.1, "length": 0.1, "damping": 0.01}
CARRIER = {"mass": 1.0, "stiffness": [1e4, 2e4], "damping": 5.0}


def names_of(*bodies: dict[str, Any], **more: Any) -> Mapping[str, str]:
    return notation_of(machine_from({"carrier": CARRIER, "bodies": list(bodies)} | more)).names


def test_one_rotor_is_phi_and_several_have_an_index() -> None:
    one = names_of(ROTOR | {"name": "a"}, BALL | {"name": "p"})
    assert (one["a.angle"], one["p.angle"], one["carrier.x"], one["carrier.y"]) == ("phi", "theta_p", "x", "y")
    two = names_of(ROTOR | {"name": "a"}, ROTOR | {"name": "b"}, BALL | {"name": "p"})
    assert (two["a.angle"], two["b.angle"], two["p.angle"]) == ("phi_a", "phi_b", "theta_p")


def test_a_parameter_has_an_index_where_two_have_its_symbol() -> None:
    names = names_of(ROTOR | {"name": "a"}, BALL | {"name": "p"}, BALL | {"name": "q"})
    assert (names["p.length"], names["q.length"]) == ("l_p", "l_q")
    assert names_of(ROTOR | {"name": "a"}, BALL | {"name": "p"})["p.length"] == "l"
    assert len(set(names.values())) == len(names)


def test_mounts_and_drives_of_one_list_are_told_apart() -> None:
    mounts = [{"at": [x, 0.0], "stiffness": [1e4, 2e4], "damping": [1.0, 2.0]} for x in (-0.3, 0.4)]
    carrier = {"directions": "xyr", "mass": 30.0, "inertia": 3.0, "mounts": mounts}
    names = names_of(
        ROTOR | {"name": "a"},
        ROTOR | {"name": "b"},
        carrier=carrier,
        drives=[{"kind": "linear", "on": n, "slope": 0.1, "no_load_speed": 9.0} for n in "ab"],
    )
    assert names["carrier.mounts.1.stiffness.x"] != names["carrier.mounts.2.stiffness.x"]
    assert names["drives.a.slope"] != names["drives.b.slope"]
    assert names["carrier.r"] == "chi"
    assert len(set(names.values())) == len(names)


def test_a_dimensionless_machine_moves_by_xi_and_eta() -> None:
    names = notation_of(load_machine("drozdetskaya-2020/table-5.1")).names
    assert [names[f"carrier.{d}"] for d in "xy"] == ["xi", "eta"]
