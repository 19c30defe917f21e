"""The load of dry friction."""

from __future__ import annotations

import sympy as sp

from wucht.machines.parts.base import SI, Load, si

TRANSITION = 0.1  # rad/s: below any speed of interest, above what an integrator would take for a jump


class CoulombLoad(Load):
    """torque = constant, against the speed; smooth near standstill: T tanh(speed/transition_speed).

    So it does not hold a body at rest: under a smaller torque M the body creeps with transition_speed * artanh(M/T).
    """

    kind = "coulomb"

    # The key is ``torque``, which in Python is the method.
    level: SI[float] = si("N m", "friction torque", "T_c", alias="torque", ge=0, help="friction torque against the speed")
    transition_speed: SI[float] = si("rad/s", "speed of the transition at standstill", "w_c", default=TRANSITION, gt=0)

    def torque(self, speed: sp.Expr) -> sp.Expr:
        """T tanh(speed/transition_speed)."""
        T, transition = self.symbols("torque", "transition_speed")
        return T * sp.tanh(speed / transition)
