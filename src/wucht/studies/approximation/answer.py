"""Findings -> the quantities of an approximation: deviations, whether the averaged equations may be trusted; its lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.run_ups.deviations import watched
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity, answer, table
from wucht.studies.approximation.computation import CURVE, Comparison, Findings, Plan, angles

if TYPE_CHECKING:
    import xarray as xr


TRUSTED = 0.05  # of the largest speed up to until_phi: a larger deviation is not small
AMPLITUDE_TRUSTED = 0.25  # of the largest amplitude: the averaged equations lack the transient of a carrier that starts at rest
LEAST_ORDER = 0.7  # of the nominal order: below, epsilon is too large for the error to decrease with it
_DEVIATIONS = ("speed", "amplitude")
_AS_NUMBER = {True: 1, False: 0, None: -1}
_ANSWERS = {
    True: "the averaged equations may be trusted for this machine",
    False: "the averaged equations are not to be trusted for this machine",
    None: "not decided whether the averaged equations may be trusted",
}


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of the comparisons, with the nominal machine last, at the value NaN."""
    trusted, reasons = _trusted(plan, findings)
    quantities = [
        *_of_comparisons(plan, findings),
        *_of_summary(plan, findings),
        Quantity("trusted", trusted, "whether the averaged equations may be trusted"),
        Quantity("reasons", reasons, "reasons against it"),
    ]
    sentence = ": ".join(filter(None, (_ANSWERS[trusted], "; ".join(reasons))))
    warnings = _warnings(plan, findings)
    return answer(quantities, sentence, warnings, trusted_speed=TRUSTED, trusted_amplitude=AMPLITUDE_TRUSTED)


def _varied(plan: Plan) -> tuple[str, str]:
    """The varied parameter in words, and its unit."""
    along = plan.spec.along
    if len(along) == 1:
        return plan.machine.parameters[along[0]].called, plan.machine.parameters[along[0]].unit
    return f"factor of {' and '.join(along)}" if along else "value", ""


def _of_comparisons(plan: Plan, findings: Findings) -> list[Quantity]:
    """Deviations up to ``until_phi``, and the error at each factor of epsilon, if it was measured."""
    whose, parts, measured = _speeds_of(plan), _of_each(plan), findings.measured
    speed, length = parts["speed"][1], parts["amplitude"][1]
    shown = [*findings.compared[1:], *findings.compared[:1]]
    factors, error = ([], []) if measured is None else (measured.factors, measured.speed)
    curves = np.array([c.curves for c in shown]).reshape(-1, 2, CURVE)
    largest, relative = np.array([(c.largest, c.relative) for c in shown]).reshape(-1, 2, 2).transpose(1, 2, 0)
    same = [_AS_NUMBER[c.same_outcome] for c in shown]
    return [
        Quantity("value", [c.value for c in shown], *_varied(plan), "value"),
        Quantity("angle", angles(plan.spec.until_phi), "angle of the rotor", "rad", "angle"),
        Quantity("factor", factors, "factor of epsilon", "", "factor"),
        *(Quantity(f"{name}_deviation", of, *parts[name], "value") for name, of in zip(_DEVIATIONS, largest, strict=True)),
        Quantity("relative_speed_deviation", relative[0], f"relative deviation of the speed of {whose}", "", "value"),
        Quantity("relative_amplitude_deviation", relative[1], "relative deviation of the amplitude", "", "value"),
        Quantity("same_outcome", same, "whether both have the same outcome (-1: unknown)", "", "value"),
        Quantity("outcome", [c.outcome for c in shown], *parts["outcome"], "value"),
        Quantity("slow_outcome", [c.slow_outcome for c in shown], *parts["slow_outcome"], "value"),
        Quantity("failed", [c.failure for c in shown], "reason why a run failed", "", "value"),
        Quantity("speed_over_angle", curves[:, 0], f"deviation of the speed of {whose}", speed, "value angle"),
        Quantity("amplitude_over_angle", curves[:, 1], "deviation of the amplitude", length, "value angle"),
        Quantity("error", error, f"error of the speed of {whose}", speed, "factor"),
    ]


def _of_summary(plan: Plan, findings: Findings) -> list[Quantity]:
    along, measured, (name, unit), parts = plan.spec.along, findings.measured, _varied(plan), _of_each(plan)
    own, others, key = findings.compared[:1], findings.compared[1:], along[0] if len(along) == 1 else "factor"
    errors = measured and dict(zip(map(str, measured.factors), measured.speed, strict=True))
    order, nominal = (None, None) if measured is None else (measured.order, measured.nominal)
    deviations = [{key: c.value} | _short(c) for c in others]
    return [
        Quantity("along", along[0] if len(along) == 1 else list(along), "varied parameter"),
        *table("deviations", deviations, "largest deviations at each value", {key: (name, unit)} | parts),
        Quantity("own", _short(own[0]) if own else None, "largest deviations of the nominal machine", parts=parts),
        Quantity("disagreement", regions(others), "ranges in which the outcomes differ", unit),
        Quantity("errors", errors, "errors of the averaged equations by factor of epsilon", parts["speed"][1]),
        Quantity("order_of_error", order, "power of epsilon with which the error falls", headline=True),
        Quantity("nominal_order", nominal, "power of epsilon with which the error should fall"),
        Quantity("speeds_of", _speeds_of(plan), "bodies whose speeds are compared"),
        Quantity("along_unit", unit, "unit of the varied parameter"),
        Quantity("amplitude_unit", parts["amplitude"][1], "unit of amplitudes"),
        Quantity("until_phi", plan.spec.until_phi, "angle of the rotor up to which deviations count", "rad"),
    ]


def _of_each(plan: Plan) -> dict[str, tuple[str, str]]:
    """Names in words and units of the numbers of a comparison."""
    return {
        "speed": (f"largest deviation of the speed of {_speeds_of(plan)}", plan.machine.units.speed),
        "amplitude": ("largest deviation of the amplitude", plan.machine.orbit_unit),
        "same_outcome": ("whether both have the same outcome", ""),
        "outcome": ("outcome of the full equations", ""),
        "slow_outcome": ("outcome of the averaged equations", ""),
    }


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    name, failed = _varied(plan)[0], [c for c in findings.compared if c.failure]
    warnings = [c.failure if math.isnan(c.value) else f"{name} = {c.value:.6g}: {c.failure}" for c in failed]
    if findings.unmeasured:
        warnings.append(f"the order of the error could not be measured: {findings.unmeasured}")
    if not findings.complete:
        warnings.append(f"{max(len(findings.compared) - 1, 0)} of {len(plan.values) - 1} values are compared")
    return warnings


def _speeds_of(plan: Plan) -> str:
    """The bodies whose speeds are compared, in words."""
    return "the rotor" if plan.machine.rotor in watched(plan.machine) else "the bodies"


def _short(c: Comparison) -> dict[str, Any]:
    deviations = dict(zip(_DEVIATIONS, c.largest, strict=True))
    return deviations | {name: getattr(c, name) for name in ("same_outcome", "outcome", "slow_outcome")}


def regions(compared: Sequence[Comparison]) -> list[list[float]]:
    """Ranges of the parameter with different outcomes, each from its first to its last value."""
    rows = ([c.value for c in row] for differ, row in groupby(compared, lambda c: c.same_outcome is False) if differ)
    return [[row[0], row[-1]] for row in rows]


def _trusted(plan: Plan, findings: Findings) -> tuple[bool | None, list[str]]:
    """True if the averaged equations may be trusted for the nominal machine, None if undecided; and the reasons against it."""
    if not findings.complete:
        return None, ["the study was interrupted before this was decided"]
    own, measured, reasons = findings.compared[0], findings.measured, list[str]()
    if own.same_outcome is False:
        reasons.append(f"the full equations end {own.outcome}, the averaged ones {own.slow_outcome}")
    if math.isnan(own.relative[0]):
        reasons.append("the runs have no angle of the rotor in common")
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
        reasons.append("the runs are too short for an outcome; give a longer study.until")
    if findings.unmeasured:
        reasons.append(f"whether the error falls with epsilon could not be measured: {findings.unmeasured}")
    return None if reasons else True, reasons


_VERDICTS = {True: "TRUSTED", False: "NOT TRUSTED", None: "NOT DECIDED"}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for an approximation."""
    s, lines = result.wucht.summary, ReportLines(result)
    for reason in s["reasons"]:
        lines.add("because", reason)
    if s["own"] is not None:
        lines.add("this machine", _compared(s["own"], s["speeds_of"]), s["own"], "own")
    lines.add("order", "the error falls with epsilon to the power {order_of_error:.2f}")
    key, unit, name = "factor", "", f"factor of {' and '.join(s['along'])}"
    if isinstance(s["along"], str):
        key, unit, name = s["along"], f" {s['along_unit']}".rstrip(), s["along"]
    if s["deviations"]:
        lines.add(f"along {name}, up to {s['until_phi']:.4g} rad of the rotor's angle", "")
    for d in s["deviations"]:
        lines.add(f"  {f'{d[key]:.6g}{unit}':<14} ", _compared(d, s["speeds_of"]), d, "deviations")
    for low, high in s["disagreement"]:
        where = f"at {low:.6g}{unit}" if low == high else f"from {low:.6g} to {high:.6g}{unit}"
        lines.add(f"the models end differently {where}", "")
    return lines.report(_VERDICTS[s["trusted"]])


def _compared(d: dict[str, Any], whose: str) -> str:
    apart = f"speeds of {whose} differ by {{speed}} at most, amplitudes by {{amplitude}}"
    ends = "both {outcome}" if d["same_outcome"] else "{outcome}, averaged equations {slow_outcome}"
    return f"{'nothing in common' if d['speed'] is None else apart}; {ends}"
