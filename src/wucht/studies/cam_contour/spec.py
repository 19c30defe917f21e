"""Spec of a study of a cam's contour."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from wucht.cams.sizing.size_limits import CamLimits, Size
from wucht.cams.workshop.points import SPACING
from wucht.errors import InputError
from wucht.schema import SI, Composite, TableModel, composite, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import Spec, TrueOrFalse, Value, Whole


class Contact(TableModel):
    """Inertia, spring and load of the follower; for a lever about its pivot, for a rod along its axis."""

    inertia: SI[float | None] = si("kg m^2", "moment of inertia of the follower", default=None, ge=0, help=(
        "moment of inertia of a lever about its pivot, in kg m^2"
    ))  # fmt: skip
    mass: SI[float | None] = si("kg", "mass of the follower", default=None, ge=0, help="mass of a rod, in kg")
    output_inertia: SI[float | None] = si("kg m^2", "moment of inertia of the output", default=None, ge=0, help=(
        "moment of inertia of an output behind a linkage, in kg m^2"
    ))  # fmt: skip
    output_mass: SI[float | None] = si(
        "kg", "mass of the output", default=None, ge=0, help="mass of an output behind a linkage"
    )
    preload: Value = Field(default=0.0, title="preload", description=(
        "torque or force (N m or N) with which a spring presses the roller on the cam where the law is zero; for two "
        "cams, with which they squeeze the lever"
    ))  # fmt: skip
    stiffness: Value = Field(
        default=0.0, title="stiffness of the spring", description="stiffness of this spring, in N m/rad or N/m"
    )
    damping: Value = Field(default=0.0, title="damping", description="viscous damping of the follower, in N m s/rad or N s/m")
    constant: Value = Field(
        default=0.0,
        title="constant load",
        description="constant load (N m or N) against the sense in which the law rises, as a weight",
    )
    share: SI[float] = si("", "share of the cam in the driving torque", default=0.5, ge=0, le=1, help=(
        "of two cams, share of the driving torque that raises the force on the cam; the rest lowers that on the counter cam"
    ))  # fmt: skip
    width: SI[float | None] = si(
        "m", "width of the contact", default=None, gt=0, help="width of the contact; with it the Hertzian pressure is computed"
    )
    modulus: SI[float] = si("Pa", "Young's modulus of the cam", default=210e9, gt=0)
    poisson: SI[float] = si("", "Poisson's ratio of the cam", default=0.3, gt=-1, le=0.5)
    roller_modulus: SI[float | None] = si("Pa", "Young's modulus of the roller", default=None, gt=0, help=(
        "Young's modulus of the roller or face, where it differs from the cam's"
    ))  # fmt: skip
    roller_poisson: SI[float | None] = si("", "Poisson's ratio of the roller", default=None, gt=-1, le=0.5, help=(
        "Poisson's ratio of the roller or face, where it differs from the cam's"
    ))  # fmt: skip


class CamContour(Spec):
    """Contour of a cam that gives its follower the motion law: checked against limits, and as points to mill."""

    kind: ClassVar[str] = "cam-contour"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("the power that the shaft takes, and its fluctuation", {"study.kind": "cam-prediction"}),
        NextQuestion("the motion of the output over the cam angle", {"study.kind": "cam-law"}),
    )
    solves: ClassVar[str] = "rigid parts; forces at the speed of study.speed, or of the table [speed]"
    subject: ClassVar[str] = "wucht.studies.cam_drives:CAM_DRIVE"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("cam_angle", "curvature"), ("cam_angle", "pressure_angle"))

    points: Whole = Field(
        default=720,
        ge=16,
        le=1_000_000,
        description="number of cam angles, evenly spaced over a turn, at which the contour is given",
    )
    chord_tolerance: SI[float] = si("m", "chord tolerance", default=1e-6, gt=0, help=(
        "largest distance between the contour and the chords of the points to mill; it determines the number of points"
    ))  # fmt: skip
    spacing: SI[float] = si("m", "greatest distance between points to mill", default=SPACING, gt=0, help=(
        "longest chord: where the contour is nearly straight, wide gaps beside narrow ones would spoil a spline through the "
        "points"
    ))  # fmt: skip
    decimals: Whole = Field(default=5, ge=0, le=12, description="number of decimals of the coordinates in mm")
    wheel_radius: SI[float | None] = si("m", "radius of the grinding wheel", default=None, gt=0, help=(
        "radius of the grinding wheel or cutter, which must reach the hollow parts"
    ))  # fmt: skip
    speed: SI[float | None] = si("rad/s", "speed of the camshaft", default=None, gt=0, help=(
        "speed of the camshaft, for the contact; by default that of the table [speed]"
    ))  # fmt: skip
    contact: Composite[Contact | None] = composite(
        default=None, description="loads of the contact, a table `[study.contact]`; without it no forces"
    )
    permitted: Composite[CamLimits | None] = composite(
        default=None, description="limits that the cam must keep, a table `[study.permitted]`"
    )
    smallest: Size = Field(default="base", description=(
        'radius to be minimised for the smallest cam, that of the base circle ("base") or the largest one ("blank")'
    ))  # fmt: skip
    allow_undercut: TrueOrFalse = Field(default=False, description="if true, an undercut contour is shown instead of refused")
    corrected: TrueOrFalse = Field(default=False, description=(
        "if true, the cam makes the law over time on a shaft that turns as the table [speed] states, or, without that table, "
        "as predicted from the table [shaft]; if false, it makes the law over the cam angle, which the result warns of where "
        "the key is not given and the stated speed fluctuates"
    ))  # fmt: skip

    def table_for(self, subject: Any) -> dict[str, Any]:
        """Return the question, see ``Spec``: where a speed is stated, ``corrected = false`` differs from no such key."""
        question = self.to_table()
        if subject.speed is not None and "corrected" not in self.model_fields_set:
            del question["corrected"]
        return question

    def check(self) -> None:
        """See ``Spec``."""
        pressure = None if self.permitted is None else self.permitted.contact_pressure
        if pressure is not None and (self.contact is None or self.contact.width is None):
            requirement = "the contact pressure needs study.contact with the width of the contact"
            raise InputError("study.permitted.contact_pressure", None, requirement)
