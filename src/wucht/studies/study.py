"""A study: a question with its keys, the answer that it fills, and the figure of its result.

A study is a frozen table with units: its fields are the keys of ``[study]``, checked when it is built. It knows no subject:
checks that need the subject are made once, in ``prepare``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from inspect import isgeneratorfunction, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import PrivateAttr, model_validator

from wucht.dynamics.work import Work
from wucht.results.report import report_of
from wucht.schema import TableModel, Unit, read_quantity, unit_of
from wucht.studies.answer import Answer
from wucht.studies.next_question import NextQuestion

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FULL_EQUATIONS, AVERAGED_EQUATIONS = "full equations of motion", "averaged equations"  # wording of ``assumptions``


class Study(TableModel):
    """A study: its fields are the keys of ``[study]``; ``prepare`` checks, ``solve`` fills an ``Answer``, ``draw`` shows it.

    A class with a ``kind`` is a study, wherever it stands; ``extending`` has all names that one needs.

    subject: kind of subject, as ``module:name`` of a ``studies.subjects.Subject``. one_of: groups of keys that are one choice:
    setting one from the command line replaces the others. horizon: keys that only limit the extent of the study.
    meaning: keys with a different meaning in each study, so that their values in a file for another study are dropped.
    tiled: true if the study has independent units of work (``Work.units``), which several machines can compute.
    curves: variables of the result, x and y of each curve in a comparison of several results. curves_of_equations: those where
    the subject is a table [system].
    without_inertia: true if averaged equations omit the inertia of balancing bodies by default, provided all are damped.
    solves: the equations, if the study itself determines them: see ``equations``.
    from_start: true if it runs the machine from ``start``: the places of bodies without an entry there are then assumed.
    next_questions: what could be asked after it, the first that follows from its answer being proposed.
    trials: keys of the summary with candidates that were tried and not chosen: a report leaves them out by default.
    """

    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE"
    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    horizon: ClassVar[tuple[str, ...]] = ()
    meaning: ClassVar[tuple[str, ...]] = ("range", "along", "values", "rate", "points")
    tiled: ClassVar[bool] = False
    curves: ClassVar[tuple[tuple[str, str], ...]] = ()
    curves_of_equations: ClassVar[tuple[tuple[str, str], ...]] = ()
    without_inertia: ClassVar[bool] = False
    solves: ClassVar[str] = ""
    from_start: ClassVar[bool] = False
    next_questions: ClassVar[tuple[NextQuestion, ...]] = ()
    trials: ClassVar[tuple[str, ...]] = ()

    _raw_values: dict[str, Any] = PrivateAttr(default_factory=dict)

    if TYPE_CHECKING:
        prepare: ClassVar[Callable[..., Any]]
    else:

        def prepare(self, subject: Any) -> Any:
            """Check what depends on the subject, and return what ``solve`` needs of it, as plain values.

            One that takes seconds has a second parameter ``watch``, a function that it calls often. Raises ``InputError`` where
            the question does not fit the subject.
            """

    def prepare_watched(self, subject: Any, watch: Callable[[], None]) -> Any:
        """Return what ``prepare`` returns, which gets the function to call often if it has a parameter for it."""
        return self.prepare(subject, watch) if "watch" in signature(self.prepare).parameters else self.prepare(subject)

    def solve(self, subject: Any, prepared: Any, work: Work) -> Iterator[Answer]:
        """Yield the answer whenever it has become more complete. Its units of work are stored and resumed."""
        raise NotImplementedError

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the figure of a result, from the Dataset alone: the keys of the study are in ``result.wucht.spec``."""
        raise NotImplementedError

    def stored_numbers(self, prepared: Any) -> float:
        """Return the greatest number of values that a result stores; 0 for a study whose points and cells are limited."""
        return 0.0

    def export(self, result: xr.Dataset, folder: Path) -> list[str]:
        """Write files for other programs, and return a line for each. Studies without such files do not have this method."""
        raise NotImplementedError

    @classmethod
    def exports(cls) -> bool:
        """True if it has files for other programs."""
        return cls.export is not Study.export

    def report(self, result: xr.Dataset) -> list[str]:
        """Return the report of a result in words: the lines of its answer."""
        return report_of(result)

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        """Refuse a study that lacks a method. Raises ``TypeError``."""
        super().__pydantic_init_subclass__(**options)
        if "kind" in vars(cls) and cls.kind:
            try:
                if not isinstance(cls.kind, str):
                    raise TypeError(f"{cls.__name__}: its kind must be a text, not {cls.kind!r}")
                cls.check_class()
            except TypeError:
                cls.kind = ""  # it exists until it is collected, and is no study until then
                raise

    @classmethod
    def check_class(cls) -> None:
        """Raise ``TypeError`` if the class lacks what a study must have."""
        name = f"{cls.__name__}, a study of the kind {cls.kind!r},"
        if not isgeneratorfunction(cls.solve) or cls.solve is Study.solve or not _takes(cls.solve, 4):
            raise TypeError(f"{name} must have a method solve(self, subject, prepared, work) that yields an Answer")
        if cls.draw is Study.draw or not _takes(cls.draw, 2):
            raise TypeError(f"{name} must have a method draw(self, result)")
        if not _takes(cls.prepare, 3 if "watch" in signature(cls.prepare).parameters else 2):
            raise TypeError(f"{name} must have a method prepare(self, subject) or prepare(self, subject, watch)")

    @classmethod
    def error_location(cls) -> str:
        """Name of the table in a file."""
        return "study"

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Self:
        """Build the spec from the table ``[study]`` of a file. Raises ``InputError``."""
        return cls(**{k: v for k, v in table.items() if k != "kind"})

    @classmethod
    def keys(cls) -> tuple[str, ...]:
        """The keys of the table ``[study]``."""
        return ("kind", *cls.model_fields)

    @model_validator(mode="wrap")
    @classmethod
    def _keep_raw_values(cls, raw: Any, build: Any) -> Any:
        """Keep the quantities as they were written: a given unit is an error if the subject has none."""
        if isinstance(raw, Mapping):
            for location, one, unit in cls._quantities(raw):
                if location.endswith("]"):  # an item of a list: pydantic would only locate the list
                    read_quantity(unit, one, location)
        spec = build(raw)
        if isinstance(raw, Mapping):  # without words for another key, such as until = "settled"
            spec._raw_values = {k: v for k, v in raw.items() if getattr(spec, k, None) is not None}
        spec.check()
        return spec

    def check(self) -> None:
        """Raise ``InputError`` if keys are inconsistent."""

    def equations(self) -> str:
        """The solved equations, in words with ``FULL_EQUATIONS`` and ``AVERAGED_EQUATIONS``; empty: by the key ``model``."""
        return self.solves

    def turning(self) -> str:
        """The speed of the machine in words, if the study prescribes it; empty: as driven."""
        return ""

    def to_table(self) -> dict[str, Any]:
        """The question as a table, for a result: the keys that are given or have a default."""
        return {"kind": self.kind} | {k: v for k, v in self.model_dump(mode="json").items() if v is not None}

    def given_table(self) -> dict[str, Any]:
        """The keys that were given, as they were written."""
        return self.model_dump(mode="json", exclude_defaults=True) | deepcopy(self._raw_values)

    def table_for(self, subject: Any) -> dict[str, Any]:
        """The question about a subject, with everything that affects the answer: the contents of files that it names.

        Questions with equal tables are the same, and completed units of work are reused.
        """
        return self.to_table()

    def refuse_units(self) -> None:
        """Raise ``InputError`` if a quantity has a unit: the subject is dimensionless."""
        for location, one, unit in self._quantities(self._raw_values):
            read_quantity(Unit("", unit.long_name), one, location)

    @classmethod
    def _quantities(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, Any, Unit]]:
        """Location, written value and unit of each quantity of a table."""
        for key, raw in table.items():
            unit = unit_of(cls.model_fields.get(key))
            if unit is not None and isinstance(raw, list | tuple):
                yield from ((f"study.{key}[{i}]", one, unit) for i, one in enumerate(raw))
            elif unit is not None:
                yield f"study.{key}", raw, unit


def _takes(method: Callable[..., Any], count: int) -> bool:
    """True if a function can be called with so many values, the first of which is ``self``."""
    try:
        signature(method).bind(*range(count))
    except TypeError:
        return False
    return True
