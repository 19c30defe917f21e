"""The question of a run-up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from wucht.checking import refuse_unknown
from wucht.errors import InputError
from wucht.fields import si
from wucht.studies import spec as common

MOST_RUNS = 500
_ENDS = ("until", "turns", "settled")


class SingleRun(common.Spec):
    """The keys of a question that starts the machine once: how far it runs, from where, and with which equations."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (_ENDS,)
    horizon: ClassVar[tuple[str, ...]] = _ENDS
    from_start: ClassVar[bool] = True

    until: float | None = si("s", "time", default=None, gt=0)
    turns: float | None = si("", "number of turns", default=None, gt=0)
    settled: common.TrueOrFalse | None = Field(None, description="run until the machine has settled")
    start: common.Start = Field(default_factory=dict)
    model: Literal["full", "slow", "both"] = Field("full", description="equations")
    inertia: common.Inertia | None = None
    order: common.Order = 1
    tolerance: common.Tolerance = common.DEFAULT_TOLERANCE
    speed_limit: float | None = si("rad/s", "speed", default=None, gt=0)
    engine: common.Engine | None = None

    @model_validator(mode="before")
    @classmethod
    def _until_settled(cls, given: Any) -> Any:
        """``until = "settled"`` and ``until = { turns = 300 }``."""
        if not isinstance(given, Mapping):
            return given
        until = given.get("until")
        until = {"settled": True} if until == "settled" else until
        if not isinstance(until, Mapping):
            return given
        refuse_unknown(until, ("turns", "settled"), "study.until")
        if not until:
            raise InputError("study.until", {}, "must be a time, { turns = NUMBER } or { settled = true }")
        return {k: v for k, v in given.items() if k != "until"} | dict(until)

    def check(self) -> None:
        """One end, and the keys of averaged equations only with them."""
        if sum(x is not None for x in (self.until, self.turns, self.settled or None)) > 1:
            raise InputError("study.until", None, "must be one of until, turns and settled")
        if self.settled is False and self.until is None and self.turns is None:
            raise InputError("study.settled", False, "needed is until = a time or turns = a number, if not settled = true")
        if self.model == "full":
            for key in ("inertia", "order"):
                if key in self.model_fields_set and getattr(self, key) is not None:
                    raise InputError(f"study.{key}", getattr(self, key), "allowed only with model = 'slow' or 'both'")


class RunUp(SingleRun):
    """Start the machine and see what becomes of it.

    It runs ``until`` a time, for ``turns`` of the main rotor, or, without either, until it has ``settled``. start: angles and
    speeds at the start by the names of the bodies, ``{ p1 = "0.3 rad" }``. starts: several initial states, or ``values`` of the
    parameter ``along``: a run each, in one result. over: the abscissa of the figure, ``"time"``, ``"phi"`` (the rotor's angle)
    or ``"psi"`` (mean phase of its bodies). model: the ``"full"`` equations, the averaged ones (``"slow"``), or ``"both"``;
    inertia: whether the averaged ones keep that of the balancing bodies, by default where one of them is not damped. order:
    that of the averaged equations, 1 or 2; they hold over times 1/epsilon, where rotors or bodies librate undamped over a few
    librations only. tolerance: of the integration. speed_limit: beyond it the run ends as ``runaway``. engine: ``"heyoka"``,
    ``"scipy"``, ``"scipy-radau"``, by default the best installed. stored_samples: at most, of all runs together; by default a
    million, or as many as take 240 MB. deck: the inclination of a screen's deck, counter-clockwise
    from +x, for its throw number.
    """

    kind: ClassVar[str] = "run-up"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("time", "speed"), ("time", "amplitude"))
    headline: ClassVar[tuple[str, ...]] = (
        "final_speed",
        "final_amplitude",
        "peak_amplitude",
        "final_residual_unbalance",
        "settling_time",
        "machine_number",
    )
    without_inertia: ClassVar[bool] = True

    starts: common.Starts = ()
    along: common.Path | None = None
    values: common.Values = ()
    stored_samples: int | None = Field(None, gt=1, description="samples that are stored at most, of all runs together")
    over: Literal["time", "phi", "psi"] = Field("time", description="abscissa of the figure")
    deck: float | None = si("rad", "inclination of the deck", default=None, gt=-1.5, lt=1.5)

    def check(self) -> None:
        """Of many runs one of start and starts, and along with values."""
        if self.starts and self.start:
            raise InputError("study.starts", None, "give either start or starts")
        if bool(self.values) != (self.along is not None):
            missing = "values" if self.along is not None else "along"
            raise InputError(f"study.{missing}", None, "this key is missing; along = PATH and values = [...] belong together")
        if len(self.starts or [0]) * len(self.values or [0]) > MOST_RUNS:
            raise InputError("study.values", len(self.values), f"there must be at most {MOST_RUNS} runs, starts times values")
        super().check()
