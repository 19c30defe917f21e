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
class Pressed:
    """Contact of each cam over cam angles phi (N,) in rad: force (N,) in N, none negative, and pressure (N,) in Pa.

    torque (N,): driving torque of the camshaft in N m, 0 without contact. lift_off: arcs without contact, (begin, end) in rad.
    least_preload: above which there are no such arcs, in N m or N.
    """

    phi: np.ndarray
    force: Mapping[str, np.ndarray]
    pressure: Mapping[str, np.ndarray]
    torque: np.ndarray
    off: Mapping[str, tuple[Arc, ...]]
    least_preload: float


def contact_load(spec: CamContour, drive: CamDrive, unit: str) -> ContactLoad | None:
    """Return the load that the spec states. unit: of the follower's motion, rad or m.

    Raises ``InputError`` (study.contact..., study.speed).
    """
    asked = spec.contact
    if asked is None:
        return None
    given, inertia = _moved(asked, unit, "follower")
    if inertia is None:
        needed = "moment of inertia in kg m^2 about its pivot" if unit == "rad" else "mass in kg"
        raise InputError(
            f"study.contact.{given}", None, f"this key is missing; needed is the follower's {needed}", code="missing"
        )
    quantities = {key: read_quantity(of, getattr(asked, key), f"study.contact.{key}") for key, of in _UNITS[unit].items()}
    behind = _behind(asked, drive)
    try:
        load = FollowerLoad(inertia, **quantities, output_inertia=behind)
    except InputError as error:
        raise error.within("study.contact") from None
    return ContactLoad(load, *_speed(spec, drive), asked.share, asked.width, _materials(asked))


def _moved(asked: Contact, unit: str, what: str) -> tuple[str, float | None]:
    """Return the key of the inertia or mass of a follower or output, and its value; the excluded key must not be given."""
    prefix = "output_" if what == "output" else ""
    given, other = (prefix + kind for kind in (("inertia", "mass") if unit == "rad" else ("mass", "inertia")))
    if getattr(asked, other) is not None:
        turns = "turns: give its inertia in kg m^2" if unit == "rad" else "slides: give its mass in kg"
        raise InputError(f"study.contact.{other}", getattr(asked, other), f"the {what} {turns}")
    return given, getattr(asked, given)


def _behind(asked: Contact, drive: CamDrive) -> float:
    """Return the inertia or mass that a linkage moves, in kg m^2 or kg."""
    if drive.linkage is not None:
        return _moved(asked, drive.motion.unit, "output")[1] or 0.0
    for key in ("output_inertia", "output_mass"):
        if getattr(asked, key) is not None:
            allowed = "without a linkage the follower is the output: add this value to that of the follower"
            raise InputError(f"study.contact.{key}", getattr(asked, key), allowed)
    return 0.0


def _speed(spec: CamContour, drive: CamDrive) -> tuple[Speed, float]:
    if spec.speed is not None:
        return spec.speed, spec.speed
    if spec.corrected:
        return SpeedOverAngle(drive.turning_with_corrected_cam), drive.turning_with_corrected_cam.mean
    if drive.speed is None:
        allowed = "the contact force needs the speed of the camshaft: speed = '500 rpm', or a table [speed]"
        raise InputError("study.speed", None, allowed)
    return SpeedOverAngle(drive.turning), drive.turning.mean


def _materials(asked: Contact) -> tuple[Material, Material]:
    roller_modulus = asked.modulus if asked.roller_modulus is None else asked.roller_modulus
    roller_poisson = asked.poisson if asked.roller_poisson is None else asked.roller_poisson
    return Material(asked.modulus, asked.poisson), Material(roller_modulus, roller_poisson)


def pressed(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> Pressed:
    """Return the contact at cam angles (N,). Raises ``InputError`` (study.contact.preload, follower)."""
    forces = _of_pair(contact, cams, phi) or _of_groove(contact, cams, phi) or _of_one(contact, cams, phi)
    force, torque, off, least_preload = forces
    pressure = dict[str, np.ndarray]()
    if contact.width is not None:
        for name, cam in cams.items():
            try:
                pressure[name] = contact_pressure(cam, force[name], phi, contact.width, contact.materials)
            except InputError as error:
                raise error.within("study.contact") if error.where == "width" else error from None
    return Pressed(phi, force, pressure, torque, off, least_preload)


_Forces = tuple[dict[str, np.ndarray], np.ndarray, dict[str, tuple[Arc, ...]], float]


def _of_one(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> _Forces:
    found = contact_forces(cams["cam"], contact.load, contact.speed, phi)
    torque = np.where(found.force > 0, found.torque, 0.0)
    return {"cam": np.maximum(found.force, 0.0)}, torque, {"cam": found.lift_off}, found.least_preload


def _of_groove(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> _Forces | None:
    """Return the contact of a groove: where the inner flank would have to pull, the outer flank presses."""
    if "outer" not in cams:
        return None
    found = contact_forces(cams["cam"], contact.load, contact.speed, phi)
    force = {"cam": np.maximum(found.force, 0.0), "outer": np.maximum(-found.force, 0.0)}
    return force, found.torque, {"cam": found.lift_off, "outer": _between(found.lift_off)}, found.least_preload


def _between(arcs: tuple[Arc, ...]) -> tuple[Arc, ...]:
    """Return the remaining arcs of the turn."""
    turn = 2 * np.pi
    if not arcs:
        return ((0.0, turn),)
    nexts = [begin for begin, _ in arcs[1:]] + [arcs[0][0] + turn]
    gaps = [(end % turn, end % turn + after - end) for (_, end), after in zip(arcs, nexts, strict=True)]
    return tuple((float(begin), float(end)) for begin, end in gaps if end > begin)


def _of_pair(contact: ContactLoad, cams: Mapping[str, Cam], phi: np.ndarray) -> _Forces | None:
    if "counter" not in cams:
        return None
    pair = ConjugateCams(cams["cam"], cams["counter"])  # type: ignore[arg-type]  # a counter cam has a roller, and its cam too
    try:
        found = conjugate_forces(pair, contact.load, contact.speed, phi, contact.share)
    except InputError as error:
        raise error.within("study.contact") if error.where == "preload" else error from None
    force = {"cam": found.cam, "counter": found.counter}
    return force, found.torque, {"cam": found.cam_off, "counter": found.counter_off}, found.least_preload


def largest_pressed(contact: ContactLoad, cams: Mapping[str, Cam]) -> Pressed:
    """Return the contact at angles that are dense enough for the largest values."""
    return pressed(contact, cams, GRID)
