"""TDMS files (LabVIEW, DIAdem)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from wucht.errors import InputError
from wucht.measurements.optional_library import library, reading, unique
from wucht.measurements.recording import TIME, Channel, Recording

_TIMES = ("time", "t", "zeit")
_TAG = b"TDSm"


def read_tdms(path: Path) -> Recording:
    """The channels of a TDMS file, called ``channel``, or ``group/channel`` where several groups have one of that name.

    Time is a waveform's, else that of the channel of the same group that is called time. Raises ``InputError`` for a file that
    cannot be read, and for a channel that has no time.
    """
    nptdms = library("nptdms", path)
    with reading(path, "a TDMS file"):
        _check_tag(path)
        channels = [c for group in nptdms.TdmsFile.read_metadata(path).groups() for c in group.channels()]
        names = unique([c.name for c in channels], [f"{c.group_name}/{c.name}" for c in channels])
    places = {name: (c.group_name, c.name) for name, c in zip(names, channels, strict=True)}

    def load(name: str) -> Channel:
        group, own = places[name]
        with reading(path, "a TDMS file"), nptdms.TdmsFile.open(path) as file:
            channel = file[group][own]
            time = _time(str(path), name, channel, file[group])
            return Channel(str(path), name, _unit(channel), time, np.asarray(channel[:]))

    return Recording(str(path), tuple(names), load)


def _check_tag(path: Path) -> None:
    """Raises ``ValueError`` for a file that is none: nptdms finds no channels in it, and says nothing."""
    with path.open("rb") as file:
        if file.read(len(_TAG)) != _TAG:
            raise ValueError(f"it does not begin with {_TAG.decode()}")


def _unit(channel: Any) -> str:
    return str(channel.properties.get("unit_string", "")).strip()


def _time(source: str, name: str, channel: Any, group: Any) -> np.ndarray:
    """(n,) in s."""
    step = float(channel.properties.get("wf_increment", 0.0))
    if step > 0:
        return float(channel.properties.get("wf_start_offset", 0.0)) + step * np.arange(len(channel))
    clock = next((c for c in group.channels() if c.name.strip().lower() in _TIMES), None)
    if clock is None:
        allowed = "the channel has no time: it must be a waveform (wf_increment), or its group must have a channel called time"
        raise InputError(f"{source}: {name}", None, allowed, code="no-time")
    ticks = np.asarray(clock[:])
    return Channel(source, clock.name, _unit(clock), np.arange(len(ticks)), ticks).in_si(TIME).values
