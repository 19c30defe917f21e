"""Findings -> the Dataset of an approximation: deviations, and whether the averaged equations may be trusted, and why not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.deviations import watched
from wucht.results.conventions import answered, variable
from wucht.studies.approximation.comparison import CURVE, Comparison, angles
from wucht.studies.approximation.prepare import Plan
from wucht.studies.approximation.run import Findings

if TYPE_CHECKING:
    import xarray as xr

TRUSTED = 0.05  # of the largest speed up to until_phi: a deviation beyond it is not small
AMPLITUDE_TRUSTED = 0.25  # of the largest amplitude: that of a carrier that starts at rest is not in the averaged equations
LEAST_ORDER = 0.7  # of the nominal order: below, epsilon is not small enough for the error to fall with it
_AS_NUMBER = {True: 1, False: 0, None: -1}
_ANSWERS = {
    True: "the averaged equations may be trusted for this machine",
    False: "the averaged equations are not to be trusted for this machine",
    None: "not decided whether the averaged equations may be trusted",
}


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """What was compared.

    Variables: speed_deviation, amplitude_deviation, the same relative to the largest of the full run, same_outcome, outcome,
    slow_outcome, failed (value); speed_over_angle, amplitude_over_angle (value, angle), the deviations up to ``until_phi``;
    error (factor), where it was measured. The machine's own values come last, at the value NaN.
    """
    import xarray as xr_

    machine, along, whose = plan.machine, plan.spec.along, _speeds_of(plan)
    speed, length = machine.units.speed, machine.orbit_unit
    name, unit = f"factor of {' and '.join(along)}" if along else "value", ""
    if len(along) == 1:
        name, unit = machine.parameters[along[0]].called, machine.parameters[along[0]].unit
    shown = [*findings.compared[1:], *findings.compared[:1]]
    factors, error = ([], []) if findings.measured is None else (findings.measured.factors, findings.measured.speed)
    curves = np.array([c.curves for c in shown]).reshape(-1, 2, CURVE)
    largest, relative = np.array([(c.largest, c.relative) for c in shown]).reshape(-1, 2, 2).transpose(1, 2, 0)
    same = [_AS_NUMBER[c.same_outcome] for c in shown]
    data = {
        "speed_deviation": variable("value", largest[0], f"largest deviation of the speed of {whose}", speed),
        "amplitude_deviation": variable("value", largest[1], "largest deviation of the amplitude", length),
        "relative_speed_deviation": variable("value", relative[0], f"relative deviation of the speed of {whose}"),
        "relative_amplitude_deviation": variable("value", relative[1], "relative deviation of the amplitude"),
        "same_outcome": variable("value", same, "whether both end alike (-1: unknown)"),
        "outcome": variable("value", [c.outcome for c in shown], "outcome of the full equations"),
        "slow_outcome": variable("value", [c.slow_outcome for c in shown], "outcome of the averaged equations"),
        "failed": variable("value", [c.failure for c in shown], "why a run failed"),
        "speed_over_angle": variable("value angle", curves[:, 0], f"deviation of the speed of {whose}", speed),
        "amplitude_over_angle": variable("value angle", curves[:, 1], "deviation of the amplitude", length),
        "error": variable("factor", error, f"error of the speed of {whose}", speed),
    }
    coordinates = {
        "value": variable("value", [c.value for c in shown], name, unit),
        "angle": variable("angle", angles(plan.spec.until_phi), "angle of the rotor", "rad"),
        "factor": variable("factor", factors, "factor of epsilon"),
    }
    failed = [c for c in findings.compared if c.failure]
    warnings = [c.failure if math.isnan(c.value) else f"{name} = {c.value:.6g}: {c.failure}" for c in failed]
    if findings.unmeasured:
        warnings.append(f"the order of the error could not be measured: {findings.unmeasured}")
    if not findings.complete:
        warnings.append(f"{max(len(findings.compared) - 1, 0)} of {len(plan.values) - 1} values are compared")
    summary = _summary(plan, findings)
    sentence = ": ".join(filter(None, (_ANSWERS[summary["trusted"]], "; ".join(summary["reasons"]))))
    result = answered(xr_.Dataset(dict(data), coords=coordinates), summary, sentence, warnings)
    return result.assign_attrs(trusted_speed=TRUSTED, trusted_amplitude=AMPLITUDE_TRUSTED)


def _speeds_of(plan: Plan) -> str:
    """Whose speeds are compared, in words."""
    return "the rotor" if plan.machine.rotor in watched(plan.machine) else "the bodies"


def _summary(plan: Plan, findings: Findings) -> dict[str, Any]:
    """The summary."""
    along, measured = plan.spec.along, findings.measured
    own, others, single = findings.compared[:1], findings.compared[1:], along[0] if len(along) == 1 else None
    trusted, reasons = _trusted(plan, findings)
    return {
        "along": single or list(along),
        "deviations": [{single or "factor": c.value} | _short(c) for c in others],
        "own": _short(own[0]) if own else None,
        "disagreement": regions(others),
        "errors": None if measured is None else dict(zip(map(str, measured.factors), measured.speed, strict=True)),
        "order_of_error": None if measured is None else measured.order,
        "nominal_order": None if measured is None else measured.nominal,
        "speeds_of": _speeds_of(plan),
        "along_unit": plan.machine.parameters[single].unit if single else "",
        "amplitude_unit": plan.machine.orbit_unit,
        "until_phi": plan.spec.until_phi,
        "trusted": trusted,
        "reasons": reasons,
    }


def _short(c: Comparison) -> dict[str, Any]:
    deviations = dict(zip(("speed", "amplitude"), c.largest, strict=True))
    return deviations | {name: getattr(c, name) for name in ("same_outcome", "outcome", "slow_outcome")}


def regions(compared: Sequence[Comparison]) -> list[list[float]]:
    """Ranges of the parameter, from the first to the last value of each row of values with different outcomes."""
    rows = ([c.value for c in row] for differ, row in groupby(compared, lambda c: c.same_outcome is False) if differ)
    return [[row[0], row[-1]] for row in rows]


def _trusted(plan: Plan, findings: Findings) -> tuple[bool | None, list[str]]:
    """Whether the averaged equations may be trusted for the machine as it is, None where not all is known; and why not."""
    if not findings.complete:
        return None, ["it was interrupted before this was decided"]
    own, measured, reasons = findings.compared[0], findings.measured, list[str]()
    if own.same_outcome is False:
        reasons.append(f"the full equations end {own.outcome}, the slow ones {own.slow_outcome}")
    if math.isnan(own.relative[0]):
        reasons.append("they share no angle")
    limits = {f"the speeds of {_speeds_of(plan)}": TRUSTED, "the amplitudes": AMPLITUDE_TRUSTED}
    for (what, limit), share in zip(limits.items(), own.relative, strict=True):
        if share > limit:
            reasons.append(f"{what} differ by {100 * share:{'.0f' if share >= 0.1 else '.2g'}} % of the largest")
    if measured is not None and measured.order < LEAST_ORDER * measured.nominal:
        power = f"{measured.order:.2g}, not {measured.nominal:g}"
        reasons.append(f"their error falls with epsilon to the power {power}: epsilon is not small")
    if reasons:
        return False, reasons
    if own.same_outcome is None:
        reasons.append("the runs are too short to tell an outcome; give a longer study.until")
    if findings.unmeasured:
        reasons.append(f"whether the error falls with epsilon could not be measured: {findings.unmeasured}")
    return None if reasons else True, reasons
