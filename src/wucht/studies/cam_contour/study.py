"""Contour of a cam: its keys, what of it is checked before, and its computation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from wucht.cams.cam import Cam
from wucht.cams.contact_history import ContactHistory, ContactLoad, contact_history, dense_contact_history
from wucht.cams.drive import CamDrive
from wucht.cams.drive_cams import DriveCams
from wucht.cams.followers.follower import Follower
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.shape import Shape, shapes
from wucht.cams.sizing.size_limits import CamLimits, Size, SmallestCam
from wucht.cams.tables.contact_table import Contact
from wucht.cams.workshop.points import SPACING, rounding_warning
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.numerics.fourier_series import FourierSeries
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import CURVES, state_cam_curves, state_motion, warn_of_jumps
from wucht.studies.cam_contour import answer
from wucht.studies.cam_contour.export import write_workshop
from wucht.studies.cam_contour.figure import draw_contour
from wucht.studies.cam_workshop import file_lines, mill_points
from wucht.studies.key_types import TrueOrFalse, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Prepared = tuple[DriveCams, dict[str, Shape], ContactLoad | None, SmallestCam | RunError | None]


class CamContour(Study):
    """Contour of a cam that gives its follower the motion law: checked against limits, and as points to mill."""

    kind = "cam-contour"
    next_questions = (
        NextQuestion("the power that the shaft takes, and its fluctuation", {"study.kind": "cam-prediction"}),
        NextQuestion("the motion of the output over the cam angle", {"study.kind": "cam-law"}),
    )
    solves = "rigid parts; forces at the speed of study.speed, or of the table [speed]"
    subject = "wucht.studies.cam_drives:CAM_DRIVE"
    curves = (("cam_angle", "curvature"), ("cam_angle", "pressure_angle"))

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
        """Return the question, see ``Study``: where a speed is stated, ``corrected = false`` differs from no such key."""
        question = self.to_table()
        if subject.speed is not None and "corrected" not in self.model_fields_set:
            del question["corrected"]
        return question

    def check(self) -> None:
        """See ``Study``."""
        pressure = None if self.permitted is None else self.permitted.contact_pressure
        if pressure is not None and (self.contact is None or self.contact.width is None):
            requirement = "the contact pressure needs study.contact with the width of the contact"
            raise InputError("study.permitted.contact_pressure", None, requirement)

    def prepare(self, drive: CamDrive) -> Prepared:
        """Return the cams with their shapes, the load of the contact, and the smallest cam, or why none was found.

        Raises ``InputError`` where there is no such cam: which key, and what to do.
        """
        follower = drive.required_follower
        cams = DriveCams.of(drive, self._shaft_motion(drive), self.corrected)
        contact, smallest = self._contact_load(drive), self._smallest_cam(follower, cams.follower_law)
        try:
            of_cams = shapes(cams.cams, allow_undercut=self.allow_undercut, wheel_radius=self.wheel_radius)
        except InputError as error:
            raise error.with_prefix("study") if error.location == "wheel_radius" else error from None
        return cams, of_cams, contact, smallest

    def _shaft_motion(self, drive: CamDrive) -> ShaftMotion | None:
        if self.corrected:
            return drive.corrected_shaft_motion
        return None if drive.speed is None else drive.shaft_motion

    def _contact_load(self, drive: CamDrive) -> ContactLoad | None:
        """Return the load of the contact. Raises ``InputError`` (study.contact..., study.speed)."""
        contact = self.contact
        if contact is None:
            return None
        try:
            load = contact.follower_load(drive)
        except InputError as error:
            raise error.with_prefix("study.contact") from None
        if self.speed is not None:
            return ContactLoad(load, self.speed, self.speed, contact.share, contact.width, contact.materials)
        shaft = self._shaft_motion(drive)
        if shaft is None:
            requirement = "the contact force needs the speed of the camshaft: speed = '500 rpm', or a table [speed]"
            raise InputError("study.speed", None, requirement)
        return ContactLoad(load, shaft.speed_over_angle, shaft.mean, contact.share, contact.width, contact.materials)

    def _smallest_cam(self, follower: Follower, law: Law) -> SmallestCam | RunError | None:
        """Return the smallest cam, the reason why none was found, or None where no limit is given that determines it.

        Without a permitted least radius no undercut is allowed; without a shaft radius the base circle must not be negative.
        Raises ``InputError`` (study.permitted...).
        """
        if self.permitted is None:
            return None
        try:
            return follower.smallest_cam(law, self.permitted, self.smallest)
        except InputError as error:
            raise error.with_prefix("study.permitted") if error.location in CamLimits.model_fields else error from None
        except RunError as error:
            return error

    def solve(self, drive: CamDrive, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Compute contours, points to mill and the contact; the whole takes a second."""
        cams, of_cams, contact, smallest = prepared
        a, angles = Answer(), np.linspace(0, 2 * np.pi, self.points + 1)
        is_whole, lever_unit = not any(s.missing or s.undercut for s in of_cams.values()), drive.required_follower.unit
        answer.state_version(a, cams, "corrected" in self.model_fields_set)
        if contact is not None and drive.linkage is not None and not contact.load.output_inertia:
            key = "output_inertia" if drive.motion_law.unit == "rad" else "output_mass"
            a.warn(f"contact forces are those of the lever alone: study.contact.{key} adds what the linkage moves")
        answer.warn_of_smallest_cam(a, cams, smallest)
        work.report(0.0, "contours")
        a.curve("cam", list(cams.cams), "cam")
        a.curve("cam_angle", angles, "cam angle", "rad")
        every = [*cams.cams.values()]
        state_cam_curves(a, CURVES, every, angles, "cam cam_angle", (len(every), len(angles)))
        work.report(0.3, "points to mill")
        points = mill_points(cams.cams, self.chord_tolerance, self.spacing) if is_whole else {}
        for name, of_cam in points.items():
            coarse = rounding_warning(cams.cams[name].contour, of_cam, 1e-3 * 10.0**-self.decimals)
            a.warn(*([f"{name}: {coarse}"] if coarse else []))
        if not is_whole:
            a.warn("no points to mill: part of the contour is cut away")
        work.report(0.8, "contact")
        history = dense_history = None
        if contact is not None and is_whole:
            history, dense_history = self._contact(contact, cams.cams, angles)
        elif contact is not None:
            a.warn("no contact forces: part of the contour is cut away, so that the follower does not move by its law")
        warn_of_jumps(a, drive.motion_law)
        answer.state_contact_curves(a, cams.cams, angles, history)
        for name, law, unit in (("output", cams.law, drive.motion_law.unit), ("follower", cams.follower_law, lever_unit)):
            state_motion(a, name, (law(angles, order) for order in range(3)), name, unit)
        transmission = None if drive.closure is None else drive.closure.transmission_angle(cams.follower_law(angles))
        nowhere = np.full(len(angles), np.nan)
        a.curve(
            "transmission_angle", nowhere if transmission is None else transmission, "transmission angle", "rad", "cam_angle"
        )
        answer.state_arcs(a, of_cams, dense_history)
        answer.state_points(a, points)
        answer.state_layout(a, cams, of_cams, self.permitted, self.wheel_radius)
        answer.state_cams(a, of_cams, points)
        least = None if transmission is None else float(transmission.min())
        a.number("min_transmission_angle", least, "least transmission angle of the linkage", "rad")
        a.line("transmission", "angle of the linkage at least {min_transmission_angle}")
        shaft = cams.shaft if self.speed is None else ShaftMotion(FourierSeries.of(self.speed))
        answer.state_acceleration(a, cams.law, shaft, drive.motion_law.unit)
        answer.state_contact(a, contact, dense_history, "N m" if lever_unit == "rad" else "N")
        answer.state_smallest_cam(a, smallest)
        answer.state_tolerances(a, points, self.chord_tolerance, self.spacing, self.decimals)
        answer.state_verdict(a, cams, of_cams, self.permitted, dense_history)
        yield a

    def _contact(
        self, contact: ContactLoad, cams: Mapping[str, Cam], angles: np.ndarray
    ) -> tuple[ContactHistory, ContactHistory]:
        """Return the contact at the angles, and at denser ones. Raises ``InputError`` (study.contact.preload, follower)."""
        try:
            return contact_history(contact, cams, angles), dense_contact_history(contact, cams)
        except InputError as error:
            raise error.with_prefix("study.contact") if error.location in Contact.model_fields else error from None

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the cam above, and below it two panels a row: radius of curvature, pressure angle, and further criteria."""
        return draw_contour(result)

    def export(self, result: xr.Dataset, folder: Path) -> list[str]:
        """Write points to mill, drawings and cam tables; see ``write_workshop``."""
        return file_lines(write_workshop(result, folder))
