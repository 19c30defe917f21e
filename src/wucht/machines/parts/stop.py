"""A compliant stop: a spring and damper that acts while a gap is negative, with a given restitution.

Hard stops would bounce infinitely often in a finite time; these are short, and the loss of an impact is in the energy balance.
"""

from __future__ import annotations

import sympy as sp

from wucht.mechanics.energies import Energies
from wucht.piecewise import PiecewiseCubic, step


def stop(gap: sp.Expr, rate: sp.Expr, inertia: sp.Expr, frequency: sp.Expr, log_restitution: sp.Expr) -> Energies:
    """V = k gap^2/2 and R = d rate^2/2 while gap < 0, with k = J omega^2 and d = 2 zeta J omega.

    gap: of a coordinate of the reduced inertia J, in its unit; rate: its derivative. frequency: omega, in rad/s: an impact
    takes half a period. log_restitution: ln e; half a damped period multiplies the speed by e = exp(-pi zeta/sqrt(1 - zeta^2)).
    """
    zeta = -log_restitution / sp.sqrt(sp.pi**2 + log_restitution**2)
    return buffer(gap, rate, inertia * frequency**2, 2 * zeta * inertia * frequency)


def buffer(gap: sp.Expr, rate: sp.Expr, stiffness: sp.Expr, damping: sp.Expr) -> Energies:
    """V = c gap^2/2 and R = d rate^2/2 while gap < 0."""
    on = contact_indicator(gap)
    return Energies(potential=on * stiffness * gap**2 / 2, dissipation=on * damping * rate**2 / 2)


def contact_indicator(gap: sp.Expr) -> sp.Expr:
    """1 while gap < 0, else 0."""
    return PiecewiseCubic(gap, step("contact", 0.0, 1.0, 0.0))
