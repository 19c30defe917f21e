"""MDF files (ASAM; MF4)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wucht.measurements.optional_library import library, reading, unique
from wucht.measurements.recording import Channel, Recording


def read_mdf(path: Path) -> Recording:
    """The channels of an MDF file, called ``channel``, or ``group/channel`` where several groups have one of that name.

    group: its number in the file, from 0. The clocks of the groups are no channels. Raises ``InputError`` for a file that
    cannot be read, and for a channel that is no list of numbers.
    """
    asammdf = library("asammdf", path)
    with reading(path, "an MDF file"), asammdf.MDF(str(path)) as file:
        clocks = set(file.masters_db.items())
        found = [(n, g, i) for n, places in file.channels_db.items() for g, i in places if (g, i) not in clocks]
    names = unique([n for n, _, _ in found], [f"{g}/{n}" for n, g, _ in found])
    places = {name: place for name, (_, *place) in zip(names, found, strict=True)}

    def load(name: str) -> Channel:
        group, index = places[name]
        with reading(path, "an MDF file"), asammdf.MDF(str(path)) as file:
            signal = file.get(group=group, index=index)
            return Channel(str(path), name, str(signal.unit).strip(), np.asarray(signal.timestamps), np.asarray(signal.samples))

    return Recording(str(path), tuple(names), load)
