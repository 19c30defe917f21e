"""A roller on a lever, and its cams: one, a groove, or two that hold the lever between them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Self

import numpy as np
from pydantic import Field, StrictBool, model_validator

from wucht.cams.cam import Cam
from wucht.cams.followers.follower import Outline
from wucht.cams.followers.roller_cam import RollerCam, RollerFollower
from wucht.cams.laws import Law
from wucht.cams.sizing.layout import Layout
from wucht.cams.sizing.size_limits import CamLimits, Size, SmallestCam
from wucht.cams.sizing.smallest_cam import Angles, check_length, smallest_roller_cam, tangents_of
from wucht.errors import InputError
from wucht.numerics.angles import TURN, valleys
from wucht.schema import SI, Composite, TableModel, composite, si

_DEAD = 1e-9  # sin sin: so near to zero a roller cannot drive the lever


class CounterTable(TableModel):
    """The lever of the counter cam, rigidly joined to that of the cam."""

    arm: SI[float] = si("m", "arm of the lever", gt=0)
    roller_radius: SI[float] = si("m", "radius of the roller", gt=0)
    angle: SI[float] = si("rad", "angle of the lever where the law is zero")


class OscillatingRoller(RollerFollower):
    """A roller on a lever."""

    # It turns about a pivot on +x; its law is an angle in rad, counter-clockwise. Where the law is zero it is at ``angle``
    # from +x: between -pi and 0 the roller goes out as the law rises, between 0 and pi in.

    kind: ClassVar[str] = "oscillating-roller"
    unit: ClassVar[str] = "rad"
    placing: ClassVar[tuple[str, ...]] = ("pivot", "angle")

    pivot: SI[float] = si("m", "distance of the lever's pivot from the cam's centre", gt=0)
    arm: SI[float] = si("m", "arm of the lever", gt=0)
    roller_radius: SI[float] = si("m", "radius of the roller", gt=0)
    angle: SI[float] = si("rad", "angle of the lever where the law is zero")
    counter: Composite[CounterTable | None] = composite(
        default=None,
        description="lever of a counter cam, rigidly joined to this one: a table with `arm`, `roller_radius` and `angle`",
    )
    groove: StrictBool = Field(default=False, description="groove for the roller, true or false")

    @model_validator(mode="after")
    def _check_exclusive(self) -> Self:
        if self.groove and self.counter is not None:
            raise ValueError("groove", "a groove holds the roller by itself: give either groove = true or a counter cam")
        return self

    def make_cams(self, law: Law) -> dict[str, Cam]:
        """See ``Follower``."""
        if (c := self.counter) is None:
            return super().make_cams(law)
        counter_follower = OscillatingRoller(pivot=self.pivot, arm=c.arm, roller_radius=c.roller_radius, angle=c.angle)
        cam, counter_cam = conjugate_cams(law, self, counter_follower, self.clockwise)
        return {"cam": cam, "counter": counter_cam}

    def place(self, value: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.asarray(self.pivot + self._arm(value))

    def rate(self, value: np.ndarray) -> np.ndarray:
        """See ``RollerFollower``."""
        return np.asarray(1j * self._arm(value))

    def centre(self, law: Law, phi: np.ndarray, order: int = 0) -> np.ndarray:
        """See ``RollerFollower``."""
        if order == 0:
            return self.place(law(phi))
        arm, s = self._arm(law(phi)), law(phi, 1)
        if order == 1:
            return np.asarray(1j * s * arm)
        q = law(phi, 2)
        if order == 2:
            return np.asarray((1j * q - s**2) * arm)
        return np.asarray((1j * law(phi, 3) - 3 * s * q - 1j * s**3) * arm)

    def _arm(self, value: np.ndarray) -> np.ndarray:
        return np.asarray(self.arm * np.exp(1j * (self.angle + np.asarray(value))))

    @property
    def output_arm(self) -> float:
        """See ``Follower``."""
        return self.arm

    def outline(self, law: Law) -> Outline:
        """See ``Follower``."""
        return Outline(pivot=self.pivot)

    def smallest_cam(self, law: Law, limits: CamLimits, size: Size) -> SmallestCam | None:
        """See ``Follower``."""
        if limits.pressure_angle is None:
            return None
        return smallest_lever_cam(
            law, self.arm, self.roller_radius, limits.pressure_angle, clockwise=self.clockwise,
            outward=math.sin(self.angle + float(law(0.0))) < 0,
            least_radius=limits.least_radius or 0.0, shaft_radius=limits.shaft_radius or 0.0, size=size,
        )  # fmt: skip

    def with_placement(self, placement: Mapping[str, float]) -> tuple[Self, tuple[str, ...]]:
        """See ``Follower``."""
        note = "the smallest cam is that of the main lever: for its pivot the lever of the counter cam must be chosen anew"
        follower, _ = super().with_placement(placement)
        return follower.model_copy(update={"counter": None}), () if self.counter is None else (note,)

    def swing(self, low: float, high: float) -> float:
        """See ``Guide``."""
        return high - low

    def distance_from(self, centre: complex) -> float:
        """See ``Guide``: a lever may be anywhere."""
        return math.inf

    def relative_to(self, centre: complex) -> OscillatingRoller:
        """See ``Guide``."""
        angle = math.remainder(math.pi - float(np.angle(centre)), TURN)
        return self.model_copy(update={"pivot": abs(centre), "angle": angle})


def conjugate_cams(
    law: Law, follower: OscillatingRoller, counter: OscillatingRoller, clockwise: bool = False
) -> tuple[RollerCam, RollerCam]:
    """Return the cam of a lever and the counter cam of another arm of the same lever.

    law: of the lever, in rad. counter: the other arm, with its length, roller and angle where the law is zero; about the
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
        theta, counter_theta = (_wrapped_degrees(f.angle + float(law(at[k]))) for f in (follower, counter))
        fault = f"at a cam angle of {math.degrees(at[k]):.4g} deg the rollers do not push the lever opposite ways"
        angles = f"its arms stand at {theta:.4g} and {counter_theta:.4g} deg"
        requirement = (
            f"{fault}: {angles}; one must be between -180 and 0 deg, the other between 0 and 180 deg, all the way round"
        )
        raise InputError("follower.counter.angle", counter.angle, requirement)
    return RollerCam(law, follower, clockwise), RollerCam(law, counter, clockwise)


def _wrapped_degrees(angle: float) -> float:
    """Return an angle in degrees, from -180 to 180."""
    return math.degrees(math.remainder(angle, 2 * math.pi))


def smallest_lever_cam(
    law: Law, arm: float, roller_radius: float, pressure_angle: Angles, *, clockwise: bool = False, outward: bool = True,
    least_radius: float | None = None, shaft_radius: float | None = None, size: Size = "base",
) -> SmallestCam:  # fmt: skip
    """Return the pivot's distance and the lever's angle that make the smallest cam for a lever.

    law: of the lever in rad. arm, roller_radius: in m. pressure_angle: the largest permitted one in rad, or two: for where the
    roller goes out, and for where it comes in. outward: the roller goes out as the law rises, else in. least_radius: the least
    permitted radius of curvature of the contour in m, where it is convex; 0 forbids undercut alone (that the roller cuts
    nothing elsewhere: ``RollerCam.check``); None permits all. shaft_radius: of shaft or hub, the least base circle of the
    contour in m; where it binds the pressure angle is as small as it then can be; None permits all. size: the base circle,
    or the largest radius ("blank").

    Raises ``InputError``: pressure_angle, with the least that is possible; law, where it does not move; least_radius,
    shaft_radius, arm, roller_radius, where they are not lengths. ``RunError``: the search failed, though there is one.
    """
    check_length("arm", arm)
    guide = OscillatingRoller.model_construct(pivot=0.0, arm=arm, roller_radius=roller_radius, angle=0.0)
    layout = Layout(law, guide, clockwise, -1 if outward else 1, tangents_of(pressure_angle))
    return smallest_roller_cam(layout, least_radius, shaft_radius, size)
