"""Conjugate cams: two cams on one shaft hold a lever between them, one drives it out and the other one back."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import RollerCam
from wucht.cams.followers import OscillatingRoller
from wucht.cams.laws.law import Law
from wucht.errors import InputError
from wucht.numerics.valleys import valleys

_DEAD = 1e-9  # sin sin: so near to zero a roller cannot drive the lever


@dataclass(frozen=True)
class ConjugateCams:
    """cam, counter: on one shaft; their levers are rigidly joined and move by one law."""

    cam: RollerCam
    counter: RollerCam


def conjugate_cams(law: Law, follower: OscillatingRoller, counter: OscillatingRoller, clockwise: bool = False) -> ConjugateCams:
    """The cam of a lever and the counter cam of another arm of the same lever.

    law: of the lever, in rad. counter: the other arm, with its own length, roller and angle where the law is zero; about the
    same pivot. A roller that its cam pushes outwards turns the lever by the sense of -sin theta, theta being the angle of its
    arm: the two hold the lever where sin theta sin theta_counter < 0 (cam-mathematics, "counter cam").

    Raises ``InputError``: follower.counter.pivot, another pivot; follower.counter.angle, where at some cam angle both push the
    lever the same way, or one stands in line with cam centre and pivot.
    """
    if counter.pivot != follower.pivot:
        raise InputError("follower.counter.pivot", counter.pivot, f"must be that of the lever, {follower.pivot:.9g} m")

    def hold(phi: np.ndarray) -> np.ndarray:
        return np.asarray(-np.sin(follower.angle + law(phi)) * np.sin(counter.angle + law(phi)))

    at, holds = valleys(hold)
    k = int(np.argmin(holds))
    if holds[k] < _DEAD:
        theta, other = (_degrees(f.angle + float(law(at[k]))) for f in (follower, counter))
        where = f"at a cam angle of {math.degrees(at[k]):.4g} deg the rollers do not push the lever opposite ways"
        angles = f"its arms stand at {theta:.4g} and {other:.4g} deg"
        allowed = f"{where}: {angles}; one must be between -180 and 0 deg, the other between 0 and 180 deg, all the way round"
        raise InputError("follower.counter.angle", counter.angle, allowed)
    return ConjugateCams(RollerCam(law, follower, clockwise), RollerCam(law, counter, clockwise))


def _degrees(angle: float) -> float:
    """From -180 to 180."""
    return math.degrees(math.remainder(angle, 2 * math.pi))
