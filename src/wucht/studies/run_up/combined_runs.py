"""Several runs in one answer: both models of one, or many of several initial states or values of a parameter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from wucht.dynamics.run_ups.deviations import compared_motion, deviations_by_angle, deviations_by_phase
from wucht.dynamics.run_ups.run_up import Motion
from wucht.results.quantities import Quantity
from wucht.studies.answer import Answer

_COMPARED_VARIABLES = ("angle", "speed", "amplitude", "phase", "rotor_phase", "radius")


def state_averaged(a: Answer, motions: Sequence[Motion], slow: Answer) -> None:
    """State the averaged run-up beside the full one, at the same times, and how far they are apart at equal angle and phase.

    Variables slow_angle, slow_speed (body, time), slow_phase (balancer, time), slow_amplitude, slow_radius (time);
    speed_deviation and radius_deviation (compared), at equal angle of the rotor. Summary: ``slow`` and ``deviations``.
    """
    full = {q.name: q for q in a.quantities if q.dimensions is not None}
    slow_by_name = {q.name: q for q in slow.quantities if q.dimensions is not None}
    for name, q in full.items():
        if name in _COMPARED_VARIABLES and name in slow_by_name:
            values = _pad(slow_by_name[name].value, np.shape(q.value)[-1])
            a.add([replace(q, name=f"slow_{name}", value=values, long_name=f"{q.long_name}, averaged equations")])
    a.number("slow", slow.summary, "the same of the averaged equations")
    a.line("slow", f"{slow.summary['outcome']}, {end_in_words(a, slow.summary)}")
    courses, speed, length = (compared_motion(motions[0]), compared_motion(motions[1])), full["speed"].unit, full["radius"].unit
    deviations = {"at_equal_angle": deviations_by_angle(*courses), "at_equal_phase": deviations_by_phase(*courses)}
    largest = {k: d and dict(zip(("speed", "amplitude"), d.largest, strict=True)) for k, d in deviations.items()}
    parts = {"speed": ("difference of the speeds", speed), "amplitude": ("difference of the distances", length)}
    a.number("deviations", largest, "largest differences of the models", parts=parts)
    for name, deviation in largest.items():
        if deviation is not None:
            text = f"speed {{speed}}, amplitude {{amplitude}} at most, {name.replace('_', ' ')}"
            a.line("deviation", text, at=f"deviations.{name}")
    if (at := deviations["at_equal_angle"]) is not None:
        a.curve("compared", at.abscissa, "angle of the rotor at which the models are compared", "rad")
        a.curve("speed_deviation", at.speed, "speed, full less slow", speed, "compared")
        a.curve("radius_deviation", at.radius, "distance of the axis, full less slow", length, "compared")
    a.warn(*([f"averaged equations: {slow.failure}"] if slow.failure else []))
    a.attribute(model="both")


def end_in_words(a: Answer, summary: Mapping[str, Any]) -> str:
    """Return the final speed and amplitude of a run."""
    amplitude = a.number_in_words(summary["final_amplitude"], summary["amplitude_unit"])
    return f"{a.number_in_words(summary['final_speed'], 'speed')}, amplitude {amplitude}"


def _pad(values: Any, length: int) -> np.ndarray:
    """Return an array (..., N), padded with NaN to a length."""
    array = np.asarray(values, float)
    return np.pad(array, [(0, 0)] * (array.ndim - 1) + [(0, length - array.shape[-1])], constant_values=np.nan)


def variables_of_cases(runs: Sequence[Mapping[str, Quantity]], names: Sequence[str], most_samples: int) -> list[Quantity]:
    """Return variables of runs, by name, stacked over the runs: of so many samples each at most, padded with NaN."""
    variables = list[Quantity]()
    for name in (name for name in names if name in runs[0]):
        stretches = [np.asarray(run[name].value)[..., :: -(-len(run["time"].value) // most_samples)] for run in runs]
        longest = max(values.shape[-1] for values in stretches)
        dimensions = f"case {runs[0][name].dimensions}".replace(" time", " sample")
        values = np.stack([_pad(values, longest) for values in stretches])
        variables.append(replace(runs[0][name], value=values, dimensions=dimensions, coordinate=False))
    return variables


def state_cases(
    a: Answer, along: str | None, cases: Sequence[Any], results: Sequence[Answer], finished_count: int, **further_parts: str
) -> None:
    """State many runs, which may be fewer than the cases: how many have which outcome, and the summary of each.

    further_parts: names in words of keys of each that the summary of a run does not have.
    """
    rows = [
        {"label": c.label, "start": dict(c.start), "value": c.value} | r.summary for c, r in zip(cases, results, strict=False)
    ]
    count, is_complete = Counter(row["outcome"] for row in rows), finished_count == len(cases)
    outcome = next(iter(count)) if len(count) == 1 and is_complete else None
    parts = {q.name: (q.long_name, q.unit) for q in results[0].quantities if q.dimensions is None or q.in_summary}
    parts |= {name: (words, "") for name, words in further_parts.items()}
    a.sentence = ", ".join(f"{n} {name}" for name, n in count.most_common())
    a.failure = next((r.failure for r in results if r.failure), None)
    a.attribute(outcome=outcome or "several")
    a.warn(*(f"{c.label}: {w}" for c, r in zip(cases, results, strict=False) for w in r.warnings))
    if not is_complete:
        a.warn(f"{finished_count} of {len(cases)} runs are finished")
    a.number("outcome", outcome, "outcome, where all have the same")
    a.number("outcomes", dict(count), "number of runs of each outcome")
    a.number("along", along, "parameter that differs")
    a.number("cases", rows, "the runs", parts=parts)
