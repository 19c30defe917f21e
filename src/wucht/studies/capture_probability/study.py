"""How likely a machine with random starts and tolerances passes its resonance, over a parameter, and what matters for it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_variations import VariedQuantity, check_given_once, varied_quantity
from wucht.dynamics.sampling.arrangements import PREFIX, UNIFORM, arranged_quantities, arrangement_of
from wucht.dynamics.sampling.distributions import (
    REPLICATES,
    JointDistribution,
    check_form,
    cross_samples,
    distribution_in_words,
    distribution_of,
    indices,
    library,
    points,
    replicate_count,
    sample_values,
)
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.sampling.random_runs import ProbabilityPoint, RandomRuns
from wucht.dynamics.sampling.smallest_value import next_sample_value
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, RESONANCE_PASSED, Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.schema import Composite, composite
from wucht.studies import key_types as common
from wucht.studies.answer import Answer
from wucht.studies.capture_probability.answer import Cross, Prepared, state_probabilities, state_runs, state_target, warn
from wucht.studies.capture_probability.figure import figure
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import EnsembleStudy

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_FEWEST, _MOST, _MOST_POINTS = 8, 2**20, 1000  # of the samples: fewer tell next to nothing
_FEWEST_EVEN = 4 * REPLICATES  # fewer samples may be any number
_SEARCH = 0.4  # runs of the search, as a share of the preceding ones


def _random(raw: Any) -> Any:
    if not isinstance(raw, Mapping) or not raw:
        raise ValueError('must be a table of random quantities: random = { psi = { uniform = ["0 deg", "360 deg"] } }')
    return _distributions(raw)


Definition = dict[str, Any] | str  # a distribution, or UNIFORM of the bodies of a track


def _distributions(table: Mapping[str, Any], path: str = "") -> dict[str, Definition]:
    """The distribution of each path: TOML reads ``drive.slope = {...}`` as a table within a table."""
    distributions: dict[str, Definition] = {}
    for name, definition in table.items():
        location, is_track = f"study.random.{path}{name}", f"{path}{name}".startswith(PREFIX)
        if is_track and definition == UNIFORM:
            distributions[f"{path}{name}"] = UNIFORM
            continue
        if not isinstance(definition, Mapping):
            forms = "{ uniform = [low, high] }, { normal = [mean, deviation] }"
            track = f'; or "{UNIFORM}": any arrangement of the bodies of a track' if is_track else ""
            raise InputError(location, definition, f"must be a table: {forms}{track}")
        inner = {k: v for k, v in definition.items() if isinstance(v, Mapping) or f"{name}." == PREFIX}
        entries = {k: v for k, v in definition.items() if k not in inner}
        if entries or not inner:
            check_form(entries, location)
            distributions[f"{path}{name}"] = entries
        for longer, one in _distributions(inner, f"{path}{name}.").items():
            if longer in distributions:
                raise InputError(f"study.random.{longer}", one, "given twice")
            distributions[longer] = one
    return distributions


def _definition_text(definition: Definition) -> str:
    return (
        f"{UNIFORM}: bodies without overlap, in any order" if isinstance(definition, str) else distribution_in_words(definition)
    )


def _outcomes(raw: Any) -> Any:
    names = [raw] if isinstance(raw, str) else raw
    known_outcomes = [str(o) for o in Outcome if o not in OPEN_OUTCOMES]
    if not isinstance(names, list | tuple) or not names:
        raise ValueError(f"must be an outcome or a list of them; known: {', '.join(known_outcomes)}")
    for name in names:
        if name in map(str, OPEN_OUTCOMES):
            raise ValueError(f"{name!r} cannot be counted: such a run may have any outcome, and widens the band")
        if name not in known_outcomes:
            raise ValueError(f"{name!r} is not an outcome; {nearest(str(name), known_outcomes)}")
    return tuple(dict.fromkeys(map(str, names)))


Random = Annotated[
    dict[str, Definition], BeforeValidator(_random), Field(description="random quantities with their distributions")
]
Outcomes = Annotated[tuple[str, ...], BeforeValidator(_outcomes), Field(description="counted outcomes")]
Between = Annotated[float, Field(gt=0, lt=1)]


class CaptureProbability(EnsembleStudy):
    """Probability that the machine passes its resonance, over a parameter, with random starts and parameters."""

    kind = "capture-probability"
    next_questions = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
    )
    from_start = True
    meaning = (*EnsembleStudy.meaning, "at")
    curves = (("parameter", "estimate"),)

    along: common.Path = Field(description="path of the parameter over which the probability is computed")
    range: Composite[common.Pair]
    random: Composite[Random] = composite(
        description="{name = {distribution}}, independent of each other: start states as in `start` (`psi`, `delta`, "
        "a body's name or `BODY.angle`, `BODY.speed`, `carrier.x`) or paths of parameters. Distributions: "
        "`uniform = [low, high]`, `normal = [mean, deviation]`, `log-normal = [median, factor]`, "
        "`triangular = [low, mode, high]`; `between = [low, high]` cuts a normal or log-normal one off. "
        '`tracks.NAME = "uniform"`: all arrangements of the bodies of a track in which none overlap'
    )
    points: common.Whole = Field(default=11, description="number of values of the parameter, evenly spaced, with a probability")
    samples: common.Whole = Field(default=256, description=(
        "number of runs at each value: 8 to 64, or a multiple of 16; best is a power of two from 64 on, which Sobol' points "
        "need to fill evenly"
    ))  # fmt: skip
    outcome: Composite[Outcomes] = composite(default=tuple(map(str, RESONANCE_PASSED)), description=(
        "counted outcomes, by default that the machine passes its resonance: `compensated` or `passed`"
    ))  # fmt: skip
    probability: Between | None = Field(default=None, title="target probability", description=(
        "target probability; the study looks for the smallest value of `along` from which it is reached with confidence"
    ))  # fmt: skip
    confidence: Between = Field(default=0.95, description="confidence of the bands")
    seed: common.Whole = Field(default=0, description="seed of the random numbers, which are the same at all values")
    sensitivity: common.TrueOrFalse = Field(
        default=False,
        description="whether the influence of each random quantity is computed (Sobol' indices), `at` a value of `along`",
    )
    at: common.Value | None = Field(default=None, title="value of the parameter for the sensitivity", description=(
        "value of the parameter `along` for the sensitivity"
    ))  # fmt: skip
    sensitivity_samples: common.Whole | None = Field(
        default=None, description="number of runs for the index of each random quantity; twice as many are added"
    )

    @property
    def base(self) -> int:
        """Number of runs for each index of the sensitivity."""
        return self.samples if self.sensitivity_samples is None else self.sensitivity_samples

    def check(self) -> None:
        """Check the numbers of runs, and that keys of the sensitivity and of averaged equations are given only with them."""
        super().check()
        if not 2 <= self.points <= _MOST_POINTS:
            raise InputError("study.points", self.points, f"must be a whole number from 2 to {_MOST_POINTS}")
        if not _FEWEST <= self.samples <= _MOST or (self.samples > _FEWEST_EVEN and self.samples % REPLICATES):
            even = f"a multiple of {REPLICATES} up to {_MOST}, best a power of two"
            requirement = f"must be a whole number from {_FEWEST} to {_FEWEST_EVEN}, or {even}"
            raise InputError("study.samples", self.samples, requirement)
        if self.seed < 0:
            raise InputError("study.seed", self.seed, "must be a whole number, not below 0")
        if self.along in self.random:
            raise InputError(f"study.random.{self.along}", self.along, "already varied by study.along; give it once")
        self._check_sensitivity()

    def _check_sensitivity(self) -> None:
        if self.sensitivity:
            if self.at is None:
                raise InputError(
                    "study.at",
                    None,
                    f"this key is missing; it must be the value of {self.along} for the sensitivity",
                    code="missing",
                )
            if len(self.random) < 2:
                raise InputError(
                    "study.sensitivity", True, "at least two random quantities are needed to compare them", code="too-few"
                )
            if not _FEWEST_EVEN <= self.base <= _MOST or self.base & (self.base - 1):
                key = "samples" if self.sensitivity_samples is None else "sensitivity_samples"
                requirement = f"with a sensitivity this must be a power of two from {_FEWEST_EVEN} to {_MOST}"
                raise InputError(f"study.{key}", self.base, requirement)
            return
        for key in ("at", "sensitivity_samples"):
            if getattr(self, key) is not None:
                raise InputError(f"study.{key}", getattr(self, key), "allowed only with sensitivity = true")

    def prepare(self, machine: Machine) -> Prepared:
        """Return the runs, the values of the parameter, and the samples. Raises ``InputError``."""
        along = parameter_of(machine, self.along)
        low, high = checked_range(machine, along, self.range)
        joint = [self._drawn_together(machine, name) for name in self.random]
        quantities = tuple(v for together, _ in joint for v in together)
        distributions = [distribution for _, distribution in joint]
        initial_state(machine, self.start)
        check_given_once(quantities, self.start, "random", "another random quantity")
        samples = sample_values(distributions, points(self.samples, len(quantities), self.seed).reshape(-1, len(quantities)))
        sensitivity = None
        if self.sensitivity and self.at is not None:
            library()
            (at,) = values_of(machine, along, (self.at,), "at")
            dimensions = [distribution.dimensions for distribution in distributions]
            sensitivity = at, sample_values(distributions, cross_samples(self.base, len(joint), self.seed, dimensions))
        parameters = {k: v.name for k, v in enumerate(quantities) if v.state is None}
        for one in (samples, *(() if sensitivity is None else sensitivity[1:])):
            for k, name in parameters.items():
                self._refuse_forbidden_values(machine, name, one[k])
        question = EnsembleQuestion(
            machine, tuple(parameters.values()), self.model, self.inertia, self.order, self.until, tolerance=self.tolerance
        )
        runs = RandomRuns(question, along, quantities, self.start, self.outcome, self.confidence)
        grid = np.linspace(low, high, self.points).tolist()
        warnings = runs.omissions((grid[0], grid[-1]), samples)
        if replicate_count(self.samples) < self.samples and self.samples & (self.samples - 1):
            even = 2 ** int(np.log2(self.samples))
            number = f"samples = {self.samples} is not a power of two"
            warnings = (*warnings, f"{number}: Sobol' points fill the space evenly with {even} or {2 * even}")
        return runs, grid, samples, sensitivity, warnings

    def _drawn_together(self, machine: Machine, name: str) -> tuple[tuple[VariedQuantity, ...], JointDistribution]:
        """Return the quantities of a random one, and how they are distributed. Raises ``InputError``."""
        definition, location = self.random[name], f"study.random.{name}"
        if isinstance(definition, str):
            return arranged_quantities(machine, name), arrangement_of(machine, name, location)
        v = varied_quantity(machine, name, f"random.{name}")
        return (v,), distribution_of(definition, v.quantity, location)

    def _refuse_forbidden_values(self, machine: Machine, name: str, values: np.ndarray) -> None:
        for value in (float(values.min()), float(values.max())):
            try:
                machine.with_values({name: value})
            except InputError as error:
                problem = f"this distribution reaches {value:.6g}, which the machine does not allow ({error.explanation})"
                requirement = f"{problem}; limit it, as by between = [low, high]"
                raise InputError(f"study.random.{name}", self.random[name], requirement) from None

    def solve(self, machine: Machine, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Compute the probability at each value, then at those of the search, and the sensitivity."""
        runs, grid, samples, sensitivity, _ = prepared
        first, search, last = self._shares_of_work(len(grid), 0 if sensitivity is None else sensitivity[1].shape[1])
        done = list[ProbabilityPoint]()
        part = work.part("values", 0.0, first)
        for so_far in runs.points(grid, samples, part):
            done = list(so_far)
            yield Answer(machine.units, partial(self._state, prepared=prepared, done=tuple(done)))
        begin, number = first, 0
        while self.probability is not None and (at := next_sample_value(done, self.probability)) is not None:
            end = (begin + search) / 2  # the number of steps is not known in advance
            point = runs.point(at, samples, work.part(f"search/{number}", begin, end).open_ended)
            done, begin, number = sorted([*done, point], key=lambda p: p.value), end, number + 1
            yield Answer(machine.units, partial(self._state, prepared=prepared, done=tuple(done)))
        cross = None
        if sensitivity is not None and not all(p.is_undecided for p in done):
            members = runs.outcomes(*sensitivity, work.part("sensitivity", search, last))
            inside, open_ = members.has_outcome(self.outcome), members.has_outcome(OPEN_OUTCOMES)
            cross = members, indices(inside, open_, len(self.random), self.confidence, self.seed)
        work.report(1.0)
        yield Answer(machine.units, partial(self._state, prepared=prepared, done=tuple(done), cross=cross))

    def _shares_of_work(self, values: int, cross_runs: int) -> list[float]:
        """Completed share of the work after the values, the search and the sensitivity."""
        runs = values * self.samples
        sizes = np.cumsum([runs, 0.0 if self.probability is None else _SEARCH * runs, cross_runs])
        shares: list[float] = (sizes / sizes[-1]).tolist()
        return shares

    def _state(self, a: Answer, prepared: Prepared, done: tuple[ProbabilityPoint, ...], cross: Cross = None) -> None:
        runs, grid, *_ = prepared
        a.number("along", runs.along.path, "parameter")
        a.number("unit", runs.along.unit, "its unit")
        a.number("range", [grid[0], grid[-1]], "its least and greatest value", runs.along.unit)
        a.number("outcome", list(self.outcome), "counted outcomes")
        a.number("confidence", self.confidence, "confidence of the bounds")
        state_probabilities(a, prepared, done)
        distributions = {name: _definition_text(definition) for name, definition in self.random.items()}
        for k, (name, words) in enumerate(a.number("random", distributions, "random quantities").items()):
            a.line("" if k else "random", "{name} {words}", name=name, words=words)
        state_target(a, prepared, done, self.probability)
        state_runs(a, prepared, done, cross, tuple(self.random))
        warn(a, prepared, done, cross)

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the probability with its band, and the indices, if computed."""
        return figure(result)
