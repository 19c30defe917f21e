"""Contact of all cams of a drive over a turn: the forces on the contours, their pressure, and the torque of the camshaft."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.contact import CamForces, FollowerLoad, Material, Speed, conjugate_forces, contact_forces, contact_pressure
from wucht.numerics.angles import GRID, Arc


@dataclass(frozen=True, eq=False)
class ContactLoad:
    """Load of a contact: load on the follower, speed in rad/s and its mean, share of the cam in the driving torque, width in m.

    width: None where it is not known, so that there is no pressure.
    """

    load: FollowerLoad
    speed: Speed
    mean_speed: float
    share: float
    width: float | None
    materials: tuple[Material, Material]


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """Contact of each cam over cam angles phi (N,) in rad: force (N,) in N, none negative, and pressure (N,) in Pa.

    torque, power (N,): of the camshaft in N m, driving it, and in W, 0 without contact. lift_off: arcs without contact,
    (begin, end) in rad. least_preload: above which there are no such arcs, in N m or N.
    """

    phi: np.ndarray
    force: Mapping[str, np.ndarray]
    pressure: Mapping[str, np.ndarray]
    torque: np.ndarray
    power: np.ndarray
    lift_off: Mapping[str, tuple[Arc, ...]]
    least_preload: float


def contact_history(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> ContactHistory:
    """Return the contact at cam angles (N,). Raises ``InputError`` (preload, width, follower)."""
    if "counter" in cams:
        forces = conjugate_forces(cams["cam"], cams["counter"], contact.load, contact.speed, phi, contact.share)
    else:
        contact_of = _groove_contact if "outer" in cams else _single_cam_contact
        forces = contact_of(contact, cams["cam"], phi)
    force, torque, lift_off, least_preload = forces
    pressure = dict[str, np.ndarray]()
    if contact.width is not None:
        for name, cam in cams.items():
            pressure[name] = contact_pressure(cam, force[name], phi, contact.width, contact.materials)
    speed = contact.speed(phi) if callable(contact.speed) else contact.speed
    return ContactHistory(phi, force, pressure, torque, torque * speed, lift_off, least_preload)


def _single_cam_contact(contact: ContactLoad, cam: Cam, phi: np.ndarray) -> CamForces:
    solution = contact_forces(cam, contact.load, contact.speed, phi)
    torque = np.where(solution.force > 0, solution.torque, 0.0)
    return {"cam": np.maximum(solution.force, 0.0)}, torque, {"cam": solution.lift_off}, solution.least_preload


def _groove_contact(contact: ContactLoad, cam: Cam, phi: np.ndarray) -> CamForces:
    """Return the contact of a groove: where the inner flank would have to pull, the outer flank presses."""
    solution = contact_forces(cam, contact.load, contact.speed, phi)
    force = {"cam": np.maximum(solution.force, 0.0), "outer": np.maximum(-solution.force, 0.0)}
    lift_off = {"cam": solution.lift_off, "outer": _remaining_arcs(solution.lift_off)}
    return force, solution.torque, lift_off, solution.least_preload


def _remaining_arcs(arcs: tuple[Arc, ...]) -> tuple[Arc, ...]:
    """Return the remaining arcs of the turn."""
    turn = 2 * np.pi
    if not arcs:
        return ((0.0, turn),)
    nexts = [begin for begin, _ in arcs[1:]] + [arcs[0][0] + turn]
    gaps = [(end % turn, end % turn + after - end) for (_, end), after in zip(arcs, nexts, strict=True)]
    return tuple((float(begin), float(end)) for begin, end in gaps if end > begin)


def dense_contact_history(contact: ContactLoad, cams: Mapping[str, Cam]) -> ContactHistory:
    """Return the contact at angles that are dense enough for the largest values."""
    return contact_history(contact, cams, GRID)
