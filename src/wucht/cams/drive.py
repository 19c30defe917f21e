"""A cam drive: the tables of a cam file, and the law, the cam and the shaft that they describe."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.correction import MotionOverTime
from wucht.cams.followers.follower import Follower
from wucht.cams.laws import Law
from wucht.cams.linkages.closure import LeverMotion, Linkage
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import ShaftTable
from wucht.cams.tables.linkage import LinkageTable
from wucht.cams.tables.motion_law import GROUP, LawTable, MotionLaw, unit_of_output
from wucht.cams.tables.speed import SpeedTable
from wucht.errors import InputError
from wucht.files.documents import contents_digest
from wucht.kinds import kinds_of
from wucht.measurements.order_fit import OrderFit
from wucht.numerics.fourier_series import FourierSeries
from wucht.schema import choice, require_table, validate_table

TABLES = ("law", "follower", "linkage", "speed", "shaft")


@dataclass(frozen=True, eq=False)
class CamDrive:
    """A cam drive, that is a mechanism in which a cam moves an output: no ``Drive``, which is the motor of a machine.

    It has a motion law, and as far as they are known the follower, the linkage and the speed of the shaft.

    ``load_machine`` makes one of a cam file.

    Parameters
    ----------
    law : LawTable
        Of the output over the cam angle of a shaft that turns evenly.
    follower : Follower, optional
        Needed for a cam.
    linkage : LinkageTable, optional
        Between the follower, which is a lever then, and the output.
    speed : SpeedTable, optional
        The speed of the shaft over a turn.
    shaft : ShaftTable, optional
        Inertia, drive and output of the shaft, from which its motion is predicted.
    title : str, optional
    folder : pathlib.Path, optional
        The folder of the files of records.

    Raises
    ------
    InputError
        For a linkage whose follower is no lever.
    """

    law: LawTable
    follower: Follower | None = None
    linkage: LinkageTable | None = None
    speed: SpeedTable | None = None
    shaft: ShaftTable | None = None
    title: str = "Cam drive"
    folder: Path = Path()

    def __post_init__(self) -> None:
        if self.linkage is not None and self.follower is not None and self.follower.unit != "rad":
            levers = " or ".join(repr(kind) for kind, follower in followers().items() if follower.unit == "rad")
            raise InputError("linkage", None, f"a linkage is moved by a lever: follower.kind must be {levers}")

    @cached_property
    def motion_law(self) -> MotionLaw:
        """Motion law of the output. Raises ``InputError`` where there is no such law."""
        output_table = self.linkage or self.follower
        unit = output_table.unit if output_table is not None else self.law.stated_unit
        return self.law.make_motion_law(unit_of_output(self.law.output_values(), unit))

    @cached_property
    def closure(self) -> Linkage | None:
        """The linkage. Raises ``InputError`` where it does not close."""
        return None if self.linkage is None else self.linkage.linkage()

    @property
    def output_arm(self) -> float | None:
        """Length in m of the arm of an output that turns; None where it slides, or no table states it."""
        output_table = self.linkage or self.follower
        return None if output_table is None else output_table.output_arm

    def follower_law(self, output: Law) -> Law:
        """Return the follower's law for a law of the output. Raises ``InputError`` where the linkage cannot make it."""
        return output if self.closure is None else LeverMotion(output, self.closure)

    @property
    def required_follower(self) -> Follower:
        """The follower. Raises ``InputError`` where there is none."""
        if self.follower is None:
            raise InputError("follower", None, "the table [follower] is missing", code="missing")
        return self.follower

    def make_cams(self, output: Law) -> dict[str, Cam]:
        """Make the cams, by name, for a law of the output: ``cam``, with a counter cam ``counter``, in a groove ``outer``.

        Raises ``InputError`` where there is no follower, or the lever would lose its cams.
        """
        return self.required_follower.make_cams(self.follower_law(output))

    @cached_property
    def speed_fit(self) -> OrderFit | None:
        """The orders of the record of the speed, None without one. Raises ``InputError``."""
        return None if self.speed is None else self.speed.record_fit(self.folder)

    @cached_property
    def shaft_motion(self) -> ShaftMotion:
        """The motion of the shaft. Raises ``InputError`` where no table states it."""
        if self.speed is None:
            raise InputError(
                "speed", None, "the table [speed] is missing: the speed of the camshaft over a turn", code="missing"
            )
        return self.speed.shaft(self.speed_fit)

    def camshaft_powers(self, motions: Sequence[MotionOverTime], tau: np.ndarray) -> list[np.ndarray]:
        """Return the power in W at tau (N,) that output and loads of [shaft] take from the camshaft with each motion.

        That is the rate of the output's kinetic energy, J1 psi' psi'' omega^3, and the loads' torque times the speed. None
        without that table. Raises ``InputError`` where it does not fit the law.
        """
        if self.shaft is None:
            return []
        inertia, powers = self.shaft.moving_inertia(self.motion_law.unit), list[np.ndarray]()
        driving = self.shaft.camshaft_drive(self.folder) if self.shaft.loads else None
        for motion in motions:
            speed = motion.shaft.speed(tau)
            load = 0.0 if driving is None else driving.torques(speed)[0][1]
            powers.append(inertia * motion.shaft.mean**3 * motion(tau, 1) * motion(tau, 2) + load * speed)
        return powers

    @cached_property
    def corrected_shaft_motion(self) -> ShaftMotion:
        """The motion of the shaft for which the cam is corrected: that of the table [speed], or else predicted from [shaft].

        Raises ``InputError`` where no table states it, ``RunError`` where there is none.
        """
        if self.speed is not None or self.shaft is None:
            return self.shaft_motion
        driving = self.shaft.camshaft_drive(self.folder)
        shaft = self.shaft.camshaft(driving, self.motion_law.unit)
        if driving is not None and driving.is_enforced:
            return ShaftMotion(FourierSeries.of(shaft.mean_speed))
        return shaft.motion_with_corrected_cam(self.motion_law.function)

    @property
    def facts(self) -> Mapping[str, Any]:
        """Content of the tables as JSON: two drives with the same facts are the same."""
        tables = {name: getattr(self, name) for name in TABLES}
        facts = {
            n: {"kind": t.kind, **t.model_dump(mode="json", exclude_none=True)} for n, t in tables.items() if t is not None
        }
        if self.speed is not None and self.speed.file is not None:
            facts["speed"]["contents"] = self.contents(self.speed.file)
        if self.shaft is not None and self.shaft.drive is not None and isinstance(self.shaft.drive.get("file"), str):
            facts["shaft"]["contents"] = self.contents(self.shaft.drive["file"])
        return {"title": self.title, **facts}

    def contents(self, name: str) -> str:
        """Return a digest of a file, so that a changed file gives new results. Empty where it cannot be read."""
        return contents_digest(self.folder / name)


def laws() -> dict[str, type[LawTable]]:
    """Return the kinds of laws by name, of wucht and of the user's packages."""
    return kinds_of(LawTable, GROUP)


def followers() -> dict[str, type[Follower]]:
    """Return the kinds of followers by name."""
    return kinds_of(Follower, GROUP)


def linkages() -> dict[str, type[LinkageTable]]:
    """Return the kinds of linkages by name."""
    return kinds_of(LinkageTable, GROUP)


def cam_drive_from(document: Mapping[str, Any], title: str, folder: Path) -> CamDrive:
    """Return the drive that the tables of a cam file describe. Raises ``InputError``: the key, its value, the allowed ones."""
    tables = {name: dict(require_table(dict(document), name, name)) for name in TABLES if name in document}
    if "law" not in tables:
        raise InputError("law", None, "the table [law] is missing: the motion that the output is to make", code="missing")
    kinds: Mapping[str, Mapping[str, type[Any]]] = {"law": laws(), "follower": followers(), "linkage": linkages()}
    arguments: dict[str, Any] = {}
    for name in reversed(TABLES):  # the law last: the others say whether its output turns or slides
        entries = tables.get(name)
        if entries is None:
            continue
        if name == "law" and "segments" in entries:
            entries.setdefault("kind", "segments")
        cls: type[Any] = SpeedTable if name == "speed" else ShaftTable
        if name in kinds:
            cls = kinds[name][choice(entries, "kind", name, kinds[name])]
            del entries["kind"]
        if name == "law":
            output_table = arguments.get("linkage") or arguments.get("follower")
            entries = cls.with_file_contents(entries, folder, output_table.unit if output_table is not None else None)
        arguments[name] = validate_table(cls, entries, name)
    return CamDrive(**arguments, title=title, folder=folder)
