"""The drive whose torque does not depend on speed."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, Drive, si


class ConstantTorque(Drive):
    """torque = constant: the ideal force characteristic. Negative turns backwards: Drozdetskaya (2.81)."""

    kind = "constant-torque"

    # The key is ``torque``, which in Python is the method.
    level: SI[float] = si("N m", "torque", "T_0", alias="torque", help="torque on the body; a negative one turns backwards")

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """002 (2.81)."""
        return self.symbol("torque")
