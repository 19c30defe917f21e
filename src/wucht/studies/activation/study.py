"""Run-ups with switchable pendulums: which orientation and which activation speed give the smallest vibration."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from wucht.analysis.switching import (
    Switching,
    preload_for,
    switchable,
    switching,
    with_rigid_pendulums,
    without_pendulums,
)
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.scenarios.runs_in_turn import runs_in_turn
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.schema import SI, Composite, composite, si
from wucht.studies.activation.activation_runs import (
    BALANCED_VARIANT,
    NO_PENDULUMS,
    RIGID,
    SWITCHABLE,
    ActivationCase,
    activation_runs,
)
from wucht.studies.activation.answer import state_activation
from wucht.studies.activation.figure import figure
from wucht.studies.answer import Answer
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Start, Tolerance, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import FULL_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_RUNS = 5000
Variant = Literal["switchable", "balanced", "rigid", "none"]


def _nonempty_list(raw: Any) -> Any:
    if not isinstance(raw, list | tuple) or not raw:
        raise ValueError('must be a list of at least one of these, such as ["90 deg", "180 deg"] or ["150 rad/s"]')
    return raw


Several = Annotated[tuple[float, ...], BeforeValidator(_nonempty_list)]
_ORIENTATIONS = tuple(math.pi * k / 4 for k in range(1, 5))


# The runs; the switching of each pendulum, at each activation speed.
Prepared = tuple[tuple[ActivationCase, ...], tuple[tuple[Switching, ...], ...]]


class Activation(Study):
    """Run up with switchable pendulums: the peak amplitude over their relative orientation and over their activation speed."""

    kind = "activation"
    next_questions = (NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),)
    curves = (("curve_speed", "curve_amplitude"),)
    solves = FULL_EQUATIONS

    until: SI[float] = si("s", "time", gt=0, help="time of each run")
    orientations: SI[Several] = si("rad", "orientation", default=_ORIENTATIONS, help=(
        "angle from each switchable pendulum to the next at the start; at 0 only symmetry keeps equal ones together, and "
        "rounding errors decide the motion"
    ))  # fmt: skip
    phases: Whole = Field(default=4, ge=1, le=360, description=(
        "number of their mean phases to the rotor, evenly spaced over a turn, with which each orientation is run"
    ))  # fmt: skip
    activation_speeds: SI[Several] = si("rad/s", "activation speed", default=(), help=(
        'speeds at which the `"switchable"` pendulums open, set by their preload; by default as in the machine'
    ))  # fmt: skip
    variants: Composite[tuple[Variant, ...]] = composite(
        default=("switchable", "rigid", "none"),
        min_length=1,
        title="variants",
        description=(
            'variants to run up: the machine with its `"switchable"` pendulums; with these `"balanced"`, without their '
            'permanent unbalances; with the same `"rigid"`, their masses at the outer stops; with `"none"`, their masses on '
            "the rotor"
        ),
    )
    start: Composite[Start] = composite(default_factory=dict, description="rest of the initial state")
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """Check that speeds are above zero, that nothing is given twice, and that there are not too many runs."""
        if any(not w > 0 for w in self.activation_speeds):
            raise InputError("study.activation_speeds", list(self.activation_speeds), "must be speeds greater than 0")
        for key in ("orientations", "activation_speeds", "variants"):
            values = getattr(self, key)
            if len(set(values)) < len(values):
                raise InputError(f"study.{key}", list(values), "one of these is given twice; give each once")
        runs = len(self.orientations) * self.phases * max(len(self.activation_speeds), 1)
        if runs > MOST_RUNS:
            requirement = f"orientations times phases times activation speeds must be at most {MOST_RUNS} runs"
            raise InputError("study.phases", self.phases, requirement)

    @property
    def mean_phases(self) -> tuple[float, ...]:
        """The mean phases of the pendulums to the rotor, evenly spaced over a turn."""
        return tuple(2 * math.pi * k / self.phases for k in range(self.phases))

    def prepare(self, machine: Machine) -> Prepared:
        """Return the runs, and how the pendulums switch. Raises ``InputError`` where the question does not fit the machine."""
        pendulums = switchable(machine)
        names = tuple(p.name for p in pendulums)
        if not pendulums:
            requirement = "this study needs a body of kind 'switchable-pendulum'"
            raise InputError("machine.bodies", [b.kind for b in machine.bodies], requirement)
        for key in (*names, "psi", "delta"):
            if key in self.start:
                reason = "study.orientations and study.phases say where the switchable pendulums start"
                raise InputError(f"study.start.{key}", self.start[key], f"not allowed: {reason}")
        machines = [_machine_opening_at(machine, w) for w in self.activation_speeds] or [machine]
        balanced_machine = machine.with_values({f"{p.path}.permanent_unbalance": 0.0 for p in pendulums})
        variants = [(SWITCHABLE, m, i) for i, m in enumerate(machines)]
        variants += [(BALANCED_VARIANT, balanced_machine, -1), (RIGID, with_rigid_pendulums(machine), -1)]
        cases = [
            ActivationCase(of, variant, self._start(names, j, k), self._settings, i, j, k)
            for of, variant, i in variants
            for j, k in product(range(len(self.orientations)), range(self.phases))
            if of in self.variants
        ]
        if NO_PENDULUMS in self.variants:
            # With pendulums the study places them: the rotor starts from the same angle without.
            start = self.start or {"carrier": {}}
            cases.append(ActivationCase(NO_PENDULUMS, without_pendulums(machine), start, self._settings))
        for case in cases[:: self.phases]:  # impossible starts are refused before anything is computed
            case.run_up_case()
        return tuple(cases), tuple(tuple(switching(m, p) for p in pendulums) for m in machines)

    @property
    def _settings(self) -> RunSettings:
        return RunSettings(until=self.until, tolerance=self.tolerance, engine=self.engine)

    def _start(self, pendulums: Sequence[str], orientation: int, phase: int) -> dict[str, Any]:
        """Return the start of a run with these indices: pendulums are apart by the orientation, about the mean phase."""
        separation, middle = self.orientations[orientation], (len(pendulums) - 1) / 2
        angles = {name: self.mean_phases[phase] + (i - middle) * separation for i, name in enumerate(pendulums)}
        return dict(self.start) | angles

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Compute the runs, each of which is a unit of work."""
        cases, _ = prepared
        fill = partial(state_activation, machine, self.orientations, self.mean_phases, prepared)
        yield Answer(machine.units, partial(fill, ()))
        names = tuple(p.name for p in switchable(machine))
        for runs in runs_in_turn(cases, partial(activation_runs, names), work, "run"):
            yield Answer(machine.units, partial(fill, runs))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw two panels, or one for a single orientation and activation speed."""
        return figure(result)


def _machine_opening_at(machine: Machine, speed: float) -> Machine:
    return machine.with_values({f"{p.path}.preload": preload_for(machine, p, speed) for p in switchable(machine)})
