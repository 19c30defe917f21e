"""Findings -> the Dataset of an approximation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import Variable, answered, variable
from wucht.studies.approximation.comparison import CURVE, Comparison, angles
from wucht.studies.approximation.prepare import Plan
from wucht.studies.approximation.run import Findings
from wucht.studies.approximation.trust import sentence_of, speeds_of, summary_of

if TYPE_CHECKING:
    import xarray as xr

_AS_NUMBER = {True: 1, False: 0, None: -1}


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """What was compared.

    Variables: speed_deviation, amplitude_deviation, the same relative to the largest of the full run, same_outcome, outcome,
    slow_outcome, failed (value); speed_over_angle, amplitude_over_angle (value, angle), the deviations up to ``until_phi``;
    error (factor), where it was measured. The machine's own values come last, at the value NaN.
    """
    import xarray as xr_

    machine, along, whose = plan.machine, plan.spec.along, speeds_of(plan)
    name, unit = f"factor of {' and '.join(along)}" if along else "value", ""
    if len(along) == 1:
        name, unit = along[0], machine.parameters[along[0]].unit
    shown = [*findings.comparisons[1:], *findings.comparisons[:1]]
    factors, error = (np.empty(0),) * 2 if findings.measured is None else (findings.measured.factors, findings.measured.speed)
    result = xr_.Dataset(
        _compared(machine, shown, whose)
        | {"error": variable("factor", error, f"error of the speed of {whose}", machine.units.speed)},
        coords={
            "value": variable("value", [c.value for c in shown], name, unit),
            "angle": variable("angle", angles(plan.spec.until_phi), "angle of the rotor", "rad"),
            "factor": variable("factor", factors, "factor of epsilon"),
        },
    )
    summary = summary_of(plan, findings)
    warnings = [
        c.failure if math.isnan(c.value) else f"{name} = {c.value:.6g}: {c.failure}" for c in findings.comparisons if c.failure
    ]
    if findings.unmeasured:
        warnings.append(f"the order of the error could not be measured: {findings.unmeasured}")
    if not findings.complete:
        warnings.append(f"{len(findings.along)} of {len(plan.values) - 1} values are compared")
    return answered(result, summary, sentence_of(summary), warnings)


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
