"""Question and cam drive -> plan: the cams, checked for what cannot be made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wucht.cams.correction import CorrectedLaw
from wucht.cams.drive import CamDrive
from wucht.cams.laws.law import Law
from wucht.errors import RunError
from wucht.studies.cam_contour.contact_load import ContactLoad, contact_load
from wucht.studies.cam_contour.permitted_cam import Smallest, obstacles, smallest_cam
from wucht.studies.cam_contour.shapes import AnyCam, Shape, shapes
from wucht.studies.cam_contour.spec import CamContour


@dataclass(frozen=True, eq=False)
class Plan:
    """output: its law over the cam angle. lever: the follower's. shapes: what the checks have found of each cam. notes:
    warnings for the result."""

    spec: CamContour
    drive: CamDrive
    output: Law
    lever: Law
    cams: Mapping[str, AnyCam]
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
    return Plan(spec, drive, law, lever, cams, shapes(cams, spec), contact, smallest, tuple(notes))
