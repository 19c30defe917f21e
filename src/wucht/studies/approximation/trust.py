"""Whether the slow equations may be trusted for a machine, and why not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from wucht.studies.approximation.comparison import Comparison
from wucht.studies.approximation.prepare import Plan
from wucht.studies.approximation.run import Findings
from wucht.studies.deviations import watched

TRUSTED = 0.05  # of the largest speed up to until_phi: a deviation beyond it is not small
AMPLITUDE_TRUSTED = 0.25  # of the largest amplitude: that of a carrier that starts at rest is not in the slow equations
LEAST_ORDER = 0.7  # of the nominal order: below, epsilon is not small enough for the error to fall with it


def speeds_of(plan: Plan) -> str:
    """Whose speeds are compared, in words."""
    return "the rotor" if plan.machine.rotor in watched(plan.machine) else "the bodies"


def summary_of(plan: Plan, findings: Findings) -> dict[str, Any]:
    """The summary. ``trusted`` is None where nothing speaks against it but not all is known."""
    machine, along, measured, own = plan.machine, plan.spec.along, findings.measured, findings.own
    single = along[0] if len(along) == 1 else None
    doubts, undecided = _doubts(plan, findings), _undecided(findings)
    if not findings.complete:
        doubts, undecided = [], ["it was interrupted before this was decided"]
    return {
        "along": single or list(along),
        "deviations": [{single or "factor": c.value} | _short(c) for c in findings.along],
        "own": None if own is None else _short(own),
        "disagreement": regions(findings.along),
        "errors": None if measured is None else dict(zip(map(str, measured.factors), measured.speed, strict=True)),
        "order_of_error": None if measured is None or math.isinf(measured.order) else measured.order,
        "nominal_order": None if measured is None else measured.nominal,
        "speeds_of": speeds_of(plan),
        "along_unit": machine.parameters[single].unit if single else "",
        "amplitude_unit": machine.orbit_unit,
        "until_phi": plan.spec.until_phi,
        "trusted": False if doubts else None if undecided else True,
        "reasons": doubts or undecided,
    }


def _short(c: Comparison) -> dict[str, Any]:
    speed, amplitude = (x if math.isfinite(x) else None for x in c.largest)
    return {
        "speed": speed,
        "amplitude": amplitude,
        "same_outcome": c.same_outcome,
        "outcome": c.outcome,
        "slow_outcome": c.slow_outcome,
    }


def regions(compared: Sequence[Comparison]) -> list[list[float]]:
    """Ranges of the parameter, from the first to the last value of each row of values with different outcomes."""
    rows: list[list[float]] = []
    before = True
    for c in compared:
        if c.same_outcome is False:
            rows = [*rows, [c.value, c.value]] if before else [*rows[:-1], [rows[-1][0], c.value]]
        before = c.same_outcome is not False
    return rows


def _doubts(plan: Plan, findings: Findings) -> list[str]:
    """Why the slow equations may not be trusted for the machine as it is."""
    own, measured = findings.own, findings.measured
    if own is None:
        return []
    doubts = []
    if own.same_outcome is False:
        doubts.append(f"the full equations end {own.outcome}, the slow ones {own.slow_outcome}")
    if math.isnan(own.relative[0]):
        doubts.append("they share no angle")
    limits = {f"the speeds of {speeds_of(plan)}": TRUSTED, "the amplitudes": AMPLITUDE_TRUSTED}
    doubts += [
        f"{what} differ by {_percent(apart)} of the largest"
        for (what, limit), apart in zip(limits.items(), own.relative, strict=True)
        if apart > limit
    ]
    if measured is not None and measured.order < LEAST_ORDER * measured.nominal:
        doubts.append(
            f"their error falls with epsilon to the power {measured.order:.2g}, not {measured.nominal:g}: epsilon is not small"
        )
    return doubts


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def _undecided(findings: Findings) -> list[str]:
    """Why nothing can be said."""
    reasons = []
    if findings.own is not None and findings.own.same_outcome is None:
        reasons.append("the runs are too short to tell an outcome; give a longer study.until")
    if findings.unmeasured:
        reasons.append(f"whether the error falls with epsilon could not be measured: {findings.unmeasured}")
    return reasons


def sentence_of(summary: dict[str, Any]) -> str:
    """The answer in words."""
    if summary["trusted"]:
        return "the slow equations may be trusted for this machine"
    if summary["trusted"] is None:
        return f"not decided whether the slow equations may be trusted: {'; '.join(summary['reasons'])}"
    return f"the slow equations are not to be trusted for this machine: {'; '.join(summary['reasons'])}"
