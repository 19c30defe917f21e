"""The dimensionless numbers of an SI machine: 002 (4.8), for any number of pendulums; (3.30) where there is none."""

from __future__ import annotations

import math

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.operation import relative_damping, slopes
from wucht.machines.parts.base import Body
from wucht.machines.structure import SPEED


def dimensionless_numbers(machine: Machine) -> dict[str, float]:
    """Epsilon, mu, s, w, beta_p, beta_r, lambda, sigma, u, and p: those that the machine has.

    They need a rotor with unbalance on a carrier that is isotropic or moves in one direction; lambda and u a drive whose torque
    falls linearly with the speed; s, w, p, mu, beta_p, beta_r equal rigid bodies about the rotor's axis (beta_r = n b/(k J_R),
    which is (4.8) for n = 2). A dimensionless machine returns its parameters.
    """
    if machine.dimensionless:
        return dict(machine.values)
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    rotor, frequency = parts[machine.rotor.name], _frequency(machine)
    arm, inertia = rotor.arms().get(rotor.name), rotor.axis_inertia()
    if arm is None or inertia is None or frequency is None or len(machine.rotors) > 1 or machine.sliders:
        return {}
    inertia += sp.Add(*(d.reduced_inertia() for d in machine.drives if d.on == rotor.name))
    rotor_moment, e, j = map(float, machine.evaluate(rotor.moment(), arm, inertia))
    if not rotor_moment:
        return {}
    mass, damping = (float(m[0, 0]) for m in machine.matrices[:2])
    results = {"epsilon": rotor_moment * e / j, "sigma": damping / (2 * mass * frequency)}
    for torque in (d.body_torque(SPEED) for d in machine.drives if d.on == rotor.name):
        symbolic = slopes((torque,))[0].xreplace(machine.numbers)
        slope = -float(symbolic) if symbolic.is_number else 0.0
        if slope > 0:
            at_rest = float(torque.xreplace({SPEED: sp.S.Zero} | machine.numbers))
            results |= {"lambda": at_rest / slope / frequency, "u": slope / (frequency * rotor_moment * e)}
    pendulums = {_pendulum_properties(machine, parts[b.name]) for b in machine.bodies if b.about == rotor.name}
    pendulum = pendulums.pop() if len(pendulums) == 1 else None
    if pendulum is None or any(b.about not in (None, rotor.name) for b in machine.bodies):
        return results
    moment, length, inertia_, b = pendulum
    p = moment * length / inertia_
    return results | {
        "s": rotor_moment / moment,
        "w": moment / (mass * e),
        "p": p,
        "mu": p * moment / length / mass,
        "beta_p": b / (frequency * inertia_),
        "beta_r": (len(machine.bodies) - 1) * b / (frequency * j),
    }


def _frequency(machine: Machine) -> float | None:
    """The natural frequency of a carrier that is isotropic in the plane or moves in one direction; None for others."""
    (mass, *_), alike = machine.matrices, all((m == m[:1, :1] * np.eye(len(m))).all() for m in machine.matrices)
    if not len(mass) or not alike or not set(machine.labels) <= {"x", "y"} or machine.shaken_coordinate is not None:
        return None
    return (math.sqrt(max(machine.matrices[2][0, 0], 0.0) / mass[0, 0]) if mass[0, 0] > 0 else 0.0) or None


def _pendulum_properties(machine: Machine, body: Body) -> tuple[float, float, float, float] | None:
    """Unbalance, length, inertia and damping of a rigid body about the rotor's axis; None for other bodies."""
    arm, inertia = body.arms().get(body.name), body.axis_inertia()
    damping = relative_damping(machine, machine.body(body.name)) if body.turns() else None
    if arm is None or inertia is None or damping is None or not damping.is_number or not body.is_on_axis():
        return None
    moment, length, j = map(float, machine.evaluate(body.moment(), arm, inertia))
    return moment, length, j, float(damping)
