"""The question of a load spectrum."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.fatigue.counting import Residue
from wucht.schema import SI, Composite, TableModel, composite, si, validate_table
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import MachineSignalName, Woehler, woehler_validator
from wucht.studies.single_run import SingleRun
from wucht.studies.spec import Spec, Value

_SIGNALS = (
    "'displacement', 'spring-force', 'bearing-force' or 'acceleration' of a machine's run-up, or a record: "
    "{ file = FILE, column = NAME }"
)


class RecordColumn(TableModel):
    """A record of a load."""

    file: str = Field(min_length=1, description="file of the record")
    column: str | None = Field(default=None, min_length=1, title="column of the record", description=(
        "column of the record, which may be left out where there is only one"
    ))  # fmt: skip
    unit: str | None = Field(default=None, min_length=1, title="unit of the column's numbers", description=(
        "unit of the column's numbers, instead of the one that the file states"
    ))  # fmt: skip
    scale: SI[float | None] = si("", "factor for the column's numbers", default=None)


def _signal(value: Any) -> Any:
    if isinstance(value, Mapping):
        return validate_table(RecordColumn, value, "study.signal")
    if not isinstance(value, RecordColumn) and value not in get_args(MachineSignalName):
        raise ValueError(f"must be {_SIGNALS}")
    return value


class LoadSpectrum(SingleRun, Spec):
    """Count the cycles of a load, in a machine's run-up or in a record: spectrum, range-mean matrix, damage."""

    kind: ClassVar[str] = "load-spectrum"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    subject: ClassVar[str] = "wucht.studies.load_spectrum.computation:MACHINE_OR_RECORDS"
    meaning: ClassVar[tuple[str, ...]] = (*SingleRun.meaning, "signal")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("cumulative", "range"),)

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
    counting: Literal["rainflow", "range-pair", "level-crossing", "peaks"] = Field(
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
        """See ``Spec``: a changed record is another question."""
        question = self.to_table()
        if self.record is not None:
            question["signal"]["contents"] = subject.contents(self.record.file)
        return question
