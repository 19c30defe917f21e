"""The cams of a drive, the original ones or those that are corrected for the motion of its shaft, and the laws they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wucht.cams.cam import Cam
from wucht.cams.correction import CorrectedLaw
from wucht.cams.drive import CamDrive
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.heading import cam_version


@dataclass(frozen=True, eq=False)
class DriveCams:
    """The cams of a drive, and the laws of output and follower over the cam angle.

    shaft: motion of the shaft, None where no table states it. is_corrected: for this motion. cams: by their names, none without
    a follower.
    """

    drive: CamDrive
    shaft: ShaftMotion | None
    is_corrected: bool
    law: Law
    follower_law: Law
    cams: Mapping[str, Cam]

    @classmethod
    def of(cls, drive: CamDrive, shaft: ShaftMotion | None, is_corrected: bool) -> DriveCams:
        """Make them. Raises ``InputError`` where there is no such law, or linkage or follower cannot make it."""
        law: Law = drive.motion_law.function
        if is_corrected and shaft is not None:
            law = CorrectedLaw(law, shaft)
        follower_law = drive.follower_law(law)
        cams = {} if drive.follower is None else drive.follower.make_cams(follower_law)
        return cls(drive, shaft, is_corrected, law, follower_law, cams)

    @property
    def version(self) -> str:
        """``original`` or ``corrected``; empty where no speed is stated, so that there is one cam only."""
        return cam_version(self.shaft, self.is_corrected)
