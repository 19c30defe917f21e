"""Measured files -> recordings: text, sound, universal, TDMS and MDF files; the ending of a name selects the reader."""

from __future__ import annotations

import importlib
import struct
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from os import SEEK_CUR
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from wucht.errors import InputError
from wucht.measurements.recording import FULL_SCALE, TIME_UNIT, Channel, Recording
from wucht.measurements.text_file import read_text_file

_TIME_RESPONSE, _TIME_AXIS = 1, 17
_TIMES = ("time", "t", "zeit")
_TAG = b"TDSm"
_BYTE_ORDERS = {b"RIFF": "<", b"RIFX": ">"}
_LAYOUT = 14  # bytes of the chunk on the layout of samples, up to their size
_UNKNOWN_LENGTH = 0xFFFFFFFF  # of samples that were written as they came


def read_sound(path: Path) -> Recording:
    """Read the channels "1", "2", ... of a sound file, time from 0 s, values between -1 and 1 in ``FULL_SCALE``.

    A sound file has no units: give a channel one with ``Channel.with_scale``.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        For other files, for one without samples, and one with fewer than its header states.
    """
    from scipy.io import wavfile

    _check_sound(path)
    with _report_unreadable(path, "a sound file"), warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # of chunks that hold no samples
        rate, samples = wavfile.read(path)
        if not len(samples):
            raise ValueError("it has no samples")
    columns = samples.reshape(len(samples), -1)
    time = np.arange(len(columns)) / rate
    source = str(path)

    def load(name: str) -> Channel:
        return Channel(source, name, FULL_SCALE, time, _to_full_scale(columns[:, int(name) - 1]))

    return Recording(source, tuple(str(i + 1) for i in range(columns.shape[1])), load)


def _check_sound(path: Path) -> None:
    """Raise ``InputError`` for a RIFF file that is cut short or has no samples: scipy would read what is left."""
    try:
        with path.open("rb") as file:
            size = path.stat().st_size
            begin = file.read(12) if size else b""
            if not size:
                raise InputError(str(path), None, "this file is empty: record or copy it again", code="no-samples")
            if begin[:4] not in _BYTE_ORDERS:
                return
            length, sample = _sound_data(file, _BYTE_ORDERS[begin[:4]])
            rest = size - file.tell()
    except OSError as error:
        raise InputError.file_error(path, f"the file cannot be read: {error.strerror}", code="unreadable") from None
    if not length or not rest:
        explanation = "this sound file has a header and no sample: the recording was cut off; record or copy it again"
        raise InputError(str(path), None, explanation, code="no-samples")
    if rest < length != _UNKNOWN_LENGTH:
        counts = f"its header states {length // sample} samples, there are {rest // sample}"
        remedy = "copy it again, or save the samples that are left as a new file"
        raise InputError(str(path), None, f"this sound file is cut short: {counts}; {remedy}", code="cut-short")


def _sound_data(file: BinaryIO, order: str) -> tuple[int, int]:
    """Go to the samples of a sound file; return the bytes that its header states of them, 0 without any, and those of each."""
    sample = 1
    while len(chunk := file.read(8)) == 8:
        (length,) = struct.unpack(f"{order}I", chunk[4:])
        if chunk[:4] == b"data":
            return length, sample
        if chunk[:4] == b"fmt ":
            layout = file.read(min(length, _LAYOUT))
            sample, length = _bytes_of_sample(layout, order), length - len(layout)
        file.seek(length + length % 2, SEEK_CUR)
    return 0, sample


def _bytes_of_sample(layout: bytes, order: str) -> int:
    """Return the bytes of a sample of all channels. layout: the chunk that states the layout of a sound file."""
    return max(struct.unpack_from(f"{order}H", layout, 12)[0], 1) if len(layout) == _LAYOUT else 1


def _to_full_scale(values: np.ndarray) -> np.ndarray:
    """Scale integers of any width to -1 ... 1; unsigned ones have their zero in the middle."""
    if values.dtype.kind == "f":
        return values.astype(float)
    full = 2.0 ** (8 * values.dtype.itemsize - 1)
    return (values - (full if values.dtype.kind == "u" else 0.0)) / full


def _read_universal(path: Path) -> Recording:
    """Read the time signals of a universal file; spectra and other functions are ignored.

    A channel is called by its first ID line, or, where that is NONE or not the only one, "1", "2", ... in their order.
    Raises ``InputError`` for a file that cannot be read and one without time signals.
    """
    pyuff = _library("pyuff", path)
    with _report_unreadable(path, "a universal file"):
        file = pyuff.UFF(str(path))
        set_numbers = [i for i, kind in enumerate(file.get_set_types()) if int(kind) == 58]
        sets = [file.read_sets(i) for i in set_numbers]
    signals = [s for s in sets if s.get("func_type") == _TIME_RESPONSE or s.get("abscissa_spec_data_type") == _TIME_AXIS]
    if not signals:
        raise InputError(
            str(path),
            None,
            "there is no time signal in this file: it must hold a data set 58 of function type 1",
            code="no-signal",
        )
    names = _unique([_label(s, "id1") for s in signals], [str(i + 1) for i in range(len(signals))])
    by_name: dict[str, dict[str, Any]] = dict(zip(names, signals, strict=True))
    return Recording(str(path), tuple(names), lambda name: _channel(str(path), name, by_name[name]))


def _channel(source: str, name: str, data_set: dict[str, Any]) -> Channel:
    axis = np.asarray(data_set["x"])
    time = Channel(source, f"time of {name}", _label(data_set, "abscissa_axis_units_lab"), axis, axis).to_si(TIME_UNIT).values
    return Channel(source, name, _label(data_set, "ordinate_axis_units_lab"), time, np.asarray(data_set["data"]))


def _label(data_set: dict[str, Any], key: str) -> str:
    """Return a label of a data set; NONE means that there is none."""
    label = str(data_set.get(key) or "").strip()
    return "" if label.upper() == "NONE" else label


def _read_tdms(path: Path) -> Recording:
    """Read the channels of a TDMS file, called ``channel``, or ``group/channel`` where several groups have one of that name.

    Time is a waveform's, else that of the channel of the same group that is called time. Raises ``InputError`` for a file that
    cannot be read, and for a channel that has no time.
    """
    nptdms = _library("nptdms", path)
    with _report_unreadable(path, "a TDMS file"):
        _check_tag(path)
        channels = [c for group in nptdms.TdmsFile.read_metadata(path).groups() for c in group.channels()]
        names = _unique([c.name for c in channels], [f"{c.group_name}/{c.name}" for c in channels])
    places = {name: (c.group_name, c.name) for name, c in zip(names, channels, strict=True)}

    def load(name: str) -> Channel:
        group, channel_name = places[name]
        with _report_unreadable(path, "a TDMS file"), nptdms.TdmsFile.open(path) as file:
            channel = file[group][channel_name]
            time = _time(str(path), name, channel, file[group])
            return Channel(str(path), name, _unit(channel), time, np.asarray(channel[:]))

    return Recording(str(path), tuple(names), load)


def _check_tag(path: Path) -> None:
    """Raise ``ValueError`` for a file of another format: nptdms would return no channels without an error."""
    with path.open("rb") as file:
        if file.read(len(_TAG)) != _TAG:
            raise ValueError(f"it does not begin with {_TAG.decode()}")


def _unit(channel: Any) -> str:
    return str(channel.properties.get("unit_string", "")).strip()


def _time(source: str, name: str, channel: Any, group: Any) -> np.ndarray:
    """Return the times (n,) of a channel in s."""
    step = float(channel.properties.get("wf_increment", 0.0))
    if step > 0:
        return float(channel.properties.get("wf_start_offset", 0.0)) + step * np.arange(len(channel))
    clock = next((c for c in group.channels() if c.name.strip().lower() in _TIMES), None)
    if clock is None:
        explanation = (
            "the channel has no time: it must be a waveform (wf_increment), or its group must have a channel called time"
        )
        raise InputError(f"{source}: {name}", None, explanation, code="no-time")
    ticks = np.asarray(clock[:])
    return Channel(source, clock.name, _unit(clock), np.arange(len(ticks)), ticks).to_si(TIME_UNIT).values


def _read_mdf(path: Path) -> Recording:
    """Read the channels of an MDF file, called ``channel``, or ``group/channel`` where several groups have one of that name.

    group: its number in the file, from 0. The clocks of the groups are no channels. Raises ``InputError`` for a file that
    cannot be read, and for a channel that is no list of numbers.
    """
    asammdf = _library("asammdf", path)
    with _report_unreadable(path, "an MDF file"), asammdf.MDF(str(path)) as file:
        clocks = set(file.masters_db.items())
        channel_places = [(n, g, i) for n, places in file.channels_db.items() for g, i in places if (g, i) not in clocks]
    names = _unique([n for n, _, _ in channel_places], [f"{g}/{n}" for n, g, _ in channel_places])
    places = {name: place for name, (_, *place) in zip(names, channel_places, strict=True)}

    def load(name: str) -> Channel:
        group, index = places[name]
        with _report_unreadable(path, "an MDF file"), asammdf.MDF(str(path)) as file:
            _check_within_record(file.groups[group], (index, *(i for g, i in clocks if g == group)))
            signal = file.get(group=group, index=index)
            return Channel(str(path), name, str(signal.unit).strip(), np.asarray(signal.timestamps), np.asarray(signal.samples))

    return Recording(str(path), tuple(names), load)


def _check_within_record(group: Any, channels: Iterable[int]) -> None:
    """Raise ``ValueError`` where a channel of an MDF group lies beyond its record, at which asammdf reads foreign memory."""
    size = getattr(group.channel_group, "samples_byte_nr", None)
    for channel in (group.channels[index] for index in channels):
        offset, bits = getattr(channel, "byte_offset", None), channel.bit_count
        if size is not None and offset is not None and bits and offset + -(-bits // 8) > size:
            raise ValueError(f"{channel.name} lies beyond its record")


def _library(name: str, path: Path) -> Any:
    """Import the module that reads a file. Raises ``InputError`` if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(str(path), None, f"reading {path.suffix} needs the extra: pip install wucht[measure]") from None


@contextmanager
def _report_unreadable(path: Path, format_name: str) -> Iterator[None]:
    """Convert any error of a library on a file into an ``InputError``. format_name: the expected format."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:
        reason = (str(error).splitlines() or [""])[0]
        raise InputError(
            str(path), None, f"this cannot be read as {format_name}: {reason or type(error).__name__}", code="unreadable"
        ) from None


def _unique(names: list[str], longer: list[str]) -> list[str]:
    """Return the names, and where several are alike or empty, the longer ones."""
    return [name if name and names.count(name) == 1 else longer_name for name, longer_name in zip(names, longer, strict=True)]


_READERS: dict[str, Callable[[Path], Recording]] = {
    ".csv": read_text_file, ".txt": read_text_file, ".tsv": read_text_file, ".asc": read_text_file, ".wav": read_sound,
    ".uff": _read_universal, ".unv": _read_universal, ".uf": _read_universal, ".tdms": _read_tdms, ".mf4": _read_mdf,
    ".mdf": _read_mdf,
}  # fmt: skip


def read_recording(path: Path) -> Recording:
    """Read the recording in a file: text (CSV), sound (WAV), universal file (data set 58), TDMS or MDF.

    Parameters
    ----------
    path : pathlib.Path
        Its ending selects the reader.

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        For an ending that is none of these, a file that cannot be read, and one that needs a library that is not installed.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError.file_error(
            path,
            f"the name of a record must end in one of {', '.join(_READERS)}; this ends in {path.suffix!r}",
            code="unknown-ending",
        )
    if not path.is_file():
        raise InputError.file_error(path, _no_file(path), code="no-file")
    return reader(path)


def _no_file(path: Path) -> str:
    """Return what is wrong with a path that is not a file."""
    if path.is_dir():
        return "this is a folder; a file is needed"
    return "this is not a regular file, but a pipe or a device" if path.exists() else "there is no such file"
