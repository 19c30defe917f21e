"""What is asked: the specification of a study, its common keys, and the types of its fields.

A spec is a frozen table with units. It is checked when it is built, by whatever builds it, and knows no machine: what needs the
subject is checked once, in the study's ``prepare``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr, model_validator

from wucht.numerics.flow.compiled import DEFAULT_TOLERANCE
from wucht.schema import Described, Unit, read_quantity, unit_of

FULL, AVERAGED = "full equations of motion", "averaged equations"  # as ``assumptions`` words them


class Spec(Described):
    """A question.

    subject: what it is asked of, as ``module:name`` of a ``studies.subjects.Subject``. one_of: groups of keys that are one
    choice: setting one from the command line replaces the others. horizon: keys that only say how far the study goes.
    meaning: keys that mean something else in each study, so that a file written for another study does not answer them.
    tiled: whether the study has independent units of work (``Work.units``), which can be computed by several machines.
    curves: variables of the result, x and y of each curve that is drawn where several results are compared.
    without_inertia: whether averaged equations leave out that of balancing bodies by default, where all of them are damped.
    solves: which equations, where the study itself decides that: see ``equations``.
    from_start: whether it runs the machine from ``start``: where bodies are that this does not name is then assumed.
    """

    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE"
    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    horizon: ClassVar[tuple[str, ...]] = ()
    meaning: ClassVar[tuple[str, ...]] = ("range", "along", "values", "rate", "points")
    tiled: ClassVar[bool] = False
    curves: ClassVar[tuple[tuple[str, str], ...]] = ()
    without_inertia: ClassVar[bool] = False
    solves: ClassVar[str] = ""
    from_start: ClassVar[bool] = False

    _written: dict[str, Any] = PrivateAttr(default_factory=dict)

    @classmethod
    def where(cls) -> str:
        """The table of a file."""
        return "study"

    @classmethod
    def read(cls, table: Mapping[str, Any]) -> Self:
        """From the table ``[study]`` of a file. Raises ``InputError``."""
        return cls(**{k: v for k, v in table.items() if k != "kind"})

    @classmethod
    def keys(cls) -> tuple[str, ...]:
        """The keys of the table ``[study]``."""
        return ("kind", *cls.model_fields)

    @model_validator(mode="wrap")
    @classmethod
    def _keep_what_was_written(cls, given: Any, build: Any) -> Any:
        """Quantities as they were written: whether a unit was given counts where the subject has none."""
        if isinstance(given, Mapping):
            for where, one, unit in cls._quantities(given):
                if where.endswith("]"):  # an item of a list: pydantic would locate the list
                    read_quantity(unit, one, where)
        spec = build(given)
        if isinstance(given, Mapping):  # without those that are words for another key, as until = "settled"
            spec._written = {k: v for k, v in given.items() if getattr(spec, k, None) is not None}
        spec.check()
        return spec

    def check(self) -> None:
        """Raises ``InputError`` where keys do not fit each other."""

    def equations(self) -> str:
        """Which equations it solves, in words made of ``FULL`` and ``AVERAGED``; empty: those of its key ``model``."""
        return self.solves

    def turning(self) -> str:
        """How fast the machine turns, in words, where the study decides that; empty: as its drives turn it."""
        return ""

    def asked(self) -> dict[str, Any]:
        """What was asked, for a result: the keys that are given or have a default."""
        return {"kind": self.kind} | {k: v for k, v in self.model_dump(mode="json").items() if v is not None}

    def asked_of(self, subject: Any) -> dict[str, Any]:
        """The same of a subject, with all from which another answer would follow: the contents of files that it names.

        Two questions with the same are one, and what is done of it is taken up again.
        """
        return self.asked()

    def refuse_units(self) -> None:
        """Raises ``InputError`` where a quantity has a unit: the subject is dimensionless."""
        for where, one, unit in self._quantities(self._written):
            read_quantity(Unit("", unit.what), one, where)

    @classmethod
    def _quantities(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, Any, Unit]]:
        """Where each quantity of a table stands, what is written there, and its unit."""
        for key, given in table.items():
            unit = unit_of(cls.model_fields.get(key))
            if unit is not None and isinstance(given, list | tuple):
                yield from ((f"study.{key}[{i}]", one, unit) for i, one in enumerate(given))
            elif unit is not None:
                yield f"study.{key}", given, unit


def _must(allowed: Callable[[Any], bool], sentence: str, read: Callable[[Any], Any] = lambda given: given) -> BeforeValidator:
    """A check of what is given, and the sentence for what is not allowed. read: what is made of the rest."""

    def checked(given: Any) -> Any:
        if not allowed(given):
            raise ValueError(sentence)
        return read(given)

    return BeforeValidator(checked)


def _is_bool(given: Any) -> bool:
    return isinstance(given, bool)


def _is_list(given: Any, of: type = object) -> bool:
    return isinstance(given, list | tuple) and all(isinstance(one, of) for one in given)


def is_whole(given: Any) -> bool:
    """Whether a whole number is given: 5.0, as ``--set`` has it, is one."""
    return not _is_bool(given) and (isinstance(given, int) or (isinstance(given, float) and given.is_integer()))


def _is_path(given: Any) -> bool:
    return isinstance(given, str) and given.strip() != ""


def _tables(given: list[Mapping[str, Any]]) -> tuple[dict[str, Any], ...]:
    return tuple(map(dict, given))


def _low_below_high(given: tuple[float, float]) -> tuple[float, float]:
    if not given[0] < given[1]:
        raise ValueError("must be a pair [low, high] with low below high")
    return given


_quantity = _must(lambda given: not _is_bool(given), "must be a number, or a string with a unit")
_start = _must(
    lambda given: isinstance(given, Mapping), "must be a table: start = { BODY = ANGLE } or { BODY = { speed = SPEED } }", dict
)
_starts = _must(lambda given: _is_list(given, Mapping), "must be a list of tables: starts = [{ BODY = ANGLE }, ...]", _tables)
_path = _must(_is_path, "needed is the path of a parameter, such as drive.slope")
_values = _must(_is_list, "must be a list of values of the parameter that along names", tuple)
_pair = _must(lambda given: _is_list(given) and len(given) == 2, "must be a pair [low, high]", tuple)
_whole = _must(is_whole, "must be a whole number", int)
_order = _must(
    lambda given: not _is_bool(given) and given in (1, 2), "must be 1 or 2: the order of the averaged equations", int
)
_inertia = _must(_is_bool, "must be true or false: whether the averaged equations keep it")

Value = Annotated[float | str, _quantity]  # in the unit of a parameter of the subject
Start = Annotated[dict[str, Any], _start, Field(title="initial state", description=(
    'angles and speeds at the start by the names of the bodies, `{ p1 = "0.3 rad" }`'
))]  # fmt: skip
Starts = Annotated[tuple[dict[str, Any], ...], _starts, Field(title="initial states")]
Path = Annotated[str, _path, Field(title="path of a parameter")]
Values = Annotated[tuple[Value, ...], _values, Field(title="values of the parameter")]
Pair = Annotated[tuple[Value, Value], _pair, Field(title="pair [low, high] of the parameter")]
Interval = Annotated[tuple[float, float], _pair, AfterValidator(_low_below_high)]  # of a quantity by ``si``
Whole = Annotated[int, _whole]
Order = Annotated[Literal[1, 2], _order, Field(description=(
    "order of the averaged equations, 1 or 2; they hold over times 1/epsilon, where rotors or bodies librate undamped over a "
    "few librations only"
))]  # fmt: skip
Inertia = Annotated[bool, _inertia, Field(description=(
    "whether the averaged equations keep the inertia of the balancing bodies, by default where one of them is not damped"
))]  # fmt: skip
BalancingBodies = Annotated[Literal["steady", "held"] | None, Field(description=(
    'where balancing bodies are: `"steady"`, in the steady phases that belong to each speed, a curve for each configuration, '
    'as `synchronous-states` has them; `"held"`, at the phases of `start`, at all speeds. By default steady where these phases '
    "are known, else held with a warning. Other rotors are at the phases of `start`"
))]  # fmt: skip
TrueOrFalse = Annotated[bool, _must(_is_bool, "must be true or false")]
Tolerance = Annotated[
    float, BeforeValidator(Unit("", "tolerance").parse), Field(ge=1e-16, le=1e-2, description="tolerance of the integration")
]
Engine = Annotated[
    Literal["heyoka", "scipy", "scipy-radau"], Field(description="engine of the integration, by default the best installed")
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
