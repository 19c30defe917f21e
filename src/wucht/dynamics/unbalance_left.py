"""The residual unbalance of rotors with balancing bodies, as a quantity of the instant."""

from __future__ import annotations

import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.machines.tree import RotatingBody
from wucht.system import Output


def unbalances_left(machine: Machine) -> list[Output]:
    """Return, for each unbalanced rotor with bodies about it, the share of its unbalance that is left with them.

    It is |U_rotor + sum U_i exp(i (phi_i - phi_rotor))| / |U_rotor|, as ``final_residual_unbalance`` of a run has it.
    """
    moments = _moments(machine)
    sizes = machine.evaluate(*(abs(moments[r.name]) for r in machine.rotors))
    rotors = [r for r, size in zip(machine.rotors, sizes, strict=True) if len(machine.group(r)) > 1 and float(size) > 0]
    return [_left(machine, r, moments) for r in rotors]


def _left(machine: Machine, rotor: RotatingBody, moments: dict[str, sp.Expr]) -> Output:
    along, across = sp.S.Zero, sp.S.Zero
    for body in machine.group(rotor):
        real, imaginary = moments[body.name].as_real_imag()
        phase = body.coordinate.position - rotor.coordinate.position
        along += real * sp.cos(phase) - imaginary * sp.sin(phase)
        across += real * sp.sin(phase) + imaginary * sp.cos(phase)
    size = sp.sqrt(sp.Add(*(part**2 for part in moments[rotor.name].as_real_imag())))
    share = sp.sqrt(along**2 + across**2) / size
    return Output(f"unbalance_left[{rotor.name}]", share, "", f"residual unbalance of {rotor.name}, as a share of its own")


def _moments(machine: Machine) -> dict[str, sp.Expr]:
    """Return the unbalance of each body in its own frame, complex, as ``wucht.analysis.vibration.unbalances``; symbolic."""
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    if not parts:  # a dimensionless machine
        excitation = machine.linear_carrier.excitation
        return {b.name: sp.sympify(e[0]) for b, e in zip(machine.bodies, excitation, strict=True)}
    sliding = {x.name: x.coordinate.position for x in machine.sliders}
    moments = {b.name: parts[b.name].moment() for b in machine.bodies}
    moments = {
        name: m + (parts[name].moment_along_guide() * sliding[name] if name in sliding else 0) for name, m in moments.items()
    }
    for part in parts.values():
        if (couple := part.couple()) is not None:
            moments[part.name] = couple
        if part.reference is not None:
            moments[part.reference] += part.moment_on_reference()
    return {name: sp.sympify(m) for name, m in moments.items()}
