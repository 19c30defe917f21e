"""What a design is asked of: a machine, and the folder of the study file where that names a file of its target."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wucht.files.documents import Document, contents_of
from wucht.machines.machine import Machine
from wucht.schema import table
from wucht.studies.subjects import MACHINE, Description


@dataclass(frozen=True)
class MachineInFolder:
    """A machine that was read from a study file in a folder."""

    machine: Machine
    folder: Path

    def contents(self, name: str) -> str:
        """Of a file beside the study file, so that a changed one is another question."""
        return contents_of(self.folder / name)


class OfMachineInFolder:
    """The machine of the table ``[machine]``; with where it was read from, if the target lies in a file beside it."""

    def read(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[Machine | MachineInFolder, Document]:
        """See ``Subject``."""
        machine, described = MACHINE.read(document, path, name, settings)
        target = table(document, "study", "study").get("target") if "study" in document else None
        named = isinstance(target, Mapping) and "file" in target
        return MachineInFolder(machine, path.parent) if named else machine, described

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        return MACHINE.describe(subject.machine if isinstance(subject, MachineInFolder) else subject)


MACHINE_IN_FOLDER = OfMachineInFolder()
