"""Universal files (UFF, UNV): time signals in data sets of type 58."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from wucht.errors import InputError
from wucht.measurements.optional_library import library, reading, unique
from wucht.measurements.recording import TIME, Channel, Recording

_TIME_RESPONSE, _TIME_AXIS = 1, 17


def read_universal(path: Path) -> Recording:
    """The time signals of a universal file; spectra and other functions are passed over.

    A channel is called by its first ID line, or, where that is NONE or not the only one, "1", "2", ... in their order.
    Raises ``InputError`` for a file that cannot be read and one without time signals.
    """
    pyuff = library("pyuff", path)
    with reading(path, "a universal file"):
        file = pyuff.UFF(str(path))
        wanted = [i for i, kind in enumerate(file.get_set_types()) if int(kind) == 58]
        sets = [file.read_sets(i) for i in wanted]
    signals = [s for s in sets if s.get("func_type") == _TIME_RESPONSE or s.get("abscissa_spec_data_type") == _TIME_AXIS]
    if not signals:
        raise InputError(
            str(path),
            None,
            "there is no time signal in this file: it must hold a data set 58 of function type 1",
            code="no-signal",
        )
    names = unique([_said(s, "id1") for s in signals], [str(i + 1) for i in range(len(signals))])
    by_name: dict[str, dict[str, Any]] = dict(zip(names, signals, strict=True))
    return Recording(str(path), tuple(names), lambda name: _channel(str(path), name, by_name[name]))


def _channel(source: str, name: str, found: dict[str, Any]) -> Channel:
    axis = np.asarray(found["x"])
    time = Channel(source, f"time of {name}", _said(found, "abscissa_axis_units_lab"), axis, axis).in_si(TIME).values
    return Channel(source, name, _said(found, "ordinate_axis_units_lab"), time, np.asarray(found["data"]))


def _said(found: dict[str, Any], key: str) -> str:
    """A label; NONE says that there is none."""
    label = str(found.get(key) or "").strip()
    return "" if label.upper() == "NONE" else label
