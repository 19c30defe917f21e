"""The specification of a study: its common keys, and the types of its fields.

A spec is a frozen table with units. It is always checked when it is built, and knows no machine: checks that need the subject
are made once, in the study's ``prepare``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr, model_validator

from wucht.earlier_names import present_engine
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE
from wucht.schema import TableModel, Unit, read_quantity, unit_of
from wucht.studies.next_question import NextQuestion

FULL_EQUATIONS, AVERAGED_EQUATIONS = "full equations of motion", "averaged equations"  # wording of ``assumptions``


class Spec(TableModel):
    """The question of a study.

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

    _raw_values: dict[str, Any] = PrivateAttr(default_factory=dict)

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


def _validator(
    is_allowed: Callable[[Any], bool], sentence: str, convert: Callable[[Any], Any] = lambda raw: raw
) -> BeforeValidator:
    """Validator of a raw value, with the sentence for forbidden values. convert: applied to the others."""

    def validate(raw: Any) -> Any:
        if not is_allowed(raw):
            raise ValueError(sentence)
        return convert(raw)

    return BeforeValidator(validate)


def _is_bool(raw: Any) -> bool:
    return isinstance(raw, bool)


def _is_list(raw: Any, of: type = object) -> bool:
    return isinstance(raw, list | tuple) and all(isinstance(one, of) for one in raw)


def is_whole(raw: Any) -> bool:
    """True for a whole number; 5.0, as given by ``--set``, is one."""
    return not _is_bool(raw) and (isinstance(raw, int) or (isinstance(raw, float) and raw.is_integer()))


def _is_path(raw: Any) -> bool:
    return isinstance(raw, str) and raw.strip() != ""


def _to_tables(raw: list[Mapping[str, Any]]) -> tuple[dict[str, Any], ...]:
    return tuple(map(dict, raw))


def _check_order(raw: tuple[float, float]) -> tuple[float, float]:
    if not raw[0] < raw[1]:
        raise ValueError("must be a pair [low, high] with low below high")
    return raw


_quantity = _validator(lambda raw: not _is_bool(raw), "must be a number, or a string with a unit")
_start = _validator(
    lambda raw: isinstance(raw, Mapping), "must be a table: start = { BODY = ANGLE } or { BODY = { speed = SPEED } }", dict
)
_starts = _validator(
    lambda raw: _is_list(raw, Mapping), "must be a list of tables: starts = [{ BODY = ANGLE }, ...]", _to_tables
)
_path = _validator(_is_path, "must be the path of a parameter, such as drive.slope")
_values = _validator(_is_list, "must be a list of values of the parameter that along names", tuple)
_pair = _validator(lambda raw: _is_list(raw) and len(raw) == 2, "must be a pair [low, high]", tuple)
_whole = _validator(is_whole, "must be a whole number", int)
_order = _validator(lambda raw: not _is_bool(raw) and raw in (1, 2), "must be 1 or 2: the order of the averaged equations", int)
_inertia = _validator(_is_bool, "must be true or false: true keeps the inertia in the averaged equations")

Value = Annotated[float | str, _quantity]  # in the unit of a parameter of the subject
Start = Annotated[dict[str, Any], _start, Field(title="initial state", description=(
    'angles and speeds at the start by the names of the bodies, `{ p1 = "0.3 rad" }`; by default at rest, hanging under gravity'
))]  # fmt: skip
Starts = Annotated[tuple[dict[str, Any], ...], _starts, Field(title="initial states")]
Path = Annotated[str, _path, Field(title="path of a parameter")]
Values = Annotated[tuple[Value, ...], _values, Field(title="values of the parameter")]
Pair = Annotated[tuple[Value, Value], _pair, Field(title="pair [low, high] of the parameter")]
Interval = Annotated[tuple[float, float], _pair, AfterValidator(_check_order)]  # of a quantity declared by ``si``
Whole = Annotated[int, _whole]
Order = Annotated[Literal[1, 2], _order, Field(description=(
    "order of the averaged equations, 1 or 2; they hold over times 1/epsilon, but for undamped librations of rotors or "
    "bodies over a few librations only"
))]  # fmt: skip
Inertia = Annotated[bool, _inertia, Field(description=(
    "whether the averaged equations keep the inertia of the balancing bodies, by default if one of them is not damped"
))]  # fmt: skip
BalancingBodies = Annotated[Literal["steady", "held"] | None, Field(description=(
    'where bodies are: `"steady"`, balancing bodies in the steady phases of each speed, a curve for each configuration, '
    "as in `synchronous-states`, several rotors and the bodies about them in their stable synchronous configurations, a curve "
    "for each, whose phases are the same at all speeds (phases in `start` select the nearest one); "
    '`"held"`, at the phases of `start`, at all speeds. By default steady if these phases are known, else held with a warning'
))]  # fmt: skip
TrueOrFalse = Annotated[bool, _validator(_is_bool, "must be true or false")]
Tolerance = Annotated[
    float,
    BeforeValidator(Unit("", "tolerance").parse_quantity),
    Field(ge=1e-16, le=1e-2, description="tolerance of the integration"),
]
Engine = Annotated[
    Literal["compiled", "radau"],
    BeforeValidator(lambda raw: present_engine(raw) if isinstance(raw, str) else raw),
    Field(description="engine of the integration: compiled, the default, or radau for stiff equations"),
]

__all__ = [
    "DEFAULT_TOLERANCE",
    "BalancingBodies",
    "Engine",
    "Inertia",
    "Interval",
    "Order",
    "Pair",
    "Path",
    "Spec",
    "Start",
    "Starts",
    "Tolerance",
    "Value",
    "Values",
    "Whole",
]  # fmt: skip
