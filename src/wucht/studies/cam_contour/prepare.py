"""Question and cam drive -> plan: the cams, checked for what cannot be made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from wucht.cams.cam import Cam
from wucht.cams.correction import CorrectedLaw
from wucht.cams.demands import millimetres
from wucht.cams.drive import CamDrive
from wucht.cams.followers.follower import Follower
from wucht.cams.laws.law import Law
from wucht.cams.shape import Shape, shapes
from wucht.cams.sizing.permitted import Permitted, Size, Smallest
from wucht.errors import InputError, RunError
from wucht.studies.cam_contour.contact_load import ContactLoad, contact_load
from wucht.studies.cam_contour.spec import CamContour


@dataclass(frozen=True, eq=False)
class Plan:
    """output: its law over the cam angle. lever: the follower's. shapes: what the checks have found of each cam. notes:
    warnings for the result."""

    spec: CamContour
    drive: CamDrive
    output: Law
    lever: Law
    cams: Mapping[str, Cam]
    shapes: Mapping[str, Shape]
    contact: ContactLoad | None
    smallest: Smallest | None
    notes: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """Of the follower's motion: rad or m."""
        return self.drive.follower.unit if self.drive.follower is not None else "rad"

    @property
    def whole(self) -> bool:
        """Whether nothing is cut away of any cam."""
        return not any(shape.missing or shape.undercut for shape in self.shapes.values())


def prepare(spec: CamContour, drive: CamDrive) -> Plan:
    """The plan. Raises ``InputError`` where there is no such cam: which key, and what to do."""
    law, notes = drive.motion.law, list[str]()
    if spec.corrected:
        law = CorrectedLaw(law, drive.turning_with_corrected_cam)
    cams = drive.cams(law)
    lever, follower = drive.lever(law), drive.follower
    unit = follower.unit if follower is not None else "rad"
    contact = contact_load(spec, drive, unit)
    if contact is not None and drive.linkage is not None and not contact.load.output_inertia:
        key = "output_inertia" if drive.motion.unit == "rad" else "output_mass"
        notes.append(f"the contact forces are those of the lever alone: study.contact.{key} is what the linkage moves")
    try:
        smallest = smallest_cam(lever, follower, spec.permitted, spec.smallest)
        notes += obstacles(drive, law, smallest) if smallest is not None else []
    except RunError as error:
        smallest = None
        notes.append(f"no smallest cam: {error}")
    return Plan(spec, drive, law, lever, cams, _shapes(cams, spec), contact, smallest, tuple(notes))


def _shapes(cams: Mapping[str, Cam], spec: CamContour) -> dict[str, Shape]:
    try:
        return shapes(cams, allow_undercut=spec.allow_undercut, wheel_radius=spec.wheel_radius)
    except InputError as error:
        raise error.within("study") if error.where == "wheel_radius" else error from None


def smallest_cam(law: Law, follower: Follower | None, permitted: Permitted | None, size: Size) -> Smallest | None:
    """Of the follower's law; None where nothing is permitted that it could be found by.

    Where no least radius is permitted nothing is to be undercut, and without a shaft the base circle is not to be negative.
    Raises ``InputError`` (study.permitted...), ``RunError``.
    """
    if permitted is None or follower is None:
        return None
    try:
        return follower.smallest(law, permitted, size)
    except InputError as error:
        raise error.within("study.permitted") if error.where in Permitted.model_fields else error from None


def obstacles(drive: CamDrive, output: Law, smallest: Smallest) -> list[str]:
    """What must be known before the smallest cam is made, in sentences. output: the law that it is to make."""
    if drive.follower is None:
        return []
    follower, anew = drive.follower.moved_to(smallest.placed)
    notes, made = list(anew), replace(drive, follower=follower)
    try:
        for cam in made.cams(output).values():
            if not smallest.whole:
                cam.check(millimetres)
    except InputError as error:
        notes.append(f"the smallest cam that is permitted cannot be made: {error.allowed}")
    return notes
