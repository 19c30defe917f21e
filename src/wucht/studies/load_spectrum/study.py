"""The question of a load spectrum: the source of the signal, the count of its turning points, and its damage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field

from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal, rotor_signal
from wucht.dynamics.run_ups.observed_loads import LoadHistory, load_histories
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.fatigue.counting import Residue, TurningPoints
from wucht.fatigue.load_counting import CountingMethod, LoadCounting
from wucht.machines.machine import Machine
from wucht.measurements.recording import Channel
from wucht.schema import SI, Composite, Unit, composite, read_quantity, si, validate_table
from wucht.studies.answer import Answer
from wucht.studies.key_types import Value
from wucht.studies.load_spectrum.answer import Prepared, fill_load, refuse_narrow_classes
from wucht.studies.load_spectrum.figure import load_figure
from wucht.studies.load_spectrum.load_records import RecordColumn, Records
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import MachineSignalName, Woehler, woehler_line, woehler_validator
from wucht.studies.single_run import SingleRun

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_SIGNALS = (
    "'displacement', 'spring-force', 'bearing-force' or 'acceleration' of a machine's run-up, or a record: "
    "{ file = FILE, column = NAME }"
)


def _signal(value: Any) -> Any:
    if isinstance(value, Mapping):
        return validate_table(RecordColumn, value, "study.signal")
    if not isinstance(value, RecordColumn) and value not in get_args(MachineSignalName):
        raise ValueError(f"must be {_SIGNALS}")
    return value


class LoadSpectrum(SingleRun):
    """Count the cycles of a load, in a machine's run-up or in a record: spectrum, range-mean matrix, damage."""

    kind = "load-spectrum"
    next_questions = (NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),)
    subject = "wucht.studies.load_spectrum.load_records:MACHINE_OR_RECORDS"
    meaning = (*SingleRun.meaning, "signal")
    curves = (("cumulative", "range"),)

    signal: Composite[Annotated[MachineSignalName | RecordColumn, BeforeValidator(_signal)]] = composite(
        default="displacement",
        title="signal",
        description='`"displacement"` of the carrier, `"spring-force"`, `"bearing-force"` (of the bodies on it) or '
        '`"acceleration"` in a `direction`, or a record, with its file and column',
    )
    direction: Literal["x", "y", "r"] | None = Field(
        default=None, description="direction of the signal, by default the first that the machine has"
    )
    rotor: str | None = Field(default=None, min_length=1, title="rotor of the bearing", description=(
        'name of a rotor: the `"bearing-force"` is then that of its bearing, by default of all bodies together'
    ))  # fmt: skip
    after: SI[float | None] = si("s", "time from which counting starts", default=None, ge=0, help=(
        "time from which counting starts, so that the run-up itself can be left out"
    ))  # fmt: skip
    counting: CountingMethod = Field(
        default="rainflow",
        description='counting method: `"rainflow"`, `"range-pair"`, `"level-crossing"` or `"peaks"` (ASTM E1049)',
    )
    residue: Residue = Field(default="half-cycles", description=(
        'treatment of ranges that close no cycle: `"half-cycles"`, `"repeat"` (the history is repeated) or '
        '`"drop"`'
    ))  # fmt: skip
    reference: Value | None = Field(default=None, title="reference of level crossings and peaks", description=(
        "reference of level crossings and peaks; without one all rising crossings and all peaks count"
    ))  # fmt: skip
    class_width: Value | None = Field(default=None, title="width of the classes", description=(
        "width of the classes of range and level; by default there are no classes as long as the different ranges are few"
    ))  # fmt: skip
    woehler: Composite[Annotated[Woehler | None, woehler_validator("study.woehler")]] = composite(
        default=None, description="Woehler line for the damage, a table"
    )

    @property
    def record(self) -> RecordColumn | None:
        """Return the record, None for a machine's run-up."""
        return self.signal if isinstance(self.signal, RecordColumn) else None

    def check(self) -> None:
        """Check that keys of a run-up come only with one, and other keys only where they apply."""
        if self.record is not None:
            for key in (*SingleRun.model_fields, "direction", "rotor"):
                if key in self.model_fields_set:
                    raise InputError(f"study.{key}", getattr(self, key), "only allowed for a machine's run-up, not a record")
        if self.rotor is not None and self.signal != "bearing-force":
            raise InputError("study.rotor", self.rotor, "allowed only with signal = 'bearing-force'")
        if self.model == "both":
            raise InputError("study.model", self.model, "must be 'full' or 'slow': a spectrum belongs to one motion")
        if self.after is not None and self.until is not None and self.after >= self.until:
            raise InputError("study.after", self.after, f"must be less than study.until, {self.until:g}")
        if self.reference is not None and self.counting in ("rainflow", "range-pair"):
            raise InputError("study.reference", self.reference, "allowed only with counting = 'level-crossing' or 'peaks'")
        if self.counting in ("level-crossing", "peaks") and self.residue == "drop":
            raise InputError("study.residue", self.residue, "must be 'half-cycles' or 'repeat': there is no residue to drop")
        if self.woehler is not None:
            self.woehler.check("study.woehler")
        super().check()

    def table_for(self, subject: Any) -> dict[str, Any]:
        """See ``Study``: a changed record is another question."""
        question = self.to_table()
        if self.record is not None:
            question["signal"]["contents"] = subject.contents(self.record.file)
        return question

    def prepare(self, subject: Machine | Records) -> Prepared:
        """Return what is counted, and how. Raises ``InputError``."""
        signal, case = self._machine_signal(subject) if isinstance(subject, Machine) else (self._recorded_signal(subject), None)
        width = self._quantity_at("class_width", signal.unit, "width of the classes")
        if width is not None and width <= 0:
            raise InputError("study.class_width", self.class_width, "must be a width greater than 0")
        if isinstance(signal, Channel):  # the span of a machine's signal is known only after its run
            refuse_narrow_classes(signal.values, width)
        reference = self._quantity_at("reference", signal.unit, "reference")
        line = None if self.woehler is None else woehler_line(self.woehler, signal.unit, "study.woehler")
        return signal, case, LoadCounting(self.counting, self.residue, reference, width), line

    def stored_numbers(self, prepared: Prepared) -> float:
        """Bound: time and value of two turning points a turn at the highest speed expected."""
        _, case, *_ = prepared
        return 0.0 if case is None else 4 * case.horizon.first / (case.horizon.step * case.horizon.samples_per_turn)

    def solve(self, subject: Machine | Records, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Count the record, or the run-up after each leg."""
        signal, case, *_ = prepared
        if isinstance(signal, Channel):
            time, values = TurningPoints().update(signal.time, signal.values).points_to_end()
            history = LoadHistory(time, values, float(signal.time[-1]))
            yield Answer(fill=partial(fill_load, prepared, self.after, history))
        elif case is not None:
            for history in load_histories(case, signal, work, bearings_from=self.after or 0.0):
                yield Answer(case.machine.units, partial(fill_load, prepared, self.after, history))

    def draw(self, result: xr.Dataset) -> Figure:
        """See ``Study``."""
        return load_figure(result)

    def _machine_signal(self, machine: Machine) -> tuple[MachineSignal, RunUpCase]:
        if self.record is not None:
            raise InputError("study.signal", self.record.file, "give either a table [machine] or a record")
        case = RunUpCase.of(machine, self.start, self.settings)
        if self.rotor is None:
            return machine_signal(case.machine, str(self.signal), self.direction), case
        return rotor_signal(case.machine, self.rotor, self.direction), case

    def _recorded_signal(self, records: Records) -> Channel:
        if self.record is None:
            reason = "a table [machine] is required, or a record: signal = { file = FILE, column = NAME }"
            raise InputError("study.signal", self.signal, reason)
        signal = records.channel(self.record)
        last = float(signal.time[-1])
        if self.after is not None and self.after >= last:
            raise InputError("study.after", self.after, f"must be less than the time at which the record ends, {last:g} s")
        return signal

    def _quantity_at(self, key: str, unit: str, quantity: str) -> float | None:
        """Read a key in the unit of the signal; in a unit outside SI, a number. Raises ``InputError``."""
        value: Value | None = getattr(self, key)
        return None if value is None else read_quantity(Unit(unit, quantity), value, f"study.{key}")
