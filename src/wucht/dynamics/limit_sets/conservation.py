"""Whether equations preserve volume in the space of their states: then no motion attracts others.

The rate of change of a volume that moves with the motions is the integral of the divergence of the rates over it (Liouville's
theorem). An attractor has a neighbourhood all of which tends to it, so that its volume shrinks to nothing: impossible where the
divergence is zero everywhere, as for Hamilton's equations.
"""

from __future__ import annotations

import sympy as sp

from wucht.machines.subject import Subject
from wucht.mechanics.zero_testing import SAME, is_identically_zero


def preserves_volume(subject: Subject) -> bool:
    """True if the divergence of the rates is zero for all states and times, at the values of the parameters."""
    system = subject.system
    numbers = dict(zip(system.parameters, map(sp.Float, system.values(subject.values)), strict=True))
    divergence = sp.Add(
        *(sp.diff(system.explicit(sp.sympify(r)), s) for s, r in zip(system.states, system.derivatives, strict=True))
    )
    return is_identically_zero(divergence.xreplace(numbers), SAME)


CONSERVATIVE_MOTION = (
    "these equations preserve volume in the space of their states (the divergence of the rates is zero, as for a Hamiltonian "
    "system): no motion attracts others"
)
CONSERVATIVE = f"{CONSERVATIVE_MOTION}, so there are no attractors and no basins; a run-up shows single motions"
