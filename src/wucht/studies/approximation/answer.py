"""The answer of an approximation: deviations, whether the averaged equations may be trusted, and why not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np

from wucht.dynamics.run_ups.deviations import compared_bodies
from wucht.dynamics.scenarios.model_comparison import CURVE, ModelComparison, angles_at_curves
from wucht.dynamics.scenarios.order_of_error import Errors
from wucht.machines.machine import Machine
from wucht.results.formatting import unit_in_print, value_in_words
from wucht.studies.answer import Answer

SPEED_TOLERANCE = 0.05  # of the largest speed up to until_phi: a larger deviation is not small
AMPLITUDE_TOLERANCE = (
    0.25  # of the largest amplitude: the averaged equations lack the transient of a carrier that starts at rest
)
LEAST_ORDER = 0.7  # of the nominal order: below, epsilon is too large for the error to decrease with it
_AS_NUMBER = {True: 1, False: 0, None: -1}
_ANSWERS = {
    True: "full and averaged equations agree for this machine",
    False: "full and averaged equations do not agree for this machine",
    None: "it is not decided whether full and averaged equations agree for this machine",
}


def state_approximation(
    machine: Machine, along: Sequence[str], until_phi: float, count: int, comparisons: Sequence[ModelComparison],
    order: Errors | str | None, a: Answer,
) -> None:  # fmt: skip
    """State the comparisons so far, that of the nominal machine first of them.

    along, until_phi: keys of the study. count: of values of the parameter. order: the errors over epsilon, the reason why they
    are not known, None as long as they are not measured.
    """
    name, unit = _parameter_words(machine, along)
    errors = order if isinstance(order, Errors) else None
    _state_deviations(a, machine, along, until_phi, comparisons, errors)
    _state_summary(a, machine, along, until_phi, comparisons, errors)
    is_trusted, reasons = _trust_verdict(machine, comparisons, order)
    a.number("trusted", is_trusted, "whether the averaged equations may be trusted")
    a.number("reasons", reasons, "reasons against it")
    a.sentence = ": ".join(filter(None, (_ANSWERS[is_trusted], "; ".join(reasons))))
    apart = [c.value for c in comparisons[1:] if c.same_outcome is False]
    if is_trusted and apart:  # the verdict is on the nominal values alone
        listing = ", ".join(value_in_words(value, *unit_in_print(unit)) for value in apart)
        a.sentence += f"; the outcomes differ at {name} = {listing}"
    for c in comparisons:
        if c.failure:
            a.warn(c.failure if math.isnan(c.value) else f"{name} = {c.value:.6g}: {c.failure}")
    if isinstance(order, str):
        a.warn(f"the order of the error could not be measured: {order}")
    if order is None:
        a.warn(f"{max(len(comparisons) - 1, 0)} of {count} values are compared")
    a.attribute(trusted_speed=SPEED_TOLERANCE, trusted_amplitude=AMPLITUDE_TOLERANCE)
    if along:
        a.attribute(nominal=machine.values[along[0]] if len(along) == 1 else 1.0)


def _parameter_words(machine: Machine, along: Sequence[str]) -> tuple[str, str]:
    """The varied parameter in words, and its unit."""
    if len(along) == 1:
        return machine.parameters[along[0]].sentence_name, machine.parameters[along[0]].unit
    return f"factor of {' and '.join(along)}" if along else "value", ""


def _compared_bodies(machine: Machine) -> str:
    """The bodies whose speeds are compared, in words."""
    return "the rotor" if machine.rotor in compared_bodies(machine) else "the bodies"


def _comparison_parts(a: Answer, machine: Machine) -> dict[str, tuple[str, str]]:
    """Names in words and units of the numbers of a comparison."""
    return {
        "speed": (f"largest deviation of the speed of {_compared_bodies(machine)}", a.unit("speed")),
        "amplitude": ("largest deviation of the amplitude", machine.orbit_unit),
        "same_outcome": ("whether both have the same outcome", ""),
        "outcome": ("outcome of the full equations", ""),
        "slow_outcome": ("outcome of the averaged equations", ""),
    }


def _state_deviations(
    a: Answer, machine: Machine, along: Sequence[str], until_phi: float, of_cases: Sequence[ModelComparison],
    errors: Errors | None,
) -> None:  # fmt: skip
    """State deviations up to ``until_phi``, the nominal machine last, at the value NaN; and the error at each factor."""
    comparisons, bodies, parts = [*of_cases[1:], *of_cases[:1]], _compared_bodies(machine), _comparison_parts(a, machine)
    curves = np.array([c.curves for c in comparisons]).reshape(-1, 2, CURVE)
    largest, relative = np.array([(c.largest, c.relative) for c in comparisons]).reshape(-1, 2, 2).transpose(1, 2, 0)
    a.curve("value", [c.value for c in comparisons], *_parameter_words(machine, along))
    a.curve("angle", angles_at_curves(until_phi), "angle of the rotor", "rad")
    a.curve("factor", [] if errors is None else errors.factors, "factor of epsilon")
    a.curve("speed_deviation", largest[0], *parts["speed"], "value")
    a.curve("amplitude_deviation", largest[1], *parts["amplitude"], "value")
    a.curve("relative_speed_deviation", relative[0], f"relative deviation of the speed of {bodies}", "", "value")
    a.curve("relative_amplitude_deviation", relative[1], "relative deviation of the amplitude", "", "value")
    same = [_AS_NUMBER[c.same_outcome] for c in comparisons]
    a.curve("same_outcome", same, "whether both have the same outcome (-1: unknown)", "", "value")
    a.curve("outcome", [c.outcome for c in comparisons], *parts["outcome"], "value")
    a.curve("slow_outcome", [c.slow_outcome for c in comparisons], *parts["slow_outcome"], "value")
    a.curve("failed", [c.failure for c in comparisons], "reason why a run failed", "", "value")
    a.curve("speed_over_angle", curves[:, 0], f"deviation of the speed of {bodies}", "speed", "value angle")
    a.curve("amplitude_over_angle", curves[:, 1], "deviation of the amplitude", machine.orbit_unit, "value angle")
    a.curve("error", [] if errors is None else errors.speed, f"error of the speed of {bodies}", "speed", "factor")


def _state_summary(
    a: Answer, machine: Machine, along: Sequence[str], until_phi: float, comparisons: Sequence[ModelComparison],
    errors: Errors | None,
) -> None:  # fmt: skip
    """State the largest deviations, with a line for each value, and the order of the error."""
    (name, unit), parts = _parameter_words(machine, along), _comparison_parts(a, machine)
    bodies, nominal, variants = _compared_bodies(machine), comparisons[:1], comparisons[1:]
    a.number("own", _record(nominal[0]) if nominal else None, "largest deviations of the nominal machine", parts=parts)
    if nominal:
        a.line("this machine", _comparison_text(nominal[0], bodies), at="own")
    by_factor = errors and dict(zip(map(str, errors.factors), errors.speed, strict=True))
    a.number("errors", by_factor, "errors of the averaged equations by factor of epsilon", "speed")
    order, what = errors and errors.order, "power of epsilon with which the error falls"
    a.number("order_of_error", order, what, headline=True)
    a.number("nominal_order", errors and errors.nominal, "power of epsilon with which the error should fall")
    a.line("order", "the error falls with epsilon to the power {order_of_error:.2f}")
    key, printed_unit, parameter = "factor", "", f"factor of {' and '.join(along)}"
    if len(along) == 1:
        key, printed_unit, parameter = along[0], f" {unit}".rstrip(), along[0]
    a.number("along", along[0] if len(along) == 1 else list(along), "varied parameter")
    rows = [{key: c.value} | _record(c) for c in variants]
    a.number("deviations", rows, "largest deviations at each value", parts={key: (name, unit)} | parts)
    if variants:
        a.line(f"along {parameter}, up to {until_phi:.4g} rad of the rotor's angle", "")
    for k, c in enumerate(variants):
        a.line(f"  {f'{c.value:.6g}{printed_unit}':<14} ", _comparison_text(c, bodies), at=f"deviations[{k}]")
    ranges = _disagreement_ranges(variants)
    a.number("disagreement", ranges, "ranges in which the outcomes differ", unit)
    for low, high in ranges:
        place = f"at {low:.6g}{printed_unit}" if low == high else f"from {low:.6g} to {high:.6g}{printed_unit}"
        a.line(f"the models have different outcomes {place}", "")
    a.number("speeds_of", bodies, "bodies whose speeds are compared")
    a.number("along_unit", unit, "unit of the varied parameter")
    a.number("amplitude_unit", machine.orbit_unit, "unit of amplitudes")
    a.number("until_phi", until_phi, "angle of the rotor up to which deviations count", "rad")


def _record(c: ModelComparison) -> dict[str, Any]:
    speed, amplitude = c.largest
    outcomes = {"same_outcome": c.same_outcome, "outcome": c.outcome, "slow_outcome": c.slow_outcome}
    return {"speed": speed, "amplitude": amplitude, **outcomes}


def _comparison_text(c: ModelComparison, bodies_text: str) -> str:
    deviation_text = f"speeds of {bodies_text} differ by {{speed}} at most, amplitudes by {{amplitude}}"
    ends = "both {outcome}" if c.same_outcome else "{outcome}, averaged equations {slow_outcome}"
    return f"{'nothing in common' if math.isnan(c.largest[0]) else deviation_text}; {ends}"


def _disagreement_ranges(comparisons: Sequence[ModelComparison]) -> list[list[float]]:
    """Ranges of the parameter with different outcomes, each from its first to its last value."""
    rows = ([c.value for c in row] for differ, row in groupby(comparisons, lambda c: c.same_outcome is False) if differ)
    return [[row[0], row[-1]] for row in rows]


def _trust_verdict(
    machine: Machine, comparisons: Sequence[ModelComparison], order: Errors | str | None
) -> tuple[bool | None, list[str]]:
    """True if the averaged equations may be trusted for the nominal machine, None if undecided; and the reasons against it."""
    if order is None:
        return None, ["the study was interrupted before this was decided"]
    nominal_run, reasons = comparisons[0], list[str]()
    if nominal_run.same_outcome is False:
        reasons.append(f"the full equations end as {nominal_run.outcome}, the averaged ones as {nominal_run.slow_outcome}")
    if math.isnan(nominal_run.relative[0]):
        reasons.append("the runs have no angle of the rotor in common")
    limits = {f"the speeds of {_compared_bodies(machine)}": SPEED_TOLERANCE, "the amplitudes": AMPLITUDE_TOLERANCE}
    for (subject, limit), share in zip(limits.items(), nominal_run.relative, strict=True):
        if share > limit:
            reasons.append(f"{subject} differ by {100 * share:{'.0f' if share >= 0.1 else '.2g'}} % of the largest")
    if isinstance(order, Errors) and order.order < LEAST_ORDER * order.nominal:
        power = f"{order.order:.2g}, not {order.nominal:g}"
        reasons.append(f"their error falls with epsilon to the power {power}: epsilon is not small")
    if reasons:
        return False, reasons
    if nominal_run.same_outcome is None:
        reasons.append("the runs are too short for an outcome; give a longer study.until")
    if isinstance(order, str):
        reasons.append(f"whether the error falls with epsilon could not be measured: {order}")
    return None if reasons else True, reasons
