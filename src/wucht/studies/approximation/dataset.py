"""Findings -> the quantities of an approximation: deviations, whether the averaged equations may be trusted; its lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.deviations import compared_bodies
from wucht.results.formatting import ReportLines, unit_in_print, value_in_words
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.approximation.computation import CURVE, Findings, ModelComparison, Plan, angles

if TYPE_CHECKING:
    import xarray as xr


SPEED_TOLERANCE = 0.05  # of the largest speed up to until_phi: a larger deviation is not small
AMPLITUDE_TOLERANCE = (
    0.25  # of the largest amplitude: the averaged equations lack the transient of a carrier that starts at rest
)
LEAST_ORDER = 0.7  # of the nominal order: below, epsilon is too large for the error to decrease with it
_DEVIATIONS = ("speed", "amplitude")
_AS_NUMBER = {True: 1, False: 0, None: -1}
_ANSWERS = {
    True: "full and averaged equations agree for this machine",
    False: "full and averaged equations do not agree for this machine",
    None: "it is not decided whether full and averaged equations agree for this machine",
}


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of the comparisons, with the nominal machine last, at the value NaN."""
    is_trusted, reasons = _trust_verdict(plan, findings)
    quantities = [
        *_comparison_quantities(plan, findings),
        *_summary_quantities(plan, findings),
        Quantity("trusted", is_trusted, "whether the averaged equations may be trusted"),
        Quantity("reasons", reasons, "reasons against it"),
    ]
    sentence = ": ".join(filter(None, (_ANSWERS[is_trusted], "; ".join(reasons)))) + (
        _exceptions(plan, findings) if is_trusted else ""
    )
    warnings = _warnings(plan, findings)
    return result_dataset(
        quantities, sentence, warnings, trusted_speed=SPEED_TOLERANCE, trusted_amplitude=AMPLITUDE_TOLERANCE,
        **_nominal_value(plan),
    )  # fmt: skip


def _nominal_value(plan: Plan) -> dict[str, Any]:
    """The machine's value of the varied parameter, or of the factor of several."""
    along = plan.spec.along
    return {"nominal": plan.machine.values[along[0]] if len(along) == 1 else 1.0} if along else {}


def _exceptions(plan: Plan, findings: Findings) -> str:
    """A clause on the varied values at which the outcomes differ: the verdict is on the nominal values alone."""
    values = [c.value for c in findings.comparisons[1:] if c.same_outcome is False]
    if not values:
        return ""
    name, unit = _parameter_words(plan)
    listing = ", ".join(value_in_words(value, *unit_in_print(unit)) for value in values)
    return f"; the outcomes differ at {name} = {listing}"


def _parameter_words(plan: Plan) -> tuple[str, str]:
    """The varied parameter in words, and its unit."""
    along = plan.spec.along
    if len(along) == 1:
        return plan.machine.parameters[along[0]].sentence_name, plan.machine.parameters[along[0]].unit
    return f"factor of {' and '.join(along)}" if along else "value", ""


def _comparison_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Deviations up to ``until_phi``, and the error at each factor of epsilon, if it was measured."""
    compared_bodies, parts, measured_errors = _compared_bodies(plan), _comparison_parts(plan), findings.measured_errors
    speed, length = parts["speed"][1], parts["amplitude"][1]
    comparisons = [*findings.comparisons[1:], *findings.comparisons[:1]]
    factors, error = ([], []) if measured_errors is None else (measured_errors.factors, measured_errors.speed)
    curves = np.array([c.curves for c in comparisons]).reshape(-1, 2, CURVE)
    largest, relative = np.array([(c.largest, c.relative) for c in comparisons]).reshape(-1, 2, 2).transpose(1, 2, 0)
    same = [_AS_NUMBER[c.same_outcome] for c in comparisons]
    return [
        Quantity("value", [c.value for c in comparisons], *_parameter_words(plan), "value"),
        Quantity("angle", angles(plan.spec.until_phi), "angle of the rotor", "rad", "angle"),
        Quantity("factor", factors, "factor of epsilon", "", "factor"),
        *(Quantity(f"{name}_deviation", of, *parts[name], "value") for name, of in zip(_DEVIATIONS, largest, strict=True)),
        Quantity("relative_speed_deviation", relative[0], f"relative deviation of the speed of {compared_bodies}", "", "value"),
        Quantity("relative_amplitude_deviation", relative[1], "relative deviation of the amplitude", "", "value"),
        Quantity("same_outcome", same, "whether both have the same outcome (-1: unknown)", "", "value"),
        Quantity("outcome", [c.outcome for c in comparisons], *parts["outcome"], "value"),
        Quantity("slow_outcome", [c.slow_outcome for c in comparisons], *parts["slow_outcome"], "value"),
        Quantity("failed", [c.failure for c in comparisons], "reason why a run failed", "", "value"),
        Quantity("speed_over_angle", curves[:, 0], f"deviation of the speed of {compared_bodies}", speed, "value angle"),
        Quantity("amplitude_over_angle", curves[:, 1], "deviation of the amplitude", length, "value angle"),
        Quantity("error", error, f"error of the speed of {compared_bodies}", speed, "factor"),
    ]


def _summary_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    along, measured_errors, (name, unit), parts = (
        plan.spec.along,
        findings.measured_errors,
        _parameter_words(plan),
        _comparison_parts(plan),
    )
    nominal_run, variants, key = findings.comparisons[:1], findings.comparisons[1:], along[0] if len(along) == 1 else "factor"
    errors = measured_errors and dict(zip(map(str, measured_errors.factors), measured_errors.speed, strict=True))
    order, nominal = (None, None) if measured_errors is None else (measured_errors.order, measured_errors.nominal)
    deviations = [{key: c.value} | _short(c) for c in variants]
    return [
        Quantity("along", along[0] if len(along) == 1 else list(along), "varied parameter"),
        *table("deviations", deviations, "largest deviations at each value", {key: (name, unit)} | parts),
        Quantity(
            "own", _short(nominal_run[0]) if nominal_run else None, "largest deviations of the nominal machine", parts=parts
        ),
        Quantity("disagreement", disagreement_ranges(variants), "ranges in which the outcomes differ", unit),
        Quantity("errors", errors, "errors of the averaged equations by factor of epsilon", parts["speed"][1]),
        Quantity("order_of_error", order, "power of epsilon with which the error falls", headline=True),
        Quantity("nominal_order", nominal, "power of epsilon with which the error should fall"),
        Quantity("speeds_of", _compared_bodies(plan), "bodies whose speeds are compared"),
        Quantity("along_unit", unit, "unit of the varied parameter"),
        Quantity("amplitude_unit", parts["amplitude"][1], "unit of amplitudes"),
        Quantity("until_phi", plan.spec.until_phi, "angle of the rotor up to which deviations count", "rad"),
    ]


def _comparison_parts(plan: Plan) -> dict[str, tuple[str, str]]:
    """Names in words and units of the numbers of a comparison."""
    return {
        "speed": (f"largest deviation of the speed of {_compared_bodies(plan)}", plan.machine.units.speed),
        "amplitude": ("largest deviation of the amplitude", plan.machine.orbit_unit),
        "same_outcome": ("whether both have the same outcome", ""),
        "outcome": ("outcome of the full equations", ""),
        "slow_outcome": ("outcome of the averaged equations", ""),
    }


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    name, failed_comparisons = _parameter_words(plan)[0], [c for c in findings.comparisons if c.failure]
    warnings = [c.failure if math.isnan(c.value) else f"{name} = {c.value:.6g}: {c.failure}" for c in failed_comparisons]
    if findings.unmeasured_reason:
        warnings.append(f"the order of the error could not be measured: {findings.unmeasured_reason}")
    if not findings.is_complete:
        warnings.append(f"{max(len(findings.comparisons) - 1, 0)} of {len(plan.values) - 1} values are compared")
    return warnings


def _compared_bodies(plan: Plan) -> str:
    """The bodies whose speeds are compared, in words."""
    return "the rotor" if plan.machine.rotor in compared_bodies(plan.machine) else "the bodies"


def _short(c: ModelComparison) -> dict[str, Any]:
    deviations = dict(zip(_DEVIATIONS, c.largest, strict=True))
    return deviations | {name: getattr(c, name) for name in ("same_outcome", "outcome", "slow_outcome")}


def disagreement_ranges(comparisons: Sequence[ModelComparison]) -> list[list[float]]:
    """Ranges of the parameter with different outcomes, each from its first to its last value."""
    rows = ([c.value for c in row] for differ, row in groupby(comparisons, lambda c: c.same_outcome is False) if differ)
    return [[row[0], row[-1]] for row in rows]


def _trust_verdict(plan: Plan, findings: Findings) -> tuple[bool | None, list[str]]:
    """True if the averaged equations may be trusted for the nominal machine, None if undecided; and the reasons against it."""
    if not findings.is_complete:
        return None, ["the study was interrupted before this was decided"]
    nominal_run, measured_errors, reasons = findings.comparisons[0], findings.measured_errors, list[str]()
    if nominal_run.same_outcome is False:
        reasons.append(f"the full equations end as {nominal_run.outcome}, the averaged ones as {nominal_run.slow_outcome}")
    if math.isnan(nominal_run.relative[0]):
        reasons.append("the runs have no angle of the rotor in common")
    limits = {f"the speeds of {_compared_bodies(plan)}": SPEED_TOLERANCE, "the amplitudes": AMPLITUDE_TOLERANCE}
    for (subject, limit), share in zip(limits.items(), nominal_run.relative, strict=True):
        if share > limit:
            reasons.append(f"{subject} differ by {100 * share:{'.0f' if share >= 0.1 else '.2g'}} % of the largest")
    if measured_errors is not None and measured_errors.order < LEAST_ORDER * measured_errors.nominal:
        power = f"{measured_errors.order:.2g}, not {measured_errors.nominal:g}"
        reasons.append(f"their error falls with epsilon to the power {power}: epsilon is not small")
    if reasons:
        return False, reasons
    if nominal_run.same_outcome is None:
        reasons.append("the runs are too short for an outcome; give a longer study.until")
    if findings.unmeasured_reason:
        reasons.append(f"whether the error falls with epsilon could not be measured: {findings.unmeasured_reason}")
    return None if reasons else True, reasons


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an approximation."""
    s, lines = result.wucht.summary, ReportLines(result)
    if s["own"] is not None:
        lines.add("this machine", _comparison_text(s["own"], s["speeds_of"]), s["own"], "own")
    lines.add("order", "the error falls with epsilon to the power {order_of_error:.2f}")
    key, unit, name = "factor", "", f"factor of {' and '.join(s['along'])}"
    if isinstance(s["along"], str):
        key, unit, name = s["along"], f" {s['along_unit']}".rstrip(), s["along"]
    if s["deviations"]:
        lines.add(f"along {name}, up to {s['until_phi']:.4g} rad of the rotor's angle", "")
    for d in s["deviations"]:
        lines.add(f"  {f'{d[key]:.6g}{unit}':<14} ", _comparison_text(d, s["speeds_of"]), d, "deviations")
    for low, high in s["disagreement"]:
        place = f"at {low:.6g}{unit}" if low == high else f"from {low:.6g} to {high:.6g}{unit}"
        lines.add(f"the models have different outcomes {place}", "")
    return lines.report(s["sentence"])


def _comparison_text(d: dict[str, Any], bodies_text: str) -> str:
    deviation_text = f"speeds of {bodies_text} differ by {{speed}} at most, amplitudes by {{amplitude}}"
    ends = "both {outcome}" if d["same_outcome"] else "{outcome}, averaged equations {slow_outcome}"
    return f"{'nothing in common' if d['speed'] is None else deviation_text}; {ends}"
