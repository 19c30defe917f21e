"""Design of an exciter: motor, unbalance, damping and stiffness, searched for a target load spectrum."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from wucht.dynamics.exciters.design_search import (
    best_apart,
    candidate_batches,
    corrected_runs,
    full_run,
    local_optimum,
    nearest_that_beats,
    search_generations,
    sobol_points,
)
from wucht.dynamics.exciters.design_trials import (
    METRICS,
    Candidates,
    CheckedCandidate,
    DesignTrials,
    spectrum_distances,
)
from wucht.dynamics.exciters.neighbour_check import compare_designs, end_of_beating
from wucht.dynamics.exciters.target_spectrum import Target, read_target, target_spectrum
from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.dynamics.sampling.searches import balancer_names, require_pymoo, variables_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import shift_spectrum
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.schema import SI, Composite, composite, si
from wucht.studies.answer import Answer
from wucht.studies.exciter_design.answer import state_design
from wucht.studies.exciter_design.figure import figure
from wucht.studies.exciter_design.machine_in_folder import MachineInFolder
from wucht.studies.key_types import DEFAULT_TOLERANCE, Inertia, Start, Tolerance, Whole
from wucht.studies.shared_keys import Vary
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_LIMITS = {
    "evaluations": (4, 100_000), "population": (4, 1000), "reach": (4, 100_000), "candidates": (1, 20), "corrections": (0, 10),
    "polish": (0, 10_000), "samples": (0, 10_000), "seed": (0, 2**31),
}  # fmt: skip
_REACH, _SEARCH, _POLISH, _FULL, _CORRECTION, _CHECK = 0.15, 0.4, 0.5, 0.55, 0.75, 0.95  # shares of the work after each
_STEP = 0.02  # relative: of the neighbours, where no spread is given

# The trials, nominal values of the variables (k,), the target's cycles, the counted signal, and doubts about the equations.
Prepared = tuple[DesignTrials, np.ndarray, LoadCycles, MachineSignal, tuple[str, ...]]


class ExciterDesign(Study):
    """Motor, unbalances, damping and stiffness of an exciter whose beating at its resonance gives a target load spectrum.

    002, section 6.2: "the choice of the exciter's parameters is a further, non-trivial task".
    """

    kind = "exciter-design"
    solves = f"{AVERAGED_EQUATIONS} for the search, {FULL_EQUATIONS} for the best"
    from_start = True
    trials = ("runs", "polished")
    subject = "wucht.studies.exciter_design.machine_in_folder:MACHINE_IN_FOLDER"
    meaning = (*Study.meaning, "target", "vary", "signal")
    curves = (("share", "amplitude_full"),)

    target: Composite[Annotated[Target, BeforeValidator(read_target)]] = composite(
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
    start: Composite[Start] = composite(default_factory=dict, description="initial state of the exciter, by default at rest")
    reach: Whole = Field(default=128, description=(
        "random points of the ranges at which the modulated motion is computed; the best form the first generation"
    ))  # fmt: skip
    evaluations: Whole = Field(default=320, description="candidates of the search that follows")
    population: Whole = Field(default=16, description="candidates of a generation")
    polish: Whole = Field(default=200, description="evaluations of a local search from the best candidate")
    candidates: Whole = Field(
        default=3, description="number of candidates computed with the full equations, over `beats` beats"
    )
    beats: Whole = Field(default=40, description="number of beats counted with the full equations")
    corrections: Whole = Field(
        default=6,
        description="number of corrections of the design by the deviation of the full from the averaged equations, "
        "at most: the last one is that which brings it no nearer to the target",
    )
    spread: SI[float] = si("", "spread of the parameters", default=0.02, ge=0, lt=1, help=(
        "spread of all variables, half the width relative to the value, for `samples` exciters within tolerances"
    ))  # fmt: skip
    samples: Whole = Field(default=64, description="number of exciters within tolerances, see `spread`")
    slope: SI[float] = si("", "slope of the Woehler line", default=5.0, gt=0, help='slope of the line of the metric `"damage"`')
    seed: Whole = Field(default=1, description="seed of the random points and of the search")
    inertia: Inertia = Field(default=True, description="true if the averaged equations keep the bodies' inertia")
    tolerance: Tolerance = DEFAULT_TOLERANCE

    def check(self) -> None:
        """Check the sizes of the search."""
        for key, (low, high) in (_LIMITS | {"beats": (2, 10_000)}).items():
            if not low <= getattr(self, key) <= high:
                raise InputError(f"study.{key}", getattr(self, key), f"must be a whole number from {low} to {high}")
        for key in ("evaluations", "reach"):
            if getattr(self, key) < self.population:
                raise InputError(f"study.{key}", getattr(self, key), f"must be at least {self.population}: one population")

    def table_for(self, subject: Any) -> dict[str, Any]:
        """Return the question, see ``Study``: a changed file of the target is another one."""
        question, contents = self.to_table(), getattr(subject, "contents", None)
        if self.target.file is not None and contents is not None:
            question["target"]["contents"] = contents(self.target.file)
        return question

    def prepare(self, subject: MachineInFolder | Machine) -> Prepared:
        """Return the trials of candidates and the target. Raises ``InputError`` where the study does not fit the machine."""
        machine, folder = (subject.machine, subject.folder) if isinstance(subject, MachineInFolder) else (subject, None)
        require_pymoo(self.kind)
        if not any(isinstance(p, Body) for p in machine.parts):
            reason = "not allowed: bodies, [[machine.bodies]], are needed, whose numbers are varied"
            raise InputError("machine.model", None, reason)
        if not balancer_names(machine):
            requirement = f"there must be a pendulum about {machine.rotor.name!r}: without it nothing beats"
            raise InputError("machine.bodies", None, requirement)
        if machine.schedules:
            raise InputError("machine.schedules", None, "allowed only for a machine without schedules: the beating must last")
        signal = machine_signal(machine, self.signal, self.direction)
        target = target_spectrum(self.target, signal.unit, folder)
        variables = variables_of(machine, self.vary, False)
        trials = DesignTrials(
            machine, variables, self.signal, self.direction, self.start, self.inertia, self.tolerance,
            METRICS.index(self.metric), self.slope,
        )  # fmt: skip
        nominal = np.array([machine.values[v.paths[0]] for v in variables])
        _check_ends(trials, nominal)
        placed_machine, start = prepare_start(machine, self.start, 0.0)
        return trials, nominal, target, signal, tuple(slow_model(placed_machine, start, self.inertia, 1).warnings)

    def solve(self, subject: Any, prepared: Prepared, work: Work) -> Iterator[Answer]:
        """Search with the averaged equations, correct by the full ones, and compare the design with its neighbours."""
        trials, nominal, target, signal, doubts = prepared
        metric, step, units = trials.metric, self.spread or _STEP, trials.machine.units
        state = partial(
            state_design, trials=trials, nominal=nominal, target=target, signal=signal, doubts=doubts, step=step,
            spread=self.spread,
        )  # fmt: skip
        reach = list[Candidates]()
        points = trials.values(sobol_points(trials, self.reach, [self.seed, 0]))
        for batch in candidate_batches(trials, points, target, self.population, "reach", work.part("reach", 0.0, _REACH)):
            reach.append(batch)
            yield Answer(units, partial(state, reach=tuple(reach)))
        state, search = partial(state, reach=tuple(reach)), list[Candidates]()
        part, count = work.part("search", _REACH, _SEARCH), self.evaluations // self.population
        for generation in search_generations(trials, nominal, target, reach, self.population, count, self.seed, part):
            search.append(generation)
            yield Answer(units, partial(state, search=tuple(search)))
        state, optima = partial(state, search=tuple(search)), list[tuple[np.ndarray, float]]()
        best, part = best_apart(trials, [*reach, *search], self.candidates), work.part("polish", _SEARCH, _POLISH)
        for k, numbers in enumerate(best):
            here = part.part("", k / len(best), (k + 1) / len(best))
            optima.append(local_optimum(trials, numbers, target, self.polish, f"{k}", here))
            yield Answer(units, partial(state, optima=tuple(optima)))
        state, runs, part = partial(state, optima=tuple(optima)), list[CheckedCandidate](), work.part("full", _POLISH, _FULL)
        for k, (numbers, _) in enumerate(optima):
            here = part.part("", k / len(best), (k + 1) / len(best))
            runs.append(full_run(trials, numbers, target, self.beats, f"{k}", here))
            yield Answer(units, partial(state, runs=tuple(runs)))
        part = work.part("correction", _FULL, _CORRECTION)
        for corrected_run in corrected_runs(trials, target, runs, self.corrections, self.polish, self.beats, part):
            runs.append(corrected_run)
            yield Answer(units, partial(state, runs=tuple(runs)))
        state = partial(state, runs=tuple(runs))
        design = nearest_that_beats(runs, metric)
        if design is not None:
            part = work.part("check ", _CORRECTION, _CHECK)
            checks = compare_designs(trials, nominal, target, runs, self.beats, step, part)
            state = partial(state, checks=checks, cliff=end_of_beating(trials, target, design.numbers, part))
            yield Answer(units, state)
            design = nearest_that_beats(checks or runs, metric)
        if design is not None and self.samples and self.spread:
            tolerances = list[Candidates]()
            for batch in self._tolerance_batches(prepared, design, work.part("tolerances", _CHECK, 1.0)):
                tolerances.append(batch)
                yield Answer(units, partial(state, tolerances=tuple(tolerances)))
            state = partial(state, tolerances=tuple(tolerances))
        work.report(1.0)
        yield Answer(units, partial(state, is_complete=True))

    def _tolerance_batches(self, prepared: Prepared, design: CheckedCandidate, work: Work) -> Iterator[Candidates]:
        """Yield exciters about the design, by their corrected spectra."""
        trials, _, target, _, _ = prepared
        shifted_target = shift_spectrum(target, design.slow.cycles, design.cycles)
        about = design.numbers * (1 + self.spread * (2 * sobol_points(trials, self.samples, [self.seed, 1]) - 1))
        # The corrected distance of the design itself is not quite that of its full equations: the target's cycles are not its.
        deviation = design.distances - np.array(spectrum_distances(design.slow.cycles, shifted_target, self.slope))
        for batch in candidate_batches(trials, about, shifted_target, self.population, "tolerances", work):
            yield replace(batch, distances=np.maximum(batch.distances + deviation, 0.0))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw spectra, a beat, reachable spectra, the search and tolerances."""
        return figure(result)


def _check_ends(trials: DesignTrials, nominal: np.ndarray) -> None:
    """Raise ``InputError`` for an end of a range that the parts do not allow, with nominal values otherwise."""
    for k, v in enumerate(trials.variables):
        for end in (v.low, v.high):
            try:
                trials.candidate_machine(np.where(np.arange(len(nominal)) == k, end, nominal))
            except InputError as error:
                raise InputError(f"study.vary.{v.name}", end, error.explanation) from None
