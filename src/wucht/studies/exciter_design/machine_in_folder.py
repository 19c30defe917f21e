"""The subject of a design: the machine, with the folder of its file where the target spectrum lies in a file beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wucht.files.documents import Document, contents_digest
from wucht.machines.machine import Machine
from wucht.schema import require_table
from wucht.studies.subjects import MACHINE, Description


@dataclass(frozen=True)
class MachineInFolder:
    """Machine that was read from a study file in a folder."""

    machine: Machine
    folder: Path

    def contents(self, name: str) -> str:
        """Return the contents of a file beside the study file: a changed file makes another question."""
        return contents_digest(self.folder / name)


class MachineInFolderSubject:
    """Subject of a design: the machine of the table ``[machine]``, with its folder if the target lies in a file beside it."""

    def from_document(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[Machine | MachineInFolder, Document]:
        """Read the machine, see ``Subject``."""
        machine, facts = MACHINE.from_document(document, path, name, settings)
        target = require_table(document, "study", "study").get("target") if "study" in document else None
        has_target_file = isinstance(target, Mapping) and "file" in target
        return MachineInFolder(machine, path.parent) if has_target_file else machine, facts

    def describe(self, subject: Any) -> Description:
        """Describe the machine, see ``Subject``."""
        return MACHINE.describe(subject.machine if isinstance(subject, MachineInFolder) else subject)


MACHINE_IN_FOLDER = MachineInFolderSubject()
