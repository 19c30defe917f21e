"""Spec and machine -> plan -> findings: target spectrum, variables, and candidates."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from wucht.dynamics.exciters.design_trials import (
    METRICS,
    Candidates,
    CheckedCandidate,
    DesignTrials,
    LocalOptimum,
    check_candidate,
    spectrum_distances,
)
from wucht.dynamics.exciters.slow_beats import Rig
from wucht.dynamics.run_ups.machine_signals import machine_signal
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.dynamics.sampling.choice import Cliff
from wucht.dynamics.sampling.searches import balancer_names, generations, require_pymoo, variables_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import EXPONENTS, shift_spectrum, standard_spectrum, tabulated_spectrum
from wucht.files.documents import Document, contents_digest
from wucht.files.tables import read_table
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.schema import Unit, read_quantity, require_table
from wucht.studies.exciter_design.design_plan import Plan
from wucht.studies.exciter_design.neighbour_check import compare_designs, end_of_beating
from wucht.studies.exciter_design.spec import ExciterDesign, Target
from wucht.studies.spec import Value
from wucht.studies.subjects import MACHINE, Description

_AT = "study.target"
_CYCLES = Unit("cycles", "number of cycles")  # without that unit a cycle would be 2 pi


def target_spectrum(target: Target, unit: str, folder: Path | None) -> LoadCycles:
    """Return the target spectrum. unit: of its amplitudes. folder: of its file. Raises ``InputError``."""
    amplitude = Unit(unit, "amplitude")
    if target.file is not None:
        if folder is None:
            raise InputError(
                f"{_AT}.file",
                target.file,
                "allowed only in a study file; else give the table",
                code="not-allowed",
            )
        try:
            rows = read_table(folder / target.file, (amplitude, _CYCLES))
        except InputError as error:
            raise InputError(f"{_AT}.file", target.file, error.explanation) from None
        return _spectrum_from_rows(rows, f"{_AT}.file", target.file, bool(target.stepped))
    if target.table is not None:
        return _spectrum_from_rows(_table_rows(target.table, amplitude), f"{_AT}.table", None, bool(target.stepped))
    if target.largest is None or target.cycles is None:
        raise InputError(_AT, None, "give largest and cycles")
    largest = read_quantity(amplitude, target.largest, f"{_AT}.largest")
    if not largest > 0:
        raise InputError(f"{_AT}.largest", target.largest, "must be an amplitude greater than 0")
    exponent = EXPONENTS[target.shape] if target.shape is not None else target.exponent
    if exponent is None:
        raise InputError(_AT, None, "give a shape or an exponent")
    return standard_spectrum(largest, target.cycles, exponent, target.ratio or 0.0)


def _table_rows(table: Sequence[tuple[Value, Value]], amplitude: Unit) -> list[list[float]]:
    """Return the rows of a table, by ascending amplitude."""
    units = (amplitude, _CYCLES)
    rows = [
        [read_quantity(units[k], entry, f"{_AT}.table[{i}][{k}]") for k, entry in enumerate(row)] for i, row in enumerate(table)
    ]
    return sorted(rows)


def _spectrum_from_rows(rows: Sequence[Sequence[float]], location: str, value: object, is_stepped: bool) -> LoadCycles:
    """Return the spectrum of a table. Raises ``InputError`` for a table that is no cumulative spectrum."""
    if len(rows) < 1 or (len(rows) < 2 and not is_stepped):
        raise InputError(location, value, "must have two rows at least, of amplitude and cumulative cycles")
    amplitudes, cumulative = np.array(rows, float).T
    if not (amplitudes >= 0).all() or not (np.diff(amplitudes) > 0).all() or not amplitudes[-1] > 0:
        raise InputError(location, value, "must have different amplitudes, none below 0")
    if not (cumulative > 0).all() or (np.diff(cumulative) > 0).any():
        raise InputError(location, value, "must have cycles greater than 0 that do not increase with the amplitude: each row "
                         "states how many have at least its amplitude")  # fmt: skip
    if not cumulative[0] > 1:
        raise InputError(location, value, "must have more than one cycle")
    return tabulated_spectrum(amplitudes, cumulative, is_stepped)


@dataclass(frozen=True)
class MachineInFolder:
    """Machine that was read from a study file in a folder."""

    machine: Machine
    folder: Path

    def contents(self, name: str) -> str:
        """Return the contents of a file beside the study file: a changed file makes another question."""
        return contents_digest(self.folder / name)


class MachineInFolderSubject:
    """Subject of a design: the machine of the table ``[machine]``, with its folder if the target lies in a file beside it."""

    def from_document(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[Machine | MachineInFolder, Document]:
        """Read the machine, see ``Subject``."""
        machine, facts = MACHINE.from_document(document, path, name, settings)
        target = require_table(document, "study", "study").get("target") if "study" in document else None
        has_target_file = isinstance(target, Mapping) and "file" in target
        return MachineInFolder(machine, path.parent) if has_target_file else machine, facts

    def describe(self, subject: Any) -> Description:
        """Describe the machine, see ``Subject``."""
        return MACHINE.describe(subject.machine if isinstance(subject, MachineInFolder) else subject)


MACHINE_IN_FOLDER = MachineInFolderSubject()


def prepare(spec: ExciterDesign, subject: MachineInFolder | Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the study does not fit the machine."""
    machine, folder = (subject.machine, subject.folder) if isinstance(subject, MachineInFolder) else (subject, None)
    require_pymoo(spec.kind)
    if not any(isinstance(p, Body) for p in machine.parts):
        raise InputError("machine.model", None, "not allowed: bodies, [[machine.bodies]], are needed, whose numbers are varied")
    if not balancer_names(machine):
        requirement = f"there must be a pendulum about {machine.rotor.name!r}: without it nothing beats"
        raise InputError("machine.bodies", None, requirement)
    if machine.schedules:
        raise InputError("machine.schedules", None, "allowed only for a machine without schedules: the beating must last")
    signal = machine_signal(machine, spec.signal, spec.direction)
    target = target_spectrum(spec.target, signal.unit, folder)
    rig = Rig(spec.signal, spec.direction, spec.start, spec.inertia, spec.tolerance)
    trials = DesignTrials(machine, variables_of(machine, spec.vary, False), rig, METRICS.index(spec.metric), spec.slope)
    numbers = np.array([machine.values[v.paths[0]] for v in trials.variables])
    _check_ends(trials, numbers)
    placed_machine, start = prepare_start(machine, spec.start, 0.0)
    warnings = slow_model(placed_machine, start, spec.inertia, 1).warnings
    return Plan(
        spec, machine, trials, numbers, target, signal.name, signal.unit, spec.evaluations // spec.population, tuple(warnings)
    )


def _check_ends(trials: DesignTrials, numbers: np.ndarray) -> None:
    """Raise ``InputError`` for an end of a range that the parts do not allow, with nominal values otherwise."""
    for k, v in enumerate(trials.variables):
        for end in (v.low, v.high):
            try:
                trials.candidate_machine(np.where(np.arange(len(numbers)) == k, end, numbers))
            except InputError as error:
                raise InputError(f"study.vary.{v.name}", end, error.explanation) from None


_REACH, _SEARCH, _POLISH, _FULL, _CORRECTION, _CHECK = 0.15, 0.4, 0.5, 0.55, 0.75, 0.95  # shares of the work after each
_WHOLE = 2  # corrections with as many evaluations as the local searches before; later ones are near, and have half as many
_APART = 0.1  # of the ranges: candidates nearer to each other count as one


@dataclass(frozen=True)
class Findings:
    """Candidates of a design.

    reach: random points of the ranges. search: generations. local_optima: of local searches. full_runs: candidates in the full
    equations, those of corrections last. checks: the best of these, its neighbours and the nominal exciter, by later beats.
    cliff: of the design. tolerances: exciters about the design, by their corrected spectra.
    """

    reach: tuple[Candidates, ...] = ()
    search: tuple[Candidates, ...] = ()
    local_optima: tuple[LocalOptimum, ...] = ()
    full_runs: tuple[CheckedCandidate, ...] = ()
    tolerances: tuple[Candidates, ...] = ()
    complete: bool = False
    checks: tuple[CheckedCandidate, ...] = ()
    cliff: Cliff | None = None

    def design(self, metric: int) -> CheckedCandidate | None:
        """Return the run of the full equations whose spectrum is nearest to the target, one of the checks if there are any;
        None where none beats."""
        beating = [c for c in self.checks or self.full_runs if c.beats and np.isfinite(c.distances[metric])]
        return min(beating, key=lambda c: float(c.distances[metric]), default=None)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Search for the design, and yield the findings after each batch of candidates and each run."""
    findings, spec, metric = Findings(), plan.spec, plan.trials.metric
    for batch in _candidate_batches(plan, _sobol(plan, spec.reach, 0), plan.target, "reach", work.part("reach", 0.0, _REACH)):
        findings = replace(findings, reach=(*findings.reach, batch))
        yield findings
    for generation in _search_generations(plan, findings, work.part("search", _REACH, _SEARCH)):
        findings = replace(findings, search=(*findings.search, generation))
        yield findings
    best = _best(plan, findings)
    part = work.part("polish", _SEARCH, _POLISH)
    for k, numbers in enumerate(best):
        here = part.part("", k / len(best), (k + 1) / len(best))
        findings = replace(
            findings, local_optima=(*findings.local_optima, _local_optimum(plan, numbers, plan.target, f"{k}", here))
        )
        yield findings
    part = work.part("full", _POLISH, _FULL)
    for k, one in enumerate(findings.local_optima):
        full_run = _full_run(plan, one.numbers, f"{k}", part.part("", k / len(best), (k + 1) / len(best)))
        findings = replace(findings, full_runs=(*findings.full_runs, full_run))
        yield findings
    for full_run in _corrected_runs(plan, findings, work.part("correction", _FULL, _CORRECTION)):
        findings = replace(findings, full_runs=(*findings.full_runs, full_run))
        yield findings
    design = findings.design(metric)
    if design is not None:
        part = work.part("check ", _CORRECTION, _CHECK)
        checks = compare_designs(plan, findings.full_runs, part)
        findings = replace(findings, checks=checks, cliff=end_of_beating(plan, design.numbers, part))
        yield findings
        design = findings.design(metric)
    if design is not None and spec.samples and spec.spread:
        target = shift_spectrum(plan.target, design.slow.cycles, design.cycles)
        about = design.numbers * (1 + spec.spread * (2 * _points(plan, spec.samples, 1) - 1))
        # The corrected distance of the design itself is not quite that of its full equations: the target's cycles are not its.
        deviation = design.distances - np.array(spectrum_distances(design.slow.cycles, target, spec.slope))
        part = work.part("tolerances", _CHECK, 1.0)
        for batch in _candidate_batches(plan, about, target, "tolerances", part):
            corrected = replace(batch, distances=np.maximum(batch.distances + deviation, 0.0))
            findings = replace(findings, tolerances=(*findings.tolerances, corrected))
            yield findings
    work.report(1.0)
    yield replace(findings, complete=True)


def _points(plan: Plan, count: int, stream: int) -> np.ndarray:
    """Return scrambled Sobol' points (P, k)."""
    from scipy.stats import qmc

    sobol = qmc.Sobol(len(plan.trials.variables), scramble=True, rng=np.random.default_rng([plan.spec.seed, stream]))
    return np.asarray(sobol.random(1 << (count - 1).bit_length())[:count])


def _sobol(plan: Plan, count: int, stream: int) -> np.ndarray:
    return plan.trials.values(_points(plan, count, stream))


def _candidate_batches(plan: Plan, numbers: np.ndarray, target: LoadCycles, label: str, work: Work) -> Iterator[Candidates]:
    """Evaluate candidates (P, k) in batches."""
    size = plan.spec.population
    for begin in range(0, len(numbers), size):
        part = work.part("", begin / len(numbers), min(1.0, (begin + size) / len(numbers)))
        rows = numbers[begin : begin + size]
        yield part.unit(f"{begin}", partial(plan.trials.evaluate, rows, target, _progress_report(part, label)))


def _progress_report(work: Work, label: str) -> Callable[[float], None]:
    return lambda share: work.report(share, label)


def _search_generations(plan: Plan, findings: Findings, work: Work) -> Iterator[Candidates]:
    """Yield the generations of the search, the first from the best random points and the nominal exciter."""
    size, metric = plan.spec.population, plan.trials.metric
    numbers, far = _all_candidates(findings.reach, metric)
    nominal_shares = plan.trials.shares(plan.numbers)
    first = np.array([plan.trials.shares(row) for row in numbers[np.argsort(far, kind="stable")[:size]]])
    if ((nominal_shares >= 0) & (nominal_shares <= 1)).all():
        first[-1] = nominal_shares
    latest: list[Candidates] = []

    def value(number: int, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        here = work.part("", number / plan.generations, (number + 1) / plan.generations)
        label = f"generation {number + 1} of {plan.generations}"
        rows = plan.trials.values(shares)
        batch = here.unit(
            f"generation {number}", partial(plan.trials.evaluate, rows, plan.target, _progress_report(here, label))
        )
        latest.append(batch)
        column = batch.distances[:, [metric]]
        return column, np.isfinite(column[:, 0])

    for _ in generations(plan.generations, first, 1, plan.spec.seed, value):
        yield latest[-1]


def _all_candidates(batches: tuple[Candidates, ...], metric: int) -> tuple[np.ndarray, np.ndarray]:
    """Return all candidates (P, k), and their distances (P,), infinite where undefined."""
    far = np.concatenate([b.distances[:, metric] for b in batches])
    return np.concatenate([b.numbers for b in batches]), np.where(np.isfinite(far), far, np.inf)


def _best(plan: Plan, findings: Findings) -> list[np.ndarray]:
    """Return the best candidates, each apart from those before it."""
    numbers, far = _all_candidates((*findings.reach, *findings.search), plan.trials.metric)
    shares = np.array([plan.trials.shares(row) for row in numbers])
    chosen: list[int] = []
    for k in np.argsort(far, kind="stable").tolist():
        if len(chosen) == plan.spec.candidates or not np.isfinite(far[k]):
            break
        if all(np.abs(shares[k] - shares[j]).max() > _APART for j in chosen):
            chosen.append(k)
    return [numbers[k] for k in chosen]


def _local_optimum(
    plan: Plan, numbers: np.ndarray, target: LoadCycles, name: str, work: Work, evaluations: int | None = None
) -> LocalOptimum:
    evaluations = plan.spec.polish if evaluations is None else evaluations
    if not evaluations:
        [far] = (
            plan.trials.evaluate(numbers[None], target, _progress_report(work, name)).distances[:, plan.trials.metric].tolist()
        )
        return LocalOptimum(numbers, far)
    search = partial(plan.trials.optimise, numbers, target, evaluations, _progress_report(work, "local search"))
    return work.unit(name, search)


def _full_run(plan: Plan, numbers: np.ndarray, name: str, work: Work) -> CheckedCandidate:
    work.report(0.0, "full equations")
    part = work.part(name, 0.0, 1.0)
    return work.unit(name, partial(check_candidate, plan.trials, numbers, plan.target, plan.spec.beats, part))


def _corrected_runs(plan: Plan, findings: Findings, work: Work) -> Iterator[CheckedCandidate]:
    """Optimise again for a target corrected by the deviation of the full equations: output space mapping.

    J. W. Bandler et al., "Space mapping: the state of the art", IEEE Transactions on Microwave Theory and Techniques 52 (2004)
    337-361.
    """
    count = plan.spec.corrections if plan.spec.polish else 0
    for k in range(count):
        best = findings.design(plan.trials.metric)
        if best is None:
            return
        here = work.part("", k / count, (k + 1) / count)
        target = shift_spectrum(plan.target, best.slow.cycles, best.cycles)
        part, evaluations = here.part("", 0.0, 0.8), plan.spec.polish if k < _WHOLE else -(-plan.spec.polish // 2)
        optimum = _local_optimum(plan, best.numbers, target, f"{k} polish", part, evaluations)
        full_run = _full_run(plan, optimum.numbers, f"{k} full", here.part("", 0.8, 1.0))
        findings = replace(findings, full_runs=(*findings.full_runs, full_run))
        yield full_run
        if findings.design(plan.trials.metric) is best:  # a further correction would give the same
            return
