"""The equations of coordinates as they are written, of mass matrices and forces made by hand."""

from __future__ import annotations

import pytest
import sympy as sp

from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.notation import Notation, printed_equations
from wucht.system import SecondOrder

OMEGA = sp.Symbol("omega", real=True)


@pytest.mark.parametrize(
    ("angle", "latex", "expected"),
    [
        (True, False, ["q' = omega", "0 = T_motor - q'"]),
        (False, False, ["q' = omega", "0 = F_drive - q'"]),
        (True, True, [r"\dot{q} = \omega", r"0 = T_{\mathrm{motor}} - \dot{q}"]),
        (False, True, [r"\dot{q} = \omega", r"0 = F_{\mathrm{drive}} - \dot{q}"]),
    ],
)
def test_a_motion_that_is_prescribed_takes_the_torque_of_a_motor_or_the_force_of_a_drive(
    angle: bool, latex: bool, expected: list[str]
) -> None:
    """It acts with the other torques or forces, here with a drag."""
    c = Coordinate.from_names("d.position", "d.velocity", angle, OMEGA)
    motion = SecondOrder((c.position,), (c.velocity,), sp.ImmutableMatrix([[2]]), sp.ImmutableMatrix([-c.velocity]))
    notation = Notation({"d.position": "q", "omega": "omega"})
    assert printed_equations(motion, [c], notation, (), latex, False) == expected
