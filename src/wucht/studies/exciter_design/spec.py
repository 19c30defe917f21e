"""Spec of the study ``exciter-design``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, TableModel, composite, is_pairs, si, validate_table
from wucht.studies import spec as common
from wucht.studies.shared_keys import Vary
from wucht.studies.spec import Value

Shape = Literal["constant", "normal", "straight-line"]
_FORMS = ("shape", "exponent", "table", "file")
_TARGET_FORMS = (
    "must be a table of pairs [[AMPLITUDE, CYCLES], ...], { file = FILE }, or { shape = 'normal', largest = AMPLITUDE, "
    "cycles = NUMBER }"
)
_LIMITS = {
    "evaluations": (4, 100_000), "population": (4, 1000), "reach": (4, 100_000), "candidates": (1, 20), "corrections": (0, 10),
    "polish": (0, 10_000), "samples": (0, 10_000), "seed": (0, 2**31),
}  # fmt: skip


class Target(TableModel):
    """Target spectrum: amplitude over cumulative cycles."""

    shape: Shape | None = Field(default=None, title="shape of the spectrum", description="shape of the spectrum, or `exponent`")
    exponent: SI[float | None] = si(
        "", "exponent of the shape", default=None, gt=0, help="exponent of another shape, H = H_0^(1 - (S/S_max)^exponent)"
    )
    largest: Value | None = Field(default=None, title="largest amplitude", description="largest amplitude S_max")
    cycles: SI[float | None] = si("cycles", "number of cycles", default=None, gt=1, help="number of cycles H_0, in all")
    ratio: SI[float | None] = si("", "ratio of the lowest amplitude to the largest", default=None, ge=0, lt=1)
    table: Composite[tuple[tuple[Value, Value], ...] | None] = composite(
        default=None,
        title="amplitudes and cumulative cycles",
        description="pairs of an amplitude and the number of cycles with at least this amplitude",
    )
    file: str | None = Field(default=None, min_length=1, title="file of amplitudes and cumulative cycles", description=(
        "file with these two columns, amplitudes and cumulative cycles"
    ))  # fmt: skip
    stepped: common.TrueOrFalse | None = Field(
        default=None, description="true if no cycle lies between two amplitudes of a table"
    )

    def check(self) -> None:
        """Check that one form is given, with the keys that it needs."""
        forms = [key for key in _FORMS if getattr(self, key) is not None]
        if len(forms) != 1:
            raise InputError("study.target", ", ".join(forms) or None, f"must be one of {', '.join(_FORMS)}")
        standard = forms[0] in ("shape", "exponent")
        for key in ("largest", "cycles"):
            if standard and getattr(self, key) is None:
                raise InputError(
                    f"study.target.{key}", None, f"this key is missing: a target with {forms[0]} needs it", code="missing"
                )
        for key in ("stepped",) if standard else ("largest", "cycles", "ratio"):
            if getattr(self, key) is not None:
                alternative = "a table or file" if standard else "a shape or exponent"
                raise InputError(f"study.target.{key}", getattr(self, key), f"allowed only with {alternative}")


def _target(raw: Any) -> Any:
    if is_pairs(raw):
        raw = {"table": raw}
    if not isinstance(raw, Mapping | Target):
        raise ValueError(_TARGET_FORMS)
    if isinstance(raw, Target):
        raw.check()
        return raw
    pairs = raw.get("table")
    if pairs is not None and not is_pairs(pairs):
        raise InputError("study.target.table", pairs, "must be a list of pairs [AMPLITUDE, CYCLES]")
    target = validate_table(Target, raw, "study.target")
    target.check()
    return target


class ExciterDesign(common.Spec):
    """Motor, unbalances, damping and stiffness of an exciter whose beating at its resonance gives a target load spectrum.

    002, section 6.2: "the choice of the exciter's parameters is a further, non-trivial task".
    """

    kind: ClassVar[str] = "exciter-design"
    solves: ClassVar[str] = f"{common.AVERAGED_EQUATIONS} for the search, {common.FULL_EQUATIONS} for the best"
    from_start: ClassVar[bool] = True
    subject: ClassVar[str] = "wucht.studies.exciter_design.computation:MACHINE_IN_FOLDER"
    meaning: ClassVar[tuple[str, ...]] = (*common.Spec.meaning, "target", "vary", "signal")
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("share", "amplitude_full"),)

    target: Composite[Annotated[Target, BeforeValidator(_target)]] = composite(
        title="target spectrum", description="target spectrum, a table `[study.target]`"
    )
    vary: Composite[Vary] = composite(
        description="{PATH = [low, high]} as in `optimise-balancer`; a wide range (tenfold) is searched by its logarithm"
    )
    signal: Literal["displacement", "bearing-force", "acceleration"] = Field(
        default="displacement", description="counted signal, as in `load-spectrum`"
    )
    direction: Literal["x", "y", "r"] | None = Field(default=None, description="direction of the signal, as in `load-spectrum`")
    metric: Literal["amplitude", "cumulative", "damage"] = Field(default="amplitude", description=(
        'distance between spectra: `"amplitude"`, the mean difference of the amplitudes at equal shares of the cycles; '
        '`"cumulative"`, the largest difference of those shares at equal amplitudes (that of `load-spectrum`); `"damage"`, the '
        "same for the damage done by larger amplitudes, with N proportional to S^-slope"
    ))  # fmt: skip
    start: Composite[common.Start] = composite(
        default_factory=dict, description="initial state of the exciter, by default at rest"
    )
    reach: common.Whole = Field(default=128, description=(
        "random points of the ranges at which the modulated motion is computed; the best form the first generation"
    ))  # fmt: skip
    evaluations: common.Whole = Field(default=320, description="candidates of the search that follows")
    population: common.Whole = Field(default=16, description="candidates of a generation")
    polish: common.Whole = Field(default=200, description="evaluations of a local search from the best candidate")
    candidates: common.Whole = Field(
        default=3, description="number of candidates computed with the full equations, over `beats` beats"
    )
    beats: common.Whole = Field(default=40, description="number of beats counted with the full equations")
    corrections: common.Whole = Field(
        default=6,
        description="number of corrections of the design by the deviation of the full from the averaged equations, "
        "at most: the last one is that which brings it no nearer to the target",
    )
    spread: SI[float] = si("", "spread of the parameters", default=0.02, ge=0, lt=1, help=(
        "spread of all variables, half the width relative to the value, for `samples` exciters within tolerances"
    ))  # fmt: skip
    samples: common.Whole = Field(default=64, description="number of exciters within tolerances, see `spread`")
    slope: SI[float] = si("", "slope of the Woehler line", default=5.0, gt=0, help='slope of the line of the metric `"damage"`')
    seed: common.Whole = Field(default=1, description="seed of the random points and of the search")
    inertia: common.Inertia = Field(default=True, description="true if the averaged equations keep the bodies' inertia")
    tolerance: common.Tolerance = common.DEFAULT_TOLERANCE

    def check(self) -> None:
        """Check the sizes of the search."""
        for key, (low, high) in (_LIMITS | {"beats": (2, 10_000)}).items():
            if not low <= getattr(self, key) <= high:
                raise InputError(f"study.{key}", getattr(self, key), f"must be a whole number from {low} to {high}")
        for key in ("evaluations", "reach"):
            if getattr(self, key) < self.population:
                raise InputError(f"study.{key}", getattr(self, key), f"must be at least {self.population}: one population")

    def table_for(self, subject: Any) -> dict[str, Any]:
        """Return the question, see ``Spec``: a changed file of the target is another one."""
        question, contents = self.to_table(), getattr(subject, "contents", None)
        if self.target.file is not None and contents is not None:
            question["target"]["contents"] = contents(self.target.file)
        return question
