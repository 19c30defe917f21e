"""Both models in one answer, and how far they are apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wucht.dynamics.run_ups.deviations import Deviations, at_equal_angle, at_equal_phase, course_of
from wucht.dynamics.run_ups.run_up import Motion
from wucht.results.quantities import Answer, Quantity

_SHOWN = ("angle", "speed", "amplitude", "phase", "rotor_phase", "radius")


def joined(motions: Sequence[Motion], answers: Sequence[Answer]) -> Answer:
    """The full run-up with the averaged one at the same times; of one model alone its answer as it is. motions: theirs.

    Variables slow_angle, slow_speed (body, time), slow_phase (balancer, time), slow_amplitude, slow_radius (time);
    speed_deviation and radius_deviation (compared), at equal angle of the rotor. Summary: ``slow`` and ``deviations``.
    """
    if len(answers) == 1:
        return answers[0]
    full, slow = answers
    failed = [f"averaged equations: {slow.failure}"] if slow.failure else []
    courses = course_of(motions[0]), course_of(motions[1])
    apart = {"at_equal_angle": at_equal_angle(*courses), "at_equal_phase": at_equal_phase(*courses)}
    quantities = [*full.quantities, *_averaged(full, slow), *_deviations(full, apart)]
    attributes = {**full.attributes, "model": "both"}
    return replace(full, quantities=quantities, warnings=[*full.warnings, *failed], attributes=attributes)


def _averaged(full: Answer, slow: Answer) -> list[Quantity]:
    """What the averaged equations give, padded to the length of the full run-up."""
    own = {q.name: q for q in slow.quantities if q.dimensions is not None}
    shown = [(q, own[q.name]) for q in full.quantities if q.name in _SHOWN and q.dimensions is not None and q.name in own]
    variables = []
    for q, averaged in shown:
        values, length = np.asarray(averaged.value), np.shape(q.value)[-1]
        values = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, length - values.shape[-1])], constant_values=np.nan)
        variables.append(replace(q, name=f"slow_{q.name}", value=values, what=f"{q.what}, averaged equations"))
    return [*variables, Quantity("slow", slow.summary, "the same of the averaged equations")]


def _deviations(full: Answer, apart: dict[str, Deviations | None]) -> list[Quantity]:
    """How far the models are apart, over the angle of the rotor; and at most, at equal angle and at equal phase."""
    unit = {q.name: q.unit for q in full.quantities if q.dimensions is not None}
    largest = {k: d and dict(zip(("speed", "amplitude"), d.largest, strict=True)) for k, d in apart.items()}
    parts = {"speed": ("difference of the speeds", unit["speed"]), "amplitude": ("difference of the distances", unit["radius"])}
    in_summary = Quantity("deviations", largest, "largest differences of the models", parts=parts)
    if (at := apart["at_equal_angle"]) is None:
        return [in_summary]
    return [
        in_summary,
        Quantity("compared", at.at, "angle of the rotor at which the models are compared", "rad", "compared"),
        Quantity("speed_deviation", at.speed, "speed, full less slow", unit["speed"], "compared"),
        Quantity("radius_deviation", at.radius, "distance of the axis, full less slow", unit["radius"], "compared"),
    ]
