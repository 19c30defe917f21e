"""Load and speed of a contact in SI, and the forces on the contours and the camshaft."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.contact import FollowerLoad, Material, Speed, conjugate_forces, contact_forces, contact_pressure
from wucht.cams.drive import CamDrive
from wucht.cams.followers.roller_cam import ConjugateCams
from wucht.cams.shaft_motion import ShaftMotion
from wucht.errors import InputError
from wucht.numerics.angles import GRID, Arc
from wucht.schema import Unit, read_quantity
from wucht.studies.cam_contour.spec import CamContour, Contact

_UNITS = {
    "rad": {
        "preload": Unit("N m", "preload of a follower that turns"),
        "stiffness": Unit("N m/rad", "torsional stiffness of a follower that turns"),
        "damping": Unit("N m s/rad", "torsional damping of a follower that turns"),
        "constant": Unit("N m", "constant load of a follower that turns"),
    },
    "m": {
        "preload": Unit("N", "preload of a follower that slides"),
        "stiffness": Unit("N/m", "stiffness of a follower that slides"),
        "damping": Unit("N s/m", "damping of a follower that slides"),
        "constant": Unit("N", "constant load of a follower that slides"),
    },
}


@dataclass(frozen=True, eq=False)
class SpeedOverAngle:
    """Speed in rad/s of a shaft that does not turn evenly, over its angle, and its derivative."""

    turning: ShaftMotion

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """Return the speed (order 0) or its derivative (order 1) at cam angles of any shape."""
        tau = self.turning.time(phi)
        first = self.turning.angle(tau, 1)
        return np.asarray(self.turning.mean * (self.turning.angle(tau, 2) / first if order else first))


@dataclass(frozen=True, eq=False)
class ContactLoad:
    """Load of a contact: load on the follower, speed in rad/s and its mean, share as in ``Contact``, width in m or None."""

    load: FollowerLoad
    speed: Speed
    mean_speed: float
    share: float
    width: float | None
    materials: tuple[Material, Material]


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """Contact of each cam over cam angles phi (N,) in rad: force (N,) in N, none negative, and pressure (N,) in Pa.

    torque (N,): driving torque of the camshaft in N m, 0 without contact. lift_off: arcs without contact, (begin, end) in rad.
    least_preload: above which there are no such arcs, in N m or N.
    """

    phi: np.ndarray
    force: Mapping[str, np.ndarray]
    pressure: Mapping[str, np.ndarray]
    torque: np.ndarray
    lift_off: Mapping[str, tuple[Arc, ...]]
    least_preload: float


def contact_load(spec: CamContour, drive: CamDrive, unit: str) -> ContactLoad | None:
    """Return the load that the spec states. unit: of the follower's motion, rad or m.

    Raises ``InputError`` (study.contact..., study.speed).
    """
    contact = spec.contact
    if contact is None:
        return None
    inertia_key, inertia = _moved_inertia(contact, unit, "follower")
    if inertia is None:
        quantity = "moment of inertia in kg m^2 about its pivot" if unit == "rad" else "mass in kg"
        raise InputError(
            f"study.contact.{inertia_key}", None, f"this key is missing; give the follower's {quantity}", code="missing"
        )
    quantities = {key: read_quantity(of, getattr(contact, key), f"study.contact.{key}") for key, of in _UNITS[unit].items()}
    output_inertia = _output_inertia(contact, drive)
    try:
        load = FollowerLoad(inertia, **quantities, output_inertia=output_inertia)
    except InputError as error:
        raise error.with_prefix("study.contact") from None
    return ContactLoad(load, *_speed(spec, drive), contact.share, contact.width, _materials(contact))


def _moved_inertia(contact: Contact, unit: str, part: str) -> tuple[str, float | None]:
    """Return the key of the inertia or mass of a follower or output, and its value; the excluded key must not be given."""
    prefix = "output_" if part == "output" else ""
    inertia_key, excluded_key = (prefix + kind for kind in (("inertia", "mass") if unit == "rad" else ("mass", "inertia")))
    if getattr(contact, excluded_key) is not None:
        turns = "turns: give its inertia in kg m^2" if unit == "rad" else "slides: give its mass in kg"
        raise InputError(f"study.contact.{excluded_key}", getattr(contact, excluded_key), f"the {part} {turns}")
    return inertia_key, getattr(contact, inertia_key)


def _output_inertia(contact: Contact, drive: CamDrive) -> float:
    """Return the inertia or mass that a linkage moves, in kg m^2 or kg."""
    if drive.linkage is not None:
        return _moved_inertia(contact, drive.motion_law.unit, "output")[1] or 0.0
    for key in ("output_inertia", "output_mass"):
        if getattr(contact, key) is not None:
            requirement = "without a linkage the follower is the output: add this value to that of the follower"
            raise InputError(f"study.contact.{key}", getattr(contact, key), requirement)
    return 0.0


def _speed(spec: CamContour, drive: CamDrive) -> tuple[Speed, float]:
    if spec.speed is not None:
        return spec.speed, spec.speed
    if spec.corrected:
        return SpeedOverAngle(drive.corrected_shaft_motion), drive.corrected_shaft_motion.mean
    if drive.speed is None:
        requirement = "the contact force needs the speed of the camshaft: speed = '500 rpm', or a table [speed]"
        raise InputError("study.speed", None, requirement)
    return SpeedOverAngle(drive.shaft_motion), drive.shaft_motion.mean


def _materials(contact: Contact) -> tuple[Material, Material]:
    roller_modulus = contact.modulus if contact.roller_modulus is None else contact.roller_modulus
    roller_poisson = contact.poisson if contact.roller_poisson is None else contact.roller_poisson
    return Material(contact.modulus, contact.poisson), Material(roller_modulus, roller_poisson)


def contact_history(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> ContactHistory:
    """Return the contact at cam angles (N,). Raises ``InputError`` (study.contact.preload, follower)."""
    forces = (
        _conjugate_contact(contact, cams, phi) or _groove_contact(contact, cams, phi) or _single_cam_contact(contact, cams, phi)
    )
    force, torque, lift_off, least_preload = forces
    pressure = dict[str, np.ndarray]()
    if contact.width is not None:
        for name, cam in cams.items():
            try:
                pressure[name] = contact_pressure(cam, force[name], phi, contact.width, contact.materials)
            except InputError as error:
                raise error.with_prefix("study.contact") if error.location == "width" else error from None
    return ContactHistory(phi, force, pressure, torque, lift_off, least_preload)


_Forces = tuple[dict[str, np.ndarray], np.ndarray, dict[str, tuple[Arc, ...]], float]


def _single_cam_contact(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> _Forces:
    solution = contact_forces(cams["cam"], contact.load, contact.speed, phi)
    torque = np.where(solution.force > 0, solution.torque, 0.0)
    return {"cam": np.maximum(solution.force, 0.0)}, torque, {"cam": solution.lift_off}, solution.least_preload


def _groove_contact(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> _Forces | None:
    """Return the contact of a groove: where the inner flank would have to pull, the outer flank presses."""
    if "outer" not in cams:
        return None
    solution = contact_forces(cams["cam"], contact.load, contact.speed, phi)
    force = {"cam": np.maximum(solution.force, 0.0), "outer": np.maximum(-solution.force, 0.0)}
    return (
        force,
        solution.torque,
        {"cam": solution.lift_off, "outer": _remaining_arcs(solution.lift_off)},
        solution.least_preload,
    )


def _remaining_arcs(arcs: tuple[Arc, ...]) -> tuple[Arc, ...]:
    """Return the remaining arcs of the turn."""
    turn = 2 * np.pi
    if not arcs:
        return ((0.0, turn),)
    nexts = [begin for begin, _ in arcs[1:]] + [arcs[0][0] + turn]
    gaps = [(end % turn, end % turn + after - end) for (_, end), after in zip(arcs, nexts, strict=True)]
    return tuple((float(begin), float(end)) for begin, end in gaps if end > begin)


def _conjugate_contact(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> _Forces | None:
    if "counter" not in cams:
        return None
    pair = ConjugateCams(cams["cam"], cams["counter"])  # type: ignore[arg-type]  # a counter cam has a roller, and its cam too
    try:
        solution = conjugate_forces(pair, contact.load, contact.speed, phi, contact.share)
    except InputError as error:
        raise error.with_prefix("study.contact") if error.location == "preload" else error from None
    force = {"cam": solution.cam, "counter": solution.counter}
    return force, solution.torque, {"cam": solution.cam_off, "counter": solution.counter_off}, solution.least_preload


def dense_contact_history(contact: ContactLoad, cams: Mapping[str, Cam]) -> ContactHistory:
    """Return the contact at angles that are dense enough for the largest values."""
    return contact_history(contact, cams, GRID)
