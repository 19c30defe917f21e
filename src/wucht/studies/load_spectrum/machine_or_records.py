"""What a load spectrum is asked of: a machine, or a folder with records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wucht.errors import InputError
from wucht.file_names import printable
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, contents_of
from wucht.machines.machine import Machine
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import FULL_SCALE, Channel
from wucht.schema import Unit, refuse_unknown
from wucht.studies.load_spectrum.spec import Record
from wucht.studies.subjects import MACHINE, Description

# Of loads, in this order: loggers state accelerations in g, which elsewhere is a gram.
_SI = ("m/s^2", "N", "N m", "Pa", "m", "m/s", "rad", "rad/s", "V", "A", "W", "kg", "")


@dataclass(frozen=True)
class Records:
    """The folder in which a study's records lie."""

    folder: Path = field(default_factory=Path)
    title: str = "Record"

    def contents(self, name: str) -> str:
        """Of a record, so that a changed one is another question."""
        return contents_of(self.folder / name)

    def channel(self, record: Record) -> Channel:
        """A recorded signal, in SI where its unit is known.

        Raises ``InputError`` for a record that cannot be read, and a column that it does not have.
        """
        recording = read_recording(self.folder / record.file)
        if record.column is None and len(recording.names) != 1:
            known = ", ".join(recording.names)
            raise InputError(
                "study.signal.column", None, f"this key is missing; the record has the columns {known}", code="missing"
            )
        return _in_si(recording.channel(record.column or recording.names[0]).corrected(record.unit, record.scale))


class OfMachineOrRecords:
    """The machine of the table ``[machine]``; without one, the records that lie where the study file does."""

    def read(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[Machine | Records, Document]:
        """See ``Subject``."""
        if "machine" in document:
            return MACHINE.read(document, path, name, settings)
        if "system" in document:
            raise InputError("system", None, "this study is asked of a machine or of a record")
        refuse_unknown(document, ABOUT, "")
        for key, given in settings.items():
            raise InputError(key, given, "there is no table [machine] in which this could be set")
        return Records(path.parent, str(document.get("title", printable(path.stem)))), {}

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if isinstance(subject, Machine):
            return MACHINE.describe(subject)
        if not isinstance(subject, Records):
            raise InputError("machine", subject, "this study is asked of a machine, or of wucht.Records")
        return Description(subject.title, False, {"title": subject.title})


def _in_si(channel: Channel) -> Channel:
    """In SI; one without a unit, in shares of full scale, or in a unit that we do not know stays as it is."""
    if channel.unit in ("", FULL_SCALE):
        return channel
    for si in _SI:
        try:
            return channel.in_si(Unit(si, "load"))
        except InputError:
            continue
    return channel


MACHINE_OR_RECORDS = OfMachineOrRecords()
