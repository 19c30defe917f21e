"""Loads on the contour: contact force, Hertzian pressure, lift-off, and the torque on the camshaft; without friction.

By virtual work. While the law moves by dpsi the contact force F, along the normal n, does the work F g dpsi; g = n . d(centre)/
dpsi is the grip: the arm times cos alpha on a lever, cos alpha on a rod, 1 on a flat face. The follower's equation of motion
gives F g. "Effort" is a generalised force on the follower: a torque in N m where the law is an angle in rad, a
force in N where it is a displacement in m; units below are given for both so: "N m or N".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.laws import Law
from wucht.cams.linkages.closure import LeverMotion
from wucht.errors import InputError
from wucht.numerics.angles import GRID, Arc, arcs_below_zero, valleys
from wucht.numerics.fourier_series import FourierSeries
from wucht.numerics.zeros_and_peaks import RealFunction

_Function = Law | FourierSeries
Speed = float | np.ndarray | Law | FourierSeries
# Of each cam by its name: force (N,), in N, and arcs without contact; with torque (N,) on the camshaft, and least preload.
CamForces = tuple[dict[str, np.ndarray], np.ndarray, dict[str, tuple[Arc, ...]], float]
_DEAD = 1e-6  # of the largest grip: less is none


@dataclass(frozen=True)
class FollowerLoad:
    """Inertia of the follower and the forces that act on it.

    Parameters
    ----------
    inertia : float
        kg m^2 of a lever, or kg.
    stiffness : float, optional
        Of a spring that draws the follower to where the law is zero, N m/rad or N/m.
    preload : float, optional
        Of this spring, the effort with which it presses the roller on the cam where the law is zero, N m or N.
    damping : float, optional
        N m s/rad or N s/m.
    constant : float, optional
        An effort against the sense in which the law rises, as a weight on a rod that rises, N m or N.
    output_inertia : float, optional
        Of what a linkage moves behind the follower, whose law is a ``LeverMotion`` then: kg m^2 or kg, as the output turns or
        slides.

    Raises
    ------
    InputError
        (inertia, output_inertia, stiffness, damping, preload, constant) Not finite, or one of the first four negative.
    """

    inertia: float
    stiffness: float = 0.0
    preload: float = 0.0
    damping: float = 0.0
    constant: float = 0.0
    output_inertia: float = 0.0

    def __post_init__(self) -> None:
        for name in ("inertia", "output_inertia", "stiffness", "damping"):
            if not (math.isfinite(value := getattr(self, name)) and value >= 0):
                raise InputError(name, value, "must be a finite number, not negative", code="negative")
        for name in ("preload", "constant"):
            if not math.isfinite(value := getattr(self, name)):
                raise InputError(name, value, "must be a finite number", code="not-finite")


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Loads on the contour and the camshaft, as long as the follower moves by its law.

    Attributes
    ----------
    phi : numpy.ndarray, (N,)
        In rad.
    force : numpy.ndarray, (N,)
        Along the normal in N, positive where it presses; a negative one cannot occur: the roller lifts off, or in a groove the
        other flank presses.
    effort : numpy.ndarray, (N,)
        Of the contact on the follower, in the sense of the law, N m or N.
    torque : numpy.ndarray, (N,)
        That the camshaft must be given in the sense in which it turns, N m. Effort and torque have the sign of the force, and
        where the roller lifts off do not exist either.
    lift_off : tuple of (float, float)
        Arcs of the cam angle in rad, (begin, end), without contact.
    least_preload : float
        The preload from which on there are none, N m or N; not negative.
    """

    phi: np.ndarray
    force: np.ndarray
    effort: np.ndarray
    torque: np.ndarray
    lift_off: tuple[Arc, ...]
    least_preload: float


@dataclass(frozen=True)
class Material:
    """modulus: Young's, in Pa. poisson: Poisson's ratio. Raises ``InputError`` (modulus, poisson)."""

    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.modulus) and self.modulus > 0):
            raise InputError("modulus", self.modulus, "must be greater than zero (in Pa)")
        if not -1 < self.poisson <= 0.5:
            raise InputError("poisson", self.poisson, "must lie between -1 and 0.5")

    @property
    def compliance(self) -> float:
        """(1 - nu^2)/E in 1/Pa."""
        return (1 - self.poisson**2) / self.modulus


def contact_forces(cam: Cam, load: FollowerLoad, speed: Speed, phi: np.ndarray) -> ContactForces:
    """Return the forces between a cam and a follower that moves by its law.

    Parameters
    ----------
    cam : Cam
    load : FollowerLoad
    speed : float, numpy.ndarray (M,), or callable
        Of the camshaft in rad/s: a number; or samples, evenly spaced over a turn of the cam from phi = 0; or a function of the
        cam angle as a law is. Where it varies the acceleration is psi'' omega^2 + psi' omega omega'.
    phi : numpy.ndarray, (N,)
        Cam angles in rad.

    Returns
    -------
    ContactForces

    Raises
    ------
    InputError
        speed: negative or no number; follower: where the contact force passes through the pivot.
    """
    sense, effort = _sense(cam), _required_effort(cam, load, speed)
    pressing = sense * effort(phi) + load.preload

    def pressing_effort(at: np.ndarray) -> np.ndarray:
        return np.asarray(sense * effort(at) + load.preload)

    minima, least = valleys(pressing_effort)
    return ContactForces(
        phi,
        pressing / np.abs(cam.grip(phi)),
        sense * pressing,
        sense * pressing * cam.law(phi, 1),
        arcs_below_zero(pressing_effort, minima),
        max(load.preload - float(least.min()), 0.0),
    )


def conjugate_forces(
    cam: Cam, counter: Cam, load: FollowerLoad, speed: Speed, phi: np.ndarray, share: float = 0.5
) -> CamForces:
    """The forces of two cams at angles phi (N,), none negative, whose levers are joined and move by one law.

    ``load.preload`` is the torque with which they squeeze the lever at rest; from the least one on both touch everywhere.

    share: of the torque that drives the lever, the part added to the cam's load; the rest relieves the counter cam: its share
    in the stiffness of the two contacts, 1/2 where they are alike, 1 where the counter arm is pressed on by a soft spring. It
    holds as long as both touch; then one of them has all. Raises ``InputError`` (share; speed and follower as above).
    """
    if not 0 <= share <= 1:
        raise InputError("share", share, "must lie between 0 and 1")
    preload = load.preload
    if preload < 0:
        raise InputError("preload", preload, "two cams squeeze their lever: it must not be negative")
    sense, effort = _sense(cam), _required_effort(cam, load, speed)
    _sense(counter)

    def cam_effort(at: np.ndarray) -> np.ndarray:
        return np.asarray(preload + share * sense * effort(at))

    def counter_effort(at: np.ndarray) -> np.ndarray:
        return np.asarray(preload - (1 - share) * sense * effort(at))

    need, first, second = sense * effort(phi), cam_effort(phi), counter_effort(phi)
    driving = np.where(first < 0, 0.0, np.where(second < 0, need, first)) / np.abs(cam.grip(phi))
    returning = np.where(second < 0, 0.0, np.where(first < 0, -need, second)) / np.abs(counter.grip(phi))
    torque = effort(phi) * cam.law(phi, 1)
    (at, least), (counter_at, counter_least) = valleys(cam_effort), valleys(counter_effort)
    lift_off = {"cam": arcs_below_zero(cam_effort, at), "counter": arcs_below_zero(counter_effort, counter_at)}
    least_preload = preload - min(float(least.min()), float(counter_least.min()))
    return {"cam": driving, "counter": returning}, torque, lift_off, max(least_preload, 0.0)


def _required_effort(cam: Cam, load: FollowerLoad, speed: Speed) -> RealFunction:
    """The effort in the sense of the law that moves the follower against all but the preload."""
    law, omega = cam.law, _speed(speed)

    def effort(phi: np.ndarray) -> np.ndarray:
        w, slope = omega(phi), omega(phi, 1)

        def acceleration(motion: Law) -> np.ndarray:
            return np.asarray(motion(phi, 2) * w**2 + motion(phi, 1) * w * slope)

        springs = load.damping * law(phi, 1) * w + load.stiffness * law(phi) + load.constant
        inertial = load.inertia * acceleration(law)
        if load.output_inertia and isinstance(law, LeverMotion):
            transmission = 1 / law.linkage.lever_at(law.law(phi), 1)  # dpsi/drho
            inertial = inertial + load.output_inertia * transmission * acceleration(law.law)
        return np.asarray(inertial + springs)

    return effort


def _speed(speed: Speed) -> _Function:
    omega = speed if callable(speed) else _speed_series(np.asarray(speed, float))
    if not (np.isfinite(omega(GRID)) & (omega(GRID) >= 0)).all():
        raise InputError("speed", None, "it must be finite and nowhere negative (in rad/s)", code="negative")
    return omega


def _speed_series(values: np.ndarray) -> FourierSeries:
    if values.ndim == 0:
        return FourierSeries.of(float(values))
    if values.ndim != 1 or len(values) < 3:
        raise InputError("speed", None, "must be a number, or a row of 3 samples or more over a turn of the cam", code="shape")
    return FourierSeries.from_samples(values)


def _sense(cam: Cam) -> int:
    """Return the sense of the law in which the contact drives the follower."""
    grips = cam.grip(GRID)
    sense = 1 if grips[0] > 0 else -1
    k = int(np.argmin(sense * grips))
    if sense * grips[k] <= _DEAD * np.abs(grips).max():
        fault = f"at a cam angle of {math.degrees(GRID[k]):.4g} deg the contact force does not drive it"
        raise InputError("follower", None, f"{fault}: the pressure angle reaches 90 deg")
    return sense


def hertz_pressure(
    force: np.ndarray, width: float, curvature: np.ndarray, roller_curvature: float, materials: tuple[Material, Material]
) -> np.ndarray:
    """The largest pressure in Pa (N,) between two cylinders in line contact; 0 where the force is not positive.

    p = sqrt(F/(pi b) (kappa + 1/r)/((1 - nu1^2)/E1 + (1 - nu2^2)/E2)): K. L. Johnson, Contact Mechanics, Cambridge 1985,
    eq. (4.45). force (N,) in N. width: of the contact in m. curvature (N,): of the cam in 1/m, negative where its material is
    hollow, not below that of the roller. roller_curvature: 1/r in 1/m, 0 of a flat face.
    Raises ``InputError``: width; follower.roller_radius, where the contour is more hollow than the roller.
    """
    if not (math.isfinite(width) and width > 0):
        raise InputError("width", width, "must be greater than zero (in m)")
    relative = np.asarray(curvature) + roller_curvature
    if (relative < 0).any():
        hollow = float(-1 / np.min(curvature))
        raise InputError("follower.roller_radius", 1 / roller_curvature if roller_curvature else None,
                         f"the contour is more hollow than the roller: take at most {hollow:.6g} m")  # fmt: skip
    compliance = materials[0].compliance + materials[1].compliance
    return np.asarray(np.sqrt(np.maximum(force, 0.0) / (math.pi * width) * relative / compliance))


def contact_pressure(
    cam: Cam, force: np.ndarray, phi: np.ndarray, width: float, materials: tuple[Material, Material]
) -> np.ndarray:
    """The Hertzian pressure in Pa (N,) of contact forces (N,) at cam angles phi (N,); see ``hertz_pressure``.

    width: of the contact in m. materials: of cam and roller (or face). Raises ``InputError`` as that does, and as
    ``Cam.check`` does where the contour is undercut at these angles: there is none.
    """
    if (cam.undercut(phi) <= 0).any():
        cam.check()
    return hertz_pressure(force, width, cam.material * cam.curvature(phi), cam.mating_curvature, materials)
