"""The target of a question -> cycles, in the unit of the signal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wucht.errors import InputError
from wucht.fatigue.counted_cycles import Cycles
from wucht.fatigue.cumulative_spectra import EXPONENTS, standard_spectrum, tabulated_spectrum
from wucht.files.tables import read_table
from wucht.schema import Unit, read_quantity
from wucht.studies.exciter_design.spec import Target
from wucht.studies.spec import Quantity

_AT = "study.target"
_CYCLES = Unit("cycles", "number of cycles")  # without that unit a cycle would be 2 pi


def wanted(target: Target, unit: str, folder: Path | None) -> Cycles:
    """The spectrum. unit: of its amplitudes. folder: in which a file lies. Raises ``InputError``."""
    amplitude = Unit(unit, "amplitude")
    if target.file is not None:
        if folder is None:
            raise InputError(
                f"{_AT}.file",
                target.file,
                "allowed only where the study file itself names it; else give the table",
                code="not-allowed",
            )
        try:
            rows = read_table(folder / target.file, (amplitude, _CYCLES))
        except InputError as error:
            raise InputError(f"{_AT}.file", target.file, error.allowed) from None
        return _of_rows(rows, f"{_AT}.file", target.file, bool(target.stepped))
    if target.table is not None:
        return _of_rows(_read(target.table, amplitude), f"{_AT}.table", None, bool(target.stepped))
    if target.largest is None or target.cycles is None:
        raise InputError(_AT, None, "needed are largest and cycles")
    largest = read_quantity(amplitude, target.largest, f"{_AT}.largest")
    if not largest > 0:
        raise InputError(f"{_AT}.largest", target.largest, "must be an amplitude greater than 0")
    exponent = EXPONENTS[target.shape] if target.shape is not None else target.exponent
    if exponent is None:
        raise InputError(_AT, None, "needed is a shape or an exponent")
    return standard_spectrum(largest, target.cycles, exponent, target.ratio or 0.0)


def _read(table: Sequence[tuple[Quantity, Quantity]], amplitude: Unit) -> list[list[float]]:
    """The rows of a table, by ascending amplitude."""
    units = (amplitude, _CYCLES)
    rows = [
        [read_quantity(units[k], given, f"{_AT}.table[{i}][{k}]") for k, given in enumerate(row)] for i, row in enumerate(table)
    ]
    return sorted(rows)


def _of_rows(rows: Sequence[Sequence[float]], where: str, given: object, stepped: bool) -> Cycles:
    """Raises ``InputError`` for a table that is no cumulative spectrum."""
    if len(rows) < 1 or (len(rows) < 2 and not stepped):
        raise InputError(where, given, "must have two rows at least, of amplitude and cumulative cycles")
    amplitudes, cumulative = np.array(rows, float).T
    if not (amplitudes >= 0).all() or not (np.diff(amplitudes) > 0).all() or not amplitudes[-1] > 0:
        raise InputError(where, given, "must have different amplitudes, none below 0")
    if not (cumulative > 0).all() or (np.diff(cumulative) > 0).any():
        raise InputError(where, given, "must have cycles greater than 0 that do not increase with the amplitude: each row "
                         "says how many have at least its amplitude")  # fmt: skip
    if not cumulative[0] > 1:
        raise InputError(where, given, "must have more than one cycle")
    return tabulated_spectrum(amplitudes, cumulative, stepped)
