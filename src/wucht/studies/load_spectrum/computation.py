"""Question and subject -> plan -> findings: the source of the signal, the count of its turning points, and its damage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from wucht.dynamics.run_ups.machine_signals import (
    LoadHistory,
    MachineSignal,
    load_histories,
    machine_signal,
    rotor_signal,
)
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.counting import (
    TurningPoints,
    cycles_of_levels,
    cycles_of_peaks,
    level_crossings,
    peaks_and_valleys,
    rainflow,
    range_pairs,
)
from wucht.fatigue.damage import WoehlerLine
from wucht.file_names import printable
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, contents_digest
from wucht.machines.machine import Machine
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import FULL_SCALE, Channel
from wucht.schema import Unit, read_quantity, refuse_unknown
from wucht.studies.load_spectrum.spec import LoadSpectrum, RecordColumn
from wucht.studies.shared_keys import woehler_line
from wucht.studies.spec import Value
from wucht.studies.subjects import MACHINE, Description

# SI units of loads, tried in this order: loggers state accelerations in g, which elsewhere is a gram.
_SI = ("m/s^2", "N", "N m", "Pa", "m", "m/s", "rad", "rad/s", "V", "A", "W", "kg", "")


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
    for si in _SI:
        try:
            return channel.to_si(Unit(si, "load"))
        except InputError:
            continue
    return channel


MACHINE_OR_RECORDS = MachineOrRecords()


_FEWEST_SAMPLES_A_CYCLE = 10.0
_ROUNDING = 1e-9  # of the distance of two levels
_MOST_CLASSES = 10_000
MOST_ROWS, _CLASSES = 1000, 100  # ranges listed without classes, and classes where there are more


@dataclass(frozen=True)
class Plan:
    """The plan of a load spectrum.

    signal: whose cycles are counted. case: its run-up, None for a record. reference, class_width: in the signal's
    unit. line: the Woehler line. warnings: doubts about the question.
    """

    spec: LoadSpectrum
    signal: MachineSignal | Channel
    case: RunUpCase | None
    reference: float | None
    class_width: float | None
    line: WoehlerLine | None
    warnings: tuple[str, ...]


def prepare(spec: LoadSpectrum, subject: Machine | Records) -> Plan:
    """Return the plan. Raises ``InputError`` where the question does not fit the machine or the record."""
    signal: MachineSignal | Channel
    case, warnings = None, tuple[str, ...]()
    if isinstance(subject, Machine):
        if spec.record is not None:
            raise InputError("study.signal", spec.record.file, "give either a table [machine] or a record")
        case = RunUpCase.of(subject, spec.start, spec.settings)
        if spec.rotor is None:
            signal = machine_signal(case.machine, str(spec.signal), spec.direction)
        else:
            signal = rotor_signal(case.machine, spec.rotor, spec.direction)
    else:
        if spec.record is None:
            reason = "a table [machine] is required, or a record: signal = { file = FILE, column = NAME }"
            raise InputError("study.signal", spec.signal, reason)
        signal = subject.channel(spec.record)
        last = float(signal.time[-1])
        if spec.after is not None and spec.after >= last:
            raise InputError("study.after", spec.after, f"must be less than the time at which the record ends, {last:g} s")
        warnings = _sampling_warnings(signal.values)
    unit = signal.unit
    width = _read_in_unit(spec.class_width, unit, "width of the classes", "class_width")
    if width is not None and width <= 0:
        raise InputError("study.class_width", spec.class_width, "must be a width greater than 0")
    if isinstance(signal, Channel):  # the span of a machine's signal is known only after its run
        check_width(signal.values, width)
    reference = _read_in_unit(spec.reference, unit, "reference", "reference")
    line = None if spec.woehler is None else woehler_line(spec.woehler, unit, "study.woehler")
    return Plan(spec, signal, case, reference, width, line, warnings)


def numbers(plan: Plan) -> float:
    """Bound the count of stored numbers: time and value of two turning points a turn at the highest speed expected."""
    if plan.case is None:
        return 0.0
    horizon = plan.case.horizon
    return 4 * horizon.first / (horizon.step * horizon.samples_per_turn)


def check_width(values: np.ndarray, width: float | None) -> None:
    """Refuse classes so narrow that they would be too many for values (m,). Raises ``InputError``."""
    span = float(np.ptp(values)) if len(values) else 0.0
    if width is not None and span > _MOST_CLASSES * width:
        requirement = f"must be at least {span / _MOST_CLASSES:.3g}: the signal spans {span:.4g}"
        raise InputError("study.class_width", width, f"{requirement}, in {_MOST_CLASSES} classes at most")


def _read_in_unit(value: Value | None, unit: str, quantity: str, key: str) -> float | None:
    """Read a quantity in the unit of the signal; in a unit outside SI, a number. Raises ``InputError``."""
    return None if value is None else read_quantity(Unit(unit, quantity), value, f"study.{key}")


def _sampling_warnings(values: np.ndarray) -> tuple[str, ...]:
    """Return a warning where extremes fall between the samples of a record."""
    steps = np.diff(values)
    turns = int(np.count_nonzero(np.diff(np.sign(steps[steps != 0])))) if len(values) > 2 else 0
    samples_per_cycle = 2 * len(values) / turns if turns else np.inf
    if samples_per_cycle >= _FEWEST_SAMPLES_A_CYCLE or len(values) < 2 * _FEWEST_SAMPLES_A_CYCLE:
        return ()
    return (
        f"the record has {samples_per_cycle:.1f} samples a cycle: extremes between them are not counted, and noise is; "
        f"{_FEWEST_SAMPLES_A_CYCLE:g} samples a cycle miss up to 5 % of an amplitude. For a list of turning points this does "
        "not matter.",
    )


def run(plan: Plan, work: Work) -> Iterator[LoadHistory]:
    """Yield the findings after each leg."""
    if isinstance(plan.signal, Channel):
        time, values = TurningPoints().update(plan.signal.time, plan.signal.values).points_to_end()
        yield LoadHistory(time, values, float(plan.signal.time[-1]))
    elif plan.case is not None:
        yield from load_histories(plan.case, plan.signal, work, bearings_from=plan.spec.after or 0.0)


@dataclass(frozen=True, eq=False)
class CountedLoad:
    """A counted load.

    cycles: all counted ones. rows: one for each range or class of ranges; row (m,): that of each cycle. class_width:
    of the rows, None where each range has one. levels, crossings (k,): of level crossings.
    """

    cycles: LoadCycles
    rows: LoadCycles
    row: np.ndarray
    class_width: float | None
    levels: np.ndarray = field(default_factory=lambda: np.empty(0))
    crossings: np.ndarray = field(default_factory=lambda: np.empty(0))


def count_load(plan: Plan, values: np.ndarray, levels: np.ndarray | None = None) -> CountedLoad:
    """Count the load of turning points (m,). levels (k,): those of a longer signal, so that both can be compared."""
    method, residue = plan.spec.counting, plan.spec.residue
    if method in ("rainflow", "range-pair"):
        count = rainflow if method == "rainflow" else range_pairs
        return _load_in_rows(count(values, residue), plan.class_width)
    is_closed = residue == "repeat"
    if method == "peaks":
        peaks, valleys = peaks_and_valleys(values, plan.reference, is_closed)
        middle = plan.reference if plan.reference is not None else float(values.mean()) if len(values) else 0.0
        return _load_in_rows(cycles_of_peaks(peaks, valleys, middle), plan.class_width)
    if not np.ptp(values if len(values) else np.zeros(1)):
        return _load_in_rows(LoadCycles.empty(), plan.class_width)
    history = np.append(values, values[0]) if is_closed else values
    levels = _levels(values, plan.class_width, plan.reference) if levels is None else levels
    crossings = level_crossings(history, levels, plan.reference)
    cycles = cycles_of_levels(levels, crossings)
    rows, row = cycles.group_by_range()
    return CountedLoad(cycles, rows, row, float(levels[1] - levels[0]) if len(levels) > 1 else None, levels, crossings)


def _load_in_rows(cycles: LoadCycles, width: float | None) -> CountedLoad:
    rows, row = cycles.group_by_range(width)
    if width is None and len(rows.ranges) > MOST_ROWS:
        width = cycles.largest / _CLASSES
        rows, row = cycles.group_by_range(width)
    return CountedLoad(cycles, rows, row, width)


def _levels(values: np.ndarray, width: float | None, reference: float | None) -> np.ndarray:
    """Return evenly spaced levels (k,): at multiples of a width from the reference, or in the middle of a hundred classes."""
    low, high = float(values.min()), float(values.max())
    if width is None:
        step = (high - low) / _CLASSES
        return np.asarray(low + step * (np.arange(_CLASSES) + 0.5))
    origin = reference or 0.0
    first, last = np.ceil((low - origin) / width - _ROUNDING), np.floor((high - origin) / width + _ROUNDING)
    return np.clip(origin + width * np.arange(first, last + 1), low, high)
