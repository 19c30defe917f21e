"""The study ``entrainment``: rotors that a vibration or each other take along. 001, sections 2.2 and 2.3."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from wucht.documents import refuse_unknown
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.quantities import Unit
from wucht.studies.entrainment.along import MOTION, along_of, read_along, unit_of, widest
from wucht.studies.entrainment.search import Record, expected_steps, search
from wucht.studies.keeper import Keeper
from wucht.studies.keys import positive, span, start_of, whole
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.locking import is_locking
from wucht.studies.run_up.study import RunUp, prepared

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_POINTS = 25
_FEWEST, _MOST = 5, 2000


@dataclass(frozen=True)
class Entrainment:
    """In which band of a parameter rotors are taken along, and with which phase.

    along: a parameter, or ``"detuning"``, the difference of two motors' no-load speeds. range: of it that is looked at; None:
    the band of existence and a margin. points: runs from the start, evenly over the range. resolution: of the edges, in the
    parameter's unit. start: see ``start_state``. until: how long a run goes on at least; None: as the slow equations ask.
    """

    along: str
    range: tuple[float, float] | None = None
    points: int = DEFAULT_POINTS
    resolution: float | None = None
    start: Mapping[str, Any] = field(default_factory=dict)
    until: float | None = None

    kind: ClassVar[str] = "entrainment"
    keys: ClassVar[tuple[str, ...]] = ("kind", "along", "range", "points", "resolution", "start", "until")

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> Entrainment:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        _refuse_others(machine)
        along = read_along(table, machine)
        points = whole(table, "points", DEFAULT_POINTS, _FEWEST, _MOST)
        unit = unit_of(machine, along)
        until = positive(table, "until", Unit(machine.units.time, "time"))
        return cls(along, span(table, "range", unit), points, positive(table, "resolution", unit), start_of(table), until)

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the start or the range does not fit the machine."""
        _refuse_others(machine)
        along = along_of(machine, self.along)
        if self.range is None and widest(machine, along) is None:
            raise InputError("study.range", None, f"this key is missing; needed is a pair [low, high] of a {along.what}")
        for i, value in enumerate(self.range or ()):
            if along.name == MOTION and value < 0:
                raise InputError(f"study.range[{i}]", value, "allowed is an amplitude from 0 on")
            along.allowed(machine, value, f"study.range[{i}]")
        prepared(machine, RunUp(start=self.start, until=self.until))


def _refuse_others(machine: Machine) -> None:
    """Raises ``InputError`` for machines in which nothing can be taken along."""
    if not is_locking(machine):
        raise InputError(
            "machine", None, "nothing can be taken along: needed is a carrier.motion of amplitude and frequency, or two rotors "
            "or more whose speed no drive prescribes",
        )  # fmt: skip
    given = [r.name for r in machine.rotors if r.coordinate.prescribed is not None]
    if given:
        raise InputError("machine.drive", None, f"the drive prescribes the speed of {given[0]!r}: it cannot be taken along")


@np.errstate(all="ignore")  # a run that fails says so in a sentence, not by warnings about overflow
def entrainment(
    machine: Machine,
    question: Entrainment,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """The band in which rotors are taken along: that in which such a motion exists, and that reached from the start.

    Returns the Dataset of ``entrainment.result``. progress: called with steps done and to do. checkpoint: called now and then
    with the result so far. resume: an earlier result, also of another range, whose runs from the start are not made again.
    Raises ``InputError`` for a question that does not fit.
    """
    from wucht.studies.entrainment.kept import restored
    from wucht.studies.entrainment.result import asked as asked_of
    from wucht.studies.entrainment.result import result
    from wucht.studies.resuming import check_same

    begun = clock.perf_counter()
    question.check(machine)
    asked = RunUp(start=question.start, until=question.until)
    machine, _ = prepared(machine, asked)
    record, along = Record(), along_of(machine, question.along)
    if resume is not None:
        check_same(resume, asked_of(machine, question), "machine, parameter, start or until")
    known = [] if resume is None else restored(machine, resume)

    def described() -> xr.Dataset:
        return result(machine, question, along, record, begun)

    steps = _Steps(expected_steps(question.points), progress, checkpoint, described)
    try:
        search(machine, question, along, asked, record, steps, known)
    except KeyboardInterrupt:
        record.interrupted = True
    return described()


class _Steps:
    """Tells how far the study is, and saves now and then."""

    def __init__(
        self, total: int, progress: Progress | None, checkpoint: Checkpoint | None, describe: Callable[[], xr.Dataset]
    ) -> None:
        self._done, self._total, self._progress = 0, total, progress
        self._keep, self._describe = Keeper(checkpoint), describe

    def __call__(self) -> None:
        self.to(self._done + 1)

    def to(self, done: int) -> None:
        """So many steps are done."""
        self._done = max(self._done, min(done, self._total - 1))
        self.watch()
        self._keep(self._describe)

    def watch(self) -> None:
        """Tell how far it is; here the user may stop it."""
        if self._progress is not None:
            self._progress(float(self._done), float(self._total))

    def end(self) -> None:
        """All is done."""
        if self._progress is not None:
            self._progress(float(self._total), float(self._total))


__all__ = ["Entrainment", "Record", "entrainment"]
