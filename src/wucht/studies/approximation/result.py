"""The Dataset of the study ``approximation``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import Variable, variable
from wucht.studies.approximation.comparison import CURVE, Comparison, angles
from wucht.studies.approximation.verdict import sentence_of, summary_of
from wucht.studies.attributes import attributes
from wucht.studies.deviations import watched
from wucht.studies.resuming import whole_fingerprint

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.approximation.order import Errors
    from wucht.studies.approximation.study import Approximation

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

    own, compared = (done[0], list(done[1:])) if done else (None, [])
    whose = "the rotor" if machine.rotor in watched(machine) else "the bodies"
    name, unit = _named(machine, question)
    shown = [*compared, *([own] if own is not None else [])]
    found = xr_.Dataset(
        _compared(machine, shown, whose) | _measured(machine, measured, whose),
        coords={
            "value": variable("value", [c.value for c in shown], name, unit),
            "angle": variable("angle", angles(question.until_phi), "angle of the rotor", "rad"),
            "factor": variable("factor", [] if measured is None else measured.factors, "factor of epsilon"),
        },
    )
    summary = summary_of(machine, question, own, compared, measured, unmeasured, whose)
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
        sentence_of(summary),
        warnings,
        begun,
        failures[0] if failures and own is None else None,
        interrupted,
    ) | {"asked": whole_fingerprint(machine, question)}
    return found


def _compared(machine: Machine, shown: Sequence[Comparison], whose: str) -> dict[str, Variable]:
    speed, length = machine.units.speed, machine.orbit_unit
    curves = np.array([c.curves for c in shown]).reshape(len(shown), 2, CURVE)

    def each(values: list[Any], long_name: str, unit: str = "") -> Variable:
        return variable("value", values, long_name, unit)

    return {
        "speed_deviation": each([c.largest[0] for c in shown], f"largest deviation of the speed of {whose}", speed),
        "amplitude_deviation": each([c.largest[1] for c in shown], "largest deviation of the amplitude", length),
        "relative_speed_deviation": each([c.relative[0] for c in shown], f"relative deviation of the speed of {whose}"),
        "relative_amplitude_deviation": each([c.relative[1] for c in shown], "relative deviation of the amplitude"),
        "same_outcome": each([_AS_NUMBER[c.same_outcome] for c in shown], "whether both end alike (-1: unknown)"),
        "outcome": each([c.outcome for c in shown], "outcome of the full equations"),
        "slow_outcome": each([c.slow_outcome for c in shown], "outcome of the slow equations"),
        "failed": each([c.failure for c in shown], "why a run failed"),
        "speed_over_angle": variable("value angle", curves[:, 0], f"deviation of the speed of {whose}", speed),
        "amplitude_over_angle": variable("value angle", curves[:, 1], "deviation of the amplitude", length),
    }


def _measured(machine: Machine, measured: Errors | None, whose: str) -> dict[str, Variable]:
    values = np.empty(0) if measured is None else measured.speed
    return {"error": variable("factor", values, f"error of the speed of {whose}", machine.units.speed)}


def _named(machine: Machine, question: Approximation) -> tuple[str, str]:
    if not question.along:
        return "value", ""
    if len(question.along) == 1:
        path = question.along[0]
        return path, machine.parameters[path].unit
    return f"factor of {' and '.join(question.along)}", ""
