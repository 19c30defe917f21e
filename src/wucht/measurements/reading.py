"""Measured files -> recordings; the ending of a file's name says how it is read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from wucht.errors import InputError
from wucht.measurements.mdf_file import read_mdf
from wucht.measurements.recording import Recording
from wucht.measurements.sound_file import read_sound
from wucht.measurements.tdms_file import read_tdms
from wucht.measurements.text_file import read_text_file
from wucht.measurements.universal_file import read_universal

_READERS: dict[str, Callable[[Path], Recording]] = {
    ".csv": read_text_file, ".txt": read_text_file, ".tsv": read_text_file, ".asc": read_text_file, ".wav": read_sound,
    ".uff": read_universal, ".unv": read_universal, ".uf": read_universal, ".tdms": read_tdms, ".mf4": read_mdf,
    ".mdf": read_mdf,
}  # fmt: skip


def read_recording(path: Path) -> Recording:
    """The recording in a file: text (CSV), sound (WAV), universal file (data set 58), TDMS or MDF.

    Raises ``InputError`` for an ending that is none of these, a file that cannot be read, and one that needs a library that is
    not installed.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError.of_file(
            path, f"a record must end in one of {', '.join(_READERS)}; this ends in {path.suffix!r}", code="unknown-ending"
        )
    if not path.is_file():
        raise InputError.of_file(path, _no_file(path), code="no-file")
    return reader(path)


def _no_file(path: Path) -> str:
    """What is wrong where no file is."""
    if path.is_dir():
        return "this is a folder; a file is needed"
    return "this is no file with an end, but a pipe or a device" if path.exists() else "there is no such file"
