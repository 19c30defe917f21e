"""Records of loads, the subject of a load spectrum in place of a machine: measured signals in files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import Field

from wucht.errors import InputError
from wucht.file_names import printable
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, contents_digest
from wucht.machines.machine import Machine
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import FULL_SCALE, Channel
from wucht.schema import SI, TableModel, Unit, refuse_unknown, si
from wucht.studies.subjects import MACHINE, Description

# SI units of loads, tried in this order: loggers state accelerations in g, which elsewhere is a gram.
_SI = ("m/s^2", "N", "N m", "Pa", "m", "m/s", "rad", "rad/s", "V", "A", "W", "kg", "")


class RecordColumn(TableModel):
    """A record of a load."""

    file: str = Field(min_length=1, description="file of the record")
    column: str | None = Field(default=None, min_length=1, title="column of the record", description=(
        "column of the record, which may be left out where there is only one"
    ))  # fmt: skip
    unit: str | None = Field(default=None, min_length=1, title="unit of the column's numbers", description=(
        "unit of the column's numbers, instead of the one that the file states"
    ))  # fmt: skip
    scale: SI[float | None] = si("", "factor for the column's numbers", default=None)


@dataclass(frozen=True)
class Records:
    """The records of a study: measured signals in the files of a folder.

    Parameters
    ----------
    folder : pathlib.Path
        Where the files lie.
    title : str
        The name of the records in results.
    """

    folder: Path = field(default_factory=Path)
    title: str = "Record"

    def contents(self, name: str) -> str:
        """Return the contents of a record, so that a changed one is another question."""
        return contents_digest(self.folder / name)

    def channel(self, record: RecordColumn) -> Channel:
        """Return a recorded signal, in SI where its unit is known.

        Raises ``InputError`` for a record that cannot be read, and a column that it does not have.
        """
        recording = read_recording(self.folder / record.file)
        if record.column is None and len(recording.names) != 1:
            columns = ", ".join(recording.names)
            raise InputError(
                "study.signal.column", None, f"this key is missing; the record has the columns {columns}", code="missing"
            )
        return _to_si(recording.channel(record.column or recording.names[0]).correct(record.unit, record.scale))


class MachineOrRecords:
    """The machine of the table ``[machine]``; without one, the records that lie where the study file does."""

    def from_document(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[Machine | Records, Document]:
        """See ``Subject``."""
        if "machine" in document:
            return MACHINE.from_document(document, path, name, settings)
        if "system" in document:
            raise InputError("system", None, "this study needs a machine or a record")
        refuse_unknown(document, ABOUT, "")
        for key, value in settings.items():
            raise InputError(key, value, "there is no table [machine] with this key")
        return Records(path.parent, str(document.get("title", printable(path.stem)))), {}

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if isinstance(subject, Machine):
            return MACHINE.describe(subject)
        if not isinstance(subject, Records):
            raise InputError("machine", subject, "this study needs a machine, or wucht.Records")
        return Description(subject.title, False, {"title": subject.title})


def _to_si(channel: Channel) -> Channel:
    """Convert a channel to SI; it stays as it is without a unit, in shares of full scale, or in an unknown unit."""
    if channel.unit in ("", FULL_SCALE):
        return channel
    for unit in _SI:
        try:
            return channel.to_si(Unit(unit, "load"))
        except InputError:
            continue
    return channel


MACHINE_OR_RECORDS = MachineOrRecords()
