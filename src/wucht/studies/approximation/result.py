"""The Dataset of the study ``approximation``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import variable
from wucht.results.store import to_json
from wucht.studies.approximation.comparison import CURVE, Comparison, angles
from wucht.studies.attributes import attributes
from wucht.studies.deviations import watched
from wucht.studies.resuming import fingerprint

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.approximation.order import Errors
    from wucht.studies.approximation.study import Approximation

TRUSTED = 0.05  # of the largest speed up to until_phi: a deviation beyond it is not small
AMPLITUDE_TRUSTED = 0.25  # of the largest amplitude: that of a carrier that starts at rest is not in the slow equations
LEAST_ORDER = 0.7  # of the nominal order: below, epsilon is not small enough for the error to fall with it
_AS_NUMBER = {True: 1, False: 0, None: -1}


def result(
    machine: Machine,
    question: Approximation,
    done: Sequence[Comparison],
    measured: Errors | None,
    begun: float,
    interrupted: bool,
    unmeasured: str = "",
) -> xr.Dataset:
    """What was compared. The first comparison is of the machine's own values. unmeasured: why there is no order of the error.

    Variables: speed_deviation, amplitude_deviation, the same relative to the largest of the full run, same_outcome, outcome,
    slow_outcome, failed (value); speed_over_angle, amplitude_over_angle (value, angle), the deviations up to ``until_phi``;
    error (factor), where it was measured. The machine's own values come last.
    """
    import xarray as xr_

    own = done[0] if done else None
    compared, units = list(done[1:]), machine.units
    name, unit = _named(machine, question)
    shown = [*compared, *([own] if own is not None else [])]
    whose = "the rotor" if machine.rotor in watched(machine) else "the bodies"
    curves = np.array([c.curves for c in shown]).reshape(len(shown), 2, CURVE)
    found = xr_.Dataset(
        {
            "speed_deviation": variable(
                "value", [c.largest[0] for c in shown], f"largest deviation of the speed of {whose}", units.speed
            ),
            "amplitude_deviation": variable(
                "value", [c.largest[1] for c in shown], "largest deviation of the amplitude", machine.orbit_unit
            ),
            "relative_speed_deviation": variable(
                "value", [c.relative[0] for c in shown], f"relative deviation of the speed of {whose}"
            ),
            "relative_amplitude_deviation": variable(
                "value", [c.relative[1] for c in shown], "relative deviation of the amplitude"
            ),
            "same_outcome": variable(
                "value", [_AS_NUMBER[c.same_outcome] for c in shown], "whether both end alike (-1: unknown)"
            ),
            "outcome": variable("value", [c.outcome for c in shown], "outcome of the full equations"),
            "slow_outcome": variable("value", [c.slow_outcome for c in shown], "outcome of the slow equations"),
            "failed": variable("value", [c.failure for c in shown], "why a run failed"),
            "speed_over_angle": variable("value angle", curves[:, 0], f"deviation of the speed of {whose}", units.speed),
            "amplitude_over_angle": variable("value angle", curves[:, 1], "deviation of the amplitude", machine.orbit_unit),
            "error": variable(
                "factor", [] if measured is None else measured.speed, f"error of the speed of {whose}", units.speed
            ),
        },
        coords={
            "value": variable("value", [c.value for c in shown], name, unit),
            "angle": variable("angle", angles(question.until_phi), "angle of the rotor", "rad"),
            "factor": variable("factor", [] if measured is None else measured.factors, "factor of epsilon"),
        },
    )
    summary = _summary(machine, question, own, compared, measured, unmeasured, whose)
    failures = [c.failure for c in done if c.failure]
    warnings = [f"{name} = {c.value:.6g}: {c.failure}" if math.isfinite(c.value) else c.failure for c in done if c.failure]
    if interrupted:
        warnings.append(f"interrupted after {len(compared)} of {len(question.values)} comparisons; --resume goes on")
        summary |= {"trusted": None, "reasons": ["it was interrupted before this was decided"]}
    elif unmeasured:
        warnings.append(f"the order of the error could not be measured: {unmeasured}")
    found.attrs = attributes(
        machine,
        question,
        summary,
        _sentence(summary),
        warnings,
        begun,
        failures[0] if failures and own is None else None,
        interrupted,
    ) | {"asked": asked(machine, question)}
    return found


def asked(machine: Machine, question: Approximation) -> str:
    """What an interrupted study must agree in to be gone on with."""
    return fingerprint(machine, [to_json(asdict(question), indent=None)])


def _named(machine: Machine, question: Approximation) -> tuple[str, str]:
    if not question.along:
        return "value", ""
    if len(question.along) == 1:
        path = question.along[0]
        return path, machine.parameters[path].unit
    return f"factor of {' and '.join(question.along)}", ""


def _summary(
    machine: Machine,
    question: Approximation,
    own: Comparison | None,
    compared: Sequence[Comparison],
    measured: Errors | None,
    unmeasured: str,
    whose: str,
) -> dict[str, Any]:
    key = question.along[0] if len(question.along) == 1 else "factor"
    found: dict[str, Any] = {
        "along": list(question.along) if len(question.along) != 1 else question.along[0],
        "deviations": [{key: c.value} | _told(c) for c in compared],
        "own": None if own is None else _told(own),
        "disagreement": _regions(compared),
        "errors": None if measured is None else dict(zip(map(str, measured.factors), measured.speed, strict=True)),
        "order_of_error": None if measured is None or math.isinf(measured.order) else measured.order,
        "nominal_order": None if measured is None else measured.nominal,
        "speeds_of": whose,
        "along_unit": _named(machine, question)[1],
        "amplitude_unit": machine.orbit_unit,
        "until_phi": question.until_phi,
    }
    doubts, undecided = _doubts(own, measured, whose), _undecided(own, unmeasured)
    trusted = False if doubts else None if undecided else True
    return found | {"trusted": trusted, "reasons": doubts or undecided}


def _told(c: Comparison) -> dict[str, Any]:
    speed, amplitude = (x if math.isfinite(x) else None for x in c.largest)
    return {
        "speed": speed,
        "amplitude": amplitude,
        "same_outcome": c.same_outcome,
        "outcome": c.outcome,
        "slow_outcome": c.slow_outcome,
    }


def _regions(compared: Sequence[Comparison]) -> list[list[float]]:
    """Ranges of the parameter, from the first to the last value of each row of values with different outcomes."""
    regions: list[list[float]] = []
    before = True
    for c in compared:
        if c.same_outcome is False:
            regions = [*regions[:-1], [regions[-1][0], c.value]] if not before else [*regions, [c.value, c.value]]
        before = c.same_outcome is not False
    return regions


def _doubts(own: Comparison | None, measured: Errors | None, whose: str) -> list[str]:
    """Why the slow equations may not be trusted for the machine as it is."""
    if own is None:
        return []
    said = []
    if own.same_outcome is False:
        said.append(f"the full equations end {own.outcome}, the slow ones {own.slow_outcome}")
    whole = {f"the speeds of {whose}": TRUSTED, "the amplitudes": AMPLITUDE_TRUSTED}
    if math.isnan(own.relative[0]):
        said.append("they share no angle")
    said += [
        f"{what} differ by {_percent(apart)} of the largest"
        for (what, limit), apart in zip(whole.items(), own.relative, strict=True)
        if apart > limit
    ]
    if measured is not None and measured.order < LEAST_ORDER * measured.nominal:
        said.append(
            f"their error falls with epsilon to the power {measured.order:.2g}, not {measured.nominal:g}: epsilon is not small"
        )
    return said


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def _undecided(own: Comparison | None, unmeasured: str) -> list[str]:
    """Why nothing can be said."""
    if own is None:
        return ["nothing was compared"]
    said = []
    if own.same_outcome is None:
        said.append("the runs are too short to tell an outcome; give a longer study.until")
    if unmeasured:
        said.append(f"whether the error falls with epsilon could not be measured: {unmeasured}")
    return said


def _sentence(summary: dict[str, Any]) -> str:
    if summary["trusted"]:
        return "the slow equations may be trusted for this machine"
    if summary["trusted"] is None:
        return f"not decided whether the slow equations may be trusted: {'; '.join(summary['reasons'])}"
    return f"the slow equations are not to be trusted for this machine: {'; '.join(summary['reasons'])}"
