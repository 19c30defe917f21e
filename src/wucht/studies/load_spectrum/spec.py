"""The question of a load spectrum."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.fatigue.rainflow_counting import Residue
from wucht.schema import Described, checked, si
from wucht.studies.load_keys import MachineSignalName, Woehler, woehler_at
from wucht.studies.single_run import SingleRun
from wucht.studies.spec import Quantity

_SIGNALS = (
    "'displacement', 'spring-force', 'bearing-force' or 'acceleration' of a machine's run-up, or a record: "
    "{ file = FILE, column = NAME }"
)


class Record(Described):
    """A record of a load.

    file, column: of it; column may be left out where there is only one. unit: of the column's numbers, instead of the one that
    the file states. scale: a factor for them.
    """

    file: str = Field(min_length=1, description="file of the record")
    column: str | None = Field(None, min_length=1, description="column of the record")
    unit: str | None = Field(None, min_length=1, description="unit of the column's numbers")
    scale: float | None = si("", "factor for the column's numbers", default=None)


def _signal(given: Any) -> Any:
    if isinstance(given, Mapping):
        return checked(Record, given, "study.signal")
    if not isinstance(given, Record) and given not in get_args(MachineSignalName):
        raise ValueError(f"must be {_SIGNALS}")
    return given


class LoadSpectrum(SingleRun):
    """Count the cycles of a load, in a machine's run-up or in a record: spectrum, range-mean matrix, damage.

    signal: ``"displacement"`` of the carrier, ``"spring-force"``, ``"bearing-force"`` (of the bodies on it) or
    ``"acceleration"`` in a ``direction`` (by default the first that the machine has), or a record, with its file and column.
    after: the time from which on is counted, so that the run-up itself can be left out. counting: ``"rainflow"``,
    ``"range-pair"``, ``"level-crossing"`` or ``"peaks"`` (ASTM E1049). residue: what becomes of ranges that close no cycle:
    ``"half-cycles"``, ``"repeat"`` (the history comes again and again) or ``"drop"``. reference: of level crossings and
    peaks; without one all rising crossings and all peaks count. class_width: of the classes of range and level; by default
    each range stands for itself, as far as they are few. woehler: a Woehler line, for the damage. until, turns, settled,
    start, model, inertia, order, tolerance, speed_limit, engine: of the run-up, see ``RunUp``.
    """

    kind: ClassVar[str] = "load-spectrum"
    subject: ClassVar[str] = "wucht.studies.load_spectrum.machine_or_records:MACHINE_OR_RECORDS"
    meaning: ClassVar[tuple[str, ...]] = (*SingleRun.meaning, "signal")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("cumulative", "range"),)
    headline: ClassVar[tuple[str, ...]] = ("cycles", "damage")

    signal: Annotated[MachineSignalName | Record, BeforeValidator(_signal)] = Field("displacement", description="signal")
    direction: Literal["x", "y", "r"] | None = Field(None, description="direction of the signal")
    after: float | None = si("s", "time from which on is counted", default=None, ge=0)
    counting: Literal["rainflow", "range-pair", "level-crossing", "peaks"] = Field("rainflow", description="counting method")
    residue: Residue = Field("half-cycles", description="what becomes of ranges that close no cycle")
    reference: Quantity | None = Field(None, description="reference of level crossings and peaks")
    class_width: Quantity | None = Field(None, description="width of the classes")
    woehler: Annotated[Woehler | None, woehler_at("study.woehler")] = Field(None, description="Woehler line")

    @property
    def record(self) -> Record | None:
        """The record, None of a machine's run-up."""
        return self.signal if isinstance(self.signal, Record) else None

    def check(self) -> None:
        """The keys of a run-up only with one, and each key only where it says something."""
        if self.record is not None:
            for key in (*SingleRun.model_fields, "direction"):
                if key in self.model_fields_set:
                    raise InputError(f"study.{key}", getattr(self, key), "allowed only of a machine's run-up, not of a record")
        if self.model == "both":
            raise InputError("study.model", self.model, "must be 'full' or 'slow': a spectrum is counted of one motion")
        if self.after is not None and self.until is not None and self.after >= self.until:
            raise InputError("study.after", self.after, f"must be less than study.until, {self.until:g}")
        if self.reference is not None and self.counting in ("rainflow", "range-pair"):
            raise InputError("study.reference", self.reference, "allowed only with counting = 'level-crossing' or 'peaks'")
        if self.counting in ("level-crossing", "peaks") and self.residue == "drop":
            raise InputError("study.residue", self.residue, "must be 'half-cycles' or 'repeat': here is no residue to drop")
        if self.woehler is not None:
            self.woehler.check("study.woehler")
        super().check()

    def asked_of(self, subject: Any) -> dict[str, Any]:
        """See ``Spec``: a changed record is another question."""
        asked = self.asked()
        if self.record is not None:
            asked["signal"]["contents"] = subject.contents(self.record.file)
        return asked
