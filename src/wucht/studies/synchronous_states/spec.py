"""The question of ``synchronous-states``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, Unit, composite, read_quantity, refuse_unknown, si
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import AVERAGED_EQUATIONS, FULL_EQUATIONS, Inertia, Interval, Spec, TrueOrFalse, Value

MOST_CELLS = 400
_MOST_RATIO = 1e6
_AXES = {"speed": Unit("rad/s", "speed"), "ratio": Unit("", "ratio")}


def _parse_axes(value: Any) -> Any:
    if not isinstance(value, Mapping):
        raise ValueError("must be a table: axes = { speed = [lo, hi, cells], ratio = [lo, hi, cells] }")
    refuse_unknown(value, _AXES, "study.axes")
    for name in _AXES:
        key, axis = f"study.axes.{name}", value.get(name)
        if not isinstance(axis, list | tuple) or len(axis) != 3:
            raise InputError(key, axis, "must be [lo, hi, cells]", code="shape")
        if isinstance(axis[2], bool) or not isinstance(axis[2], int) or not 2 <= axis[2] <= MOST_CELLS:
            raise InputError(key, axis, f"must be a whole number of cells from 2 to {MOST_CELLS}", code="whole-number")
    return {name: tuple(value[name]) for name in _AXES}


Axes = Annotated[dict[str, tuple[Value, Value, int]], BeforeValidator(_parse_axes)]


class SynchronousStates(Spec):
    """All steady phase configurations of the balancing bodies or of self-synchronising rotors, with names and stability.

    000 sections 4-6 (tables 1-3), 001 section 2.4 (table 1), 002 section 5.1 (types I, II, III).
    """

    kind: ClassVar[str] = "synchronous-states"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )

    speed: SI[float | None] = si("rad/s", "speed", default=None, help=(
        "speed of the main rotor, signed; by default the one prescribed by its drive, else all at which the drive and the "
        "vibration balance, searched over `range`"
    ))  # fmt: skip
    range: SI[Interval | None] = si("rad/s", "speed", default=None, help=(
        "lowest and highest speed of the search, by default up to the highest speed without vibration, or three times the "
        "highest natural frequency where a drive runs away without load: then the states are not stated to be all"
    ))  # fmt: skip
    inertia: Inertia = Field(default=True, description=(
        "whether the averaged equations keep the inertia of the balancing bodies; false: strongly damped, 002 (4.60)-(4.62)"
    ))  # fmt: skip
    full: TrueOrFalse = Field(default=True, description="whether the multipliers of the full equations are computed too")
    axes: Composite[Axes | None] = composite(default=None, title="axes of a stability map", description=(
        "a stability map over given speeds, {speed = [lo, hi, cells], ratio = [lo, hi, cells]}, cell-centred; ratio: of the "
        "unbalance of all balancing bodies together to that of the rotor, which is changed for it"
    ))  # fmt: skip

    def check(self) -> None:
        """Check that a speed excludes a range of speeds, and that axes begin at 0 or above."""
        if self.speed == 0:
            raise InputError("study.speed", 0.0, "must be a speed other than 0")
        if self.speed is not None and self.range is not None:
            raise InputError("study.range", list(self.range), "not allowed where the speed of the main rotor is given")
        for name, (low, high, _) in self.axes_in(_AXES["speed"].si).items():
            key, axis = f"study.axes.{name}", list((self.axes or {})[name])
            if not low < high:
                raise InputError(key, axis, "must be a pair [low, high] with low below high", code="not-increasing")
            if low < 0:
                raise InputError(key, axis, f"must be a {name} of at least 0", code="negative")
            if name == "ratio" and high > _MOST_RATIO:
                raise InputError(key, axis, f"must be a ratio up to {_MOST_RATIO:g}", code="limits")

    def axes_in(self, speed_unit: str) -> dict[str, tuple[float, float, int]]:
        """Return the axes of the map: lowest, highest, cells; none without a map.

        speed_unit: of the machine, empty if it is dimensionless. Raises ``InputError`` where an axis has another one.
        """
        axes = {}
        for name, (low, high, cells) in (self.axes or {}).items():
            unit, key = Unit(speed_unit if name == "speed" else "", _AXES[name].long_name), f"study.axes.{name}"
            axes[name] = (read_quantity(unit, low, f"{key}[0]"), read_quantity(unit, high, f"{key}[1]"), cells)
        return axes

    def equations(self) -> str:
        """See ``Spec``."""
        return f"{AVERAGED_EQUATIONS} for the states, {FULL_EQUATIONS} for their stability" if self.full else AVERAGED_EQUATIONS

    def turning(self) -> str:
        """See ``Spec``."""
        return "" if self.speed is None else "the main rotor held at study.speed"
