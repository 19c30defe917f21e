"""Spec of the study ``capture-probability``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, RESONANCE_PASSED, Outcome
from wucht.errors import InputError, nearest
from wucht.schema import Composite, composite
from wucht.studies import spec as common
from wucht.studies.capture_probability.distributions import REPLICATES, check_form
from wucht.studies.next_question import NextQuestion
from wucht.studies.shared_keys import EnsembleStudy

_FEWEST, _MOST, _MOST_POINTS = 4 * REPLICATES, 2**20, 1000


def _random(raw: Any) -> Any:
    if not isinstance(raw, Mapping) or not raw:
        raise ValueError('must be a table of random quantities: random = { psi = { uniform = ["0 deg", "360 deg"] } }')
    return _distributions(raw)


def _distributions(table: Mapping[str, Any], path: str = "") -> dict[str, dict[str, Any]]:
    """The distribution of each path: TOML reads ``drive.slope = {...}`` as a table within a table."""
    distributions: dict[str, dict[str, Any]] = {}
    for name, definition in table.items():
        location = f"study.random.{path}{name}"
        if not isinstance(definition, Mapping):
            raise InputError(location, definition, "must be a table: { uniform = [low, high] }, { normal = [mean, deviation] }")
        inner = {k: v for k, v in definition.items() if isinstance(v, Mapping)}
        entries = {k: v for k, v in definition.items() if k not in inner}
        if entries or not inner:
            check_form(entries, location)
            distributions[f"{path}{name}"] = entries
        for longer, one in _distributions(inner, f"{path}{name}.").items():
            if longer in distributions:
                raise InputError(f"study.random.{longer}", one, "given twice")
            distributions[longer] = one
    return distributions


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
    dict[str, dict[str, Any]], BeforeValidator(_random), Field(description="random quantities with their distributions")
]
Outcomes = Annotated[tuple[str, ...], BeforeValidator(_outcomes), Field(description="counted outcomes")]
Between = Annotated[float, Field(gt=0, lt=1)]


class CaptureProbability(EnsembleStudy, common.Spec):
    """Probability that the machine passes its resonance, over a parameter, with random starts and parameters."""

    kind: ClassVar[str] = "capture-probability"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
    )
    from_start: ClassVar[bool] = True
    meaning: ClassVar[tuple[str, ...]] = (*EnsembleStudy.meaning, "at")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("parameter", "estimate"),)

    along: common.Path = Field(description="path of the parameter over which the probability is computed")
    range: Composite[common.Pair]
    random: Composite[Random] = composite(
        description="{name = {distribution}}, independent of each other: start states as in `start` (`psi`, `delta`, "
        "a body's name or `BODY.angle`, `BODY.speed`, `carrier.x`) or paths of parameters. Distributions: "
        "`uniform = [low, high]`, `normal = [mean, deviation]`, `log-normal = [median, factor]`, "
        "`triangular = [low, mode, high]`; `between = [low, high]` cuts a normal or log-normal one off"
    )
    points: common.Whole = Field(default=11, description="number of values of the parameter, evenly spaced, with a probability")
    samples: common.Whole = Field(default=256, description=(
        "number of runs at each value, a multiple of 16; best is a power of two, which Sobol' points need to fill evenly"
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
        if not _FEWEST <= self.samples <= _MOST or self.samples % REPLICATES:
            requirement = f"must be a multiple of {REPLICATES} from {_FEWEST} to {_MOST}, best a power of two"
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
            if not _FEWEST <= self.base <= _MOST or self.base & (self.base - 1):
                key = "samples" if self.sensitivity_samples is None else "sensitivity_samples"
                requirement = f"with a sensitivity this must be a power of two from {_FEWEST} to {_MOST}"
                raise InputError(f"study.{key}", self.base, requirement)
            return
        for key in ("at", "sensitivity_samples"):
            if getattr(self, key) is not None:
                raise InputError(f"study.{key}", getattr(self, key), "allowed only with sensitivity = true")
