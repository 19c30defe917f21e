"""The target of a design: its keys, and the load spectrum that they give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from wucht.errors import InputError
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import EXPONENTS, standard_spectrum, tabulated_spectrum
from wucht.files.tables import read_table
from wucht.schema import SI, Composite, TableModel, Unit, composite, is_pairs, read_quantity, si, validate_table
from wucht.schema.key_values import TrueOrFalse, Value

_AT = "study.target"
_CYCLES = Unit("cycles", "number of cycles")  # without that unit a cycle would be 2 pi
_FORMS = ("shape", "exponent", "table", "file")
_TARGET_FORMS = (
    "must be a table of pairs [[AMPLITUDE, CYCLES], ...], { file = FILE }, or { shape = 'normal', largest = AMPLITUDE, "
    "cycles = NUMBER }"
)
Shape = Literal["constant", "normal", "straight-line"]


class Target(TableModel):
    """Target spectrum: amplitude over cumulative cycles."""

    shape: Shape | None = Field(default=None, title="shape of the spectrum", description="shape of the spectrum, or `exponent`")
    exponent: SI[float | None] = si(
        "", "exponent of the shape", default=None, gt=0, help="exponent of another shape, H = H_0^(1 - (S/S_max)^exponent)"
    )
    largest: Value | None = Field(default=None, title="largest amplitude", description="largest amplitude S_max")
    cycles: SI[float | None] = si("cycles", "number of cycles", default=None, gt=1, help="number of cycles H_0, in all")
    ratio: SI[float | None] = si("", "ratio of the lowest amplitude to the largest", default=None, ge=0, lt=1)
    table: Composite[tuple[tuple[Value, Value], ...] | None] = composite(
        default=None,
        title="amplitudes and cumulative cycles",
        description="pairs of an amplitude and the number of cycles with at least this amplitude",
    )
    file: str | None = Field(default=None, min_length=1, title="file of amplitudes and cumulative cycles", description=(
        "file with these two columns, amplitudes and cumulative cycles"
    ))  # fmt: skip
    stepped: TrueOrFalse | None = Field(default=None, description="true if no cycle lies between two amplitudes of a table")

    def check(self) -> None:
        """Check that one form is given, with the keys that it needs."""
        forms = [key for key in _FORMS if getattr(self, key) is not None]
        if len(forms) != 1:
            raise InputError("study.target", ", ".join(forms) or None, f"must be one of {', '.join(_FORMS)}")
        standard = forms[0] in ("shape", "exponent")
        for key in ("largest", "cycles"):
            if standard and getattr(self, key) is None:
                raise InputError(
                    f"study.target.{key}", None, f"this key is missing: a target with {forms[0]} needs it", code="missing"
                )
        for key in ("stepped",) if standard else ("largest", "cycles", "ratio"):
            if getattr(self, key) is not None:
                alternative = "a table or file" if standard else "a shape or exponent"
                raise InputError(f"study.target.{key}", getattr(self, key), f"allowed only with {alternative}")


def read_target(raw: Any) -> Any:
    """Read the key ``target``: a table of keys, or the pairs of its table alone. Raises ``ValueError``."""
    if is_pairs(raw):
        raw = {"table": raw}
    if not isinstance(raw, Mapping | Target):
        raise ValueError(_TARGET_FORMS)
    if isinstance(raw, Target):
        raw.check()
        return raw
    pairs = raw.get("table")
    if pairs is not None and not is_pairs(pairs):
        raise InputError("study.target.table", pairs, "must be a list of pairs [AMPLITUDE, CYCLES]")
    target = validate_table(Target, raw, "study.target")
    target.check()
    return target


def target_spectrum(target: Target, unit: str, folder: Path | None) -> LoadCycles:
    """Return the target spectrum. unit: of its amplitudes. folder: of its file. Raises ``InputError``."""
    amplitude = Unit(unit, "amplitude")
    if target.file is not None:
        if folder is None:
            raise InputError(
                f"{_AT}.file",
                target.file,
                "allowed only in a study file; else give the table",
                code="not-allowed",
            )
        try:
            rows = read_table(folder / target.file, (amplitude, _CYCLES))
        except InputError as error:
            raise InputError(f"{_AT}.file", target.file, error.explanation) from None
        return _spectrum_from_rows(rows, f"{_AT}.file", target.file, bool(target.stepped))
    if target.table is not None:
        return _spectrum_from_rows(_table_rows(target.table, amplitude), f"{_AT}.table", None, bool(target.stepped))
    if target.largest is None or target.cycles is None:
        raise InputError(_AT, None, "give largest and cycles")
    largest = read_quantity(amplitude, target.largest, f"{_AT}.largest")
    if not largest > 0:
        raise InputError(f"{_AT}.largest", target.largest, "must be an amplitude greater than 0")
    exponent = EXPONENTS[target.shape] if target.shape is not None else target.exponent
    if exponent is None:
        raise InputError(_AT, None, "give a shape or an exponent")
    return standard_spectrum(largest, target.cycles, exponent, target.ratio or 0.0)


def _table_rows(table: Sequence[tuple[Value, Value]], amplitude: Unit) -> list[list[float]]:
    """Return the rows of a table, by ascending amplitude."""
    units = (amplitude, _CYCLES)
    rows = [
        [read_quantity(units[k], entry, f"{_AT}.table[{i}][{k}]") for k, entry in enumerate(row)] for i, row in enumerate(table)
    ]
    return sorted(rows)


def _spectrum_from_rows(rows: Sequence[Sequence[float]], location: str, value: object, is_stepped: bool) -> LoadCycles:
    """Return the spectrum of a table. Raises ``InputError`` for a table that is no cumulative spectrum."""
    if len(rows) < 1 or (len(rows) < 2 and not is_stepped):
        raise InputError(location, value, "must have two rows at least, of amplitude and cumulative cycles")
    amplitudes, cumulative = np.array(rows, float).T
    if not (amplitudes >= 0).all() or not (np.diff(amplitudes) > 0).all() or not amplitudes[-1] > 0:
        raise InputError(location, value, "must have different amplitudes, none below 0")
    if not (cumulative > 0).all() or (np.diff(cumulative) > 0).any():
        raise InputError(location, value, "must have cycles greater than 0 that do not increase with the amplitude: each row "
                         "states how many have at least its amplitude")  # fmt: skip
    if not cumulative[0] > 1:
        raise InputError(location, value, "must have more than one cycle")
    return tabulated_spectrum(amplitudes, cumulative, is_stepped)
