"""The answer of the study ``entrainment`` in numbers and in words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import wrapped
from wucht.results.outcomes import Outcome
from wucht.studies.entrainment.locked_motions import bodies_with_phase
from wucht.studies.entrainment.prepare import Plan
from wucht.studies.entrainment.run import Findings

_MOVING = 0.02  # rad: a phase that drifts more in the second half of the window has not come to rest


def in_a_turn(machine: Machine, phases: np.ndarray) -> np.ndarray:
    """Phases to a vibration in (-pi, pi], as 001 (22) has them, to a rotor in [0, 2 pi)."""
    return math.pi - wrapped(math.pi - phases) if machine.shaken is not None else wrapped(phases)


def summary(plan: Plan, findings: Findings) -> dict[str, Any]:
    """The summary of the contract."""
    own, motion, existing, capture = findings.own, findings.own_motion, findings.existing, findings.band
    band = existing.band if existing is not None else None
    phases, averaged = _phases(plan, findings), _averaged_phases(plan, findings)
    mean = None if own is None else own.mean_speed
    return {
        "sentence": _sentence(plan, findings),
        "outcome": str(_outcome(plan, findings)),
        "along": plan.swept.name,
        "along_unit": plan.swept.unit,
        "value": plan.swept.own,
        "range": None if findings.range is None else list(findings.range),
        "existence_band": None if band is None else [None if e.kind == "range" else e.value for e in (band.low, band.high)],
        "existence_band_from": None if band is None else "slow equations",
        "existence_edges": None if band is None else [band.low.kind, band.high.kind],
        "branch": None if band is None else band.branch,
        "existence_band_full": list(findings.ends) if findings.motions else None,
        "band_from_rest": None if capture is None else [capture.low, capture.high],
        "islands": [] if capture is None else [list(i) for i in capture.islands],
        "phase": _one(phases),
        "phases": phases,
        "phase_slow": _one(averaged),
        "phases_slow": averaged,
        "mean_speed": mean if motion is None or mean is None else math.copysign(motion.speed, mean),
        "window": None if own is None else list(own.window),
        "stable": None if motion is None else motion.stable,
        "multiplier": None if motion is None else motion.multiplier,
        "threshold_amplitude": findings.threshold,
        "resolution": findings.resolution,
    }


def warnings(plan: Plan, findings: Findings) -> list[str]:
    """What is doubtful, left out, or not yet done."""
    swept, existing, runs = plan.swept, findings.existing, findings.runs
    unit = f" {swept.unit}" if swept.unit else ""
    lines = [findings.left_out] if findings.left_out is not None else []
    lines += existing.equations.averaged.warnings if existing is not None else ()
    lines += [f"at {swept.name} = {r.value:.6g}: {r.failure}" for r in runs if r.failure is not None]
    lines += [findings.no_motion] if findings.no_motion is not None else []
    if not findings.complete and findings.failure is None:
        lines.append(f"{len(runs)} runs from the start are finished; the search is not")
    if findings.band is not None and findings.band.islands:
        where = ", ".join(f"{low:.5g} to {high:.5g}" for low, high in findings.band.islands)
        lines.append(f"from the start it is also reached apart from the band: {where}{unit}; finer points may show more")
    moving = next((r for r in runs if r.entrained and r.drift > _MOVING), None)
    if moving is not None:
        lines.append(
            f"at {swept.name} = {moving.value:.6g}{unit} the phase still moves at the end of the run: give a longer until"
        )
    return lines


def _phases(plan: Plan, findings: Findings) -> dict[str, float]:
    """By body: of the locked motion, else at the end of the run that is taken along."""
    names, own, motion = bodies_with_phase(plan.machine), findings.own, findings.own_motion
    if motion is not None:
        return dict(zip(names, in_a_turn(plan.machine, motion.phases).tolist(), strict=True))
    if own is None or not own.entrained:
        return {}
    if "vibration" in own.phases:
        return {names[0]: float(in_a_turn(plan.machine, np.array(own.phases["vibration"])))}
    return dict(own.phases)


def _averaged_phases(plan: Plan, findings: Findings) -> dict[str, float]:
    phases = findings.existing.phases if findings.existing is not None else {}
    return {name: float(in_a_turn(plan.machine, np.array(phase))) for name, phase in phases.items()}


def _one(phases: dict[str, float]) -> float | dict[str, float] | None:
    """The phase where there is one, else all by name; None where there is none."""
    return next(iter(phases.values())) if len(phases) == 1 else phases or None


def _outcome(plan: Plan, findings: Findings) -> Outcome:
    if findings.own is None:
        return Outcome.UNIDENTIFIED
    if findings.failure is not None:
        return Outcome.FAILED
    if plan.machine.shaken is not None:
        return Outcome.ENTRAINED if findings.own.entrained else Outcome.NOT_ENTRAINED
    return Outcome.SYNCHRONISED if findings.own.entrained else Outcome.NOT_SYNCHRONISED


def _sentence(plan: Plan, findings: Findings) -> str:
    if findings.failure is not None:
        return findings.failure
    outcome = _outcome(plan, findings).sentence
    if findings.band is None:
        if not findings.complete:
            return f"{outcome}; the study was interrupted before its band was found"
        return f"{outcome}; nowhere in the range is it reached from the start"
    name, unit = plan.swept.name, f" {plan.swept.unit}" if plan.swept.unit else ""
    low, high = findings.band.low, findings.band.high
    if low is not None and high is not None:
        return f"{outcome}; from the start that is reached between {name} = {low:.6g} and {high:.6g}{unit}"
    if low is None and high is None:
        return f"{outcome}; from the start that is reached in all of the range"
    side, edge = ("below", high) if low is None else ("above", low)
    return f"{outcome}; from the start that is reached {side} {name} = {edge:.6g}{unit}"
