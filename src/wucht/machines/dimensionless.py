"""The dimensionless numbers of an SI machine: 002 (4.8), for any number of pendulums; (3.30) where there is none."""

from __future__ import annotations

import math

import numpy as np

from wucht.machines.doubts import unbalance
from wucht.machines.machine import Machine
from wucht.machines.models import Model
from wucht.machines.parts.carrier import Carrier
from wucht.machines.parts.linear_drive import LinearDrive
from wucht.machines.parts.pendulum import Pendulum
from wucht.machines.parts.rotor import Rotor


def natural_frequencies(machine: Machine) -> dict[str, float]:
    """The undamped natural frequencies of the free carrier with all bodies on it, in rad a unit of time.

    By direction where the directions are not coupled, else by number, the lowest first.
    """
    c, numbers = machine.linear_carrier, machine.numbers
    size = len(machine.free_carrier)
    mass, stiffness = (np.array(a.xreplace(numbers).tolist(), float).reshape(size, size) for a in (c.mass, c.stiffness))
    if _diagonal(mass) and _diagonal(stiffness):
        pairs = zip(machine.free_labels, np.diag(stiffness), np.diag(mass), strict=True)
        return {label: math.sqrt(max(k, 0.0) / m) if m > 0 else math.nan for label, k, m in pairs}
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
    return {f"mode {i + 1}": math.sqrt(max(float(s), 0.0)) for i, s in enumerate(squares)}


def _diagonal(matrix: np.ndarray) -> bool:
    return bool((matrix == np.diag(np.diag(matrix))).all())


def numbers(machine: Machine) -> dict[str, float]:
    """Epsilon, mu, s, w, beta_p, beta_r, lambda, sigma, u, and p: those that the machine has.

    They need a rotor with unbalance on a carrier that is isotropic or moves in one direction; lambda and u a linear drive on
    it; s, w, p, mu, beta_p, beta_r equal pendulums (beta_r = n b/(k J_R), which is (4.8) for n = 2).
    A dimensionless machine returns its own parameters.
    """
    if isinstance(machine.parts[0], Model):
        return dict(machine.values)
    carrier, rotor = machine.parts[0], next((p for p in machine.parts if isinstance(p, Rotor)), None)
    plain = isinstance(carrier, Carrier) and carrier.stiffness is not None and not carrier.foundation and not carrier.motion
    if rotor is None or not isinstance(carrier, Carrier) or not plain or len(machine.rotors) > 1 or machine.sliders:
        return {}
    total_mass = float(machine.linear_carrier.mass[0, 0].xreplace(machine.numbers))
    own, frequency = unbalance(rotor), set(natural_frequencies(machine).values())
    damping = carrier.damping if isinstance(carrier.damping, float) else carrier.damping[0]
    isotropic = isinstance(carrier.damping, float) or carrier.damping[0] == carrier.damping[1]
    if not frequency:
        return {}
    k = frequency.pop()
    if frequency or not isotropic or not own or not k:
        return {}
    e = own / rotor.mass
    found = {"epsilon": rotor.mass * e**2 / rotor.inertia, "sigma": damping / (2 * total_mass * k)}
    drives = [d for d in machine.drives if isinstance(d, LinearDrive) and d.on == rotor.name]
    if drives:
        found |= {"lambda": drives[0].no_load_speed / k, "u": drives[0].slope / (k * rotor.mass * e**2)}
    pendulums = [p for p in machine.parts if isinstance(p, Pendulum) and p.about == rotor.name]
    equal = len({p.model_dump_json(exclude={"name", "release"}) for p in pendulums}) == 1 and not pendulums[0].suspension
    if equal and len(pendulums) == len(machine.bodies) - 1:
        found |= _of_pendulums(pendulums[0], len(pendulums), own, e, total_mass, rotor.inertia, k)
    return found


def _of_pendulums(
    one: Pendulum, count: int, own: float, e: float, total_mass: float, rotor_inertia: float, k: float
) -> dict[str, float]:
    moment = one.mass * one.length
    inertia = one.inertia if one.inertia is not None else moment * one.length
    p = moment * one.length / inertia
    return {
        "s": own / moment,
        "w": moment / (total_mass * e),
        "p": p,
        "mu": p * one.mass / total_mass,
        "beta_p": one.damping / (k * inertia),
        "beta_r": count * one.damping / (k * rotor_inertia),
    }
