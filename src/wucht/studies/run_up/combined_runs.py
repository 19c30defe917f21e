"""Several run-ups in one answer: both models of one, or many of several initial states or values of a parameter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wucht.dynamics.run_ups.deviations import Deviations, compared_motion, deviations_by_angle, deviations_by_phase
from wucht.dynamics.run_ups.run_up import Motion
from wucht.results.quantities import Quantity, StudyResult, dataset_from_quantities
from wucht.studies.run_up.computation import Plan
from wucht.studies.run_up.figure import mean_phase, rotor_angle

if TYPE_CHECKING:
    import xarray as xr


_COMPARED_VARIABLES = ("angle", "speed", "amplitude", "phase", "rotor_phase", "radius")


def join_models(motions: Sequence[Motion], results: Sequence[StudyResult]) -> StudyResult:
    """Join the full run-up with the averaged one at the same times; of one model alone return its result unchanged.

    Variables slow_angle, slow_speed (body, time), slow_phase (balancer, time), slow_amplitude, slow_radius (time);
    speed_deviation and radius_deviation (compared), at equal angle of the rotor. Summary: ``slow`` and ``deviations``.
    """
    if len(results) == 1:
        return results[0]
    full, slow = results
    failures = [f"averaged equations: {slow.failure}"] if slow.failure else []
    courses = compared_motion(motions[0]), compared_motion(motions[1])
    deviations = {"at_equal_angle": deviations_by_angle(*courses), "at_equal_phase": deviations_by_phase(*courses)}
    quantities = [*full.quantities, *_averaged_variables(full, slow), *_deviations(full, deviations)]
    attributes = {**full.attributes, "model": "both"}
    return replace(full, quantities=quantities, warnings=[*full.warnings, *failures], attributes=attributes)


def _averaged_variables(full: StudyResult, slow: StudyResult) -> list[Quantity]:
    """Return the variables of the averaged equations, padded to the length of the full run-up."""
    slow_by_name = {q.name: q for q in slow.quantities if q.dimensions is not None}
    pairs = [
        (q, slow_by_name[q.name])
        for q in full.quantities
        if q.name in _COMPARED_VARIABLES and q.dimensions is not None and q.name in slow_by_name
    ]
    variables = []
    for q, slow_variable in pairs:
        values, length = np.asarray(slow_variable.value), np.shape(q.value)[-1]
        values = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, length - values.shape[-1])], constant_values=np.nan)
        variables.append(replace(q, name=f"slow_{q.name}", value=values, long_name=f"{q.long_name}, averaged equations"))
    return [*variables, Quantity("slow", slow.summary, "the same of the averaged equations")]


def _deviations(full: StudyResult, deviations: dict[str, Deviations | None]) -> list[Quantity]:
    """Return the deviations of the models over the angle of the rotor; and the largest at equal angle and at equal phase."""
    unit = {q.name: q.unit for q in full.quantities if q.dimensions is not None}
    largest = {k: d and dict(zip(("speed", "amplitude"), d.largest, strict=True)) for k, d in deviations.items()}
    parts = {"speed": ("difference of the speeds", unit["speed"]), "amplitude": ("difference of the distances", unit["radius"])}
    in_summary = Quantity("deviations", largest, "largest differences of the models", parts=parts)
    if (at := deviations["at_equal_angle"]) is None:
        return [in_summary]
    return [
        in_summary,
        Quantity("compared", at.abscissa, "angle of the rotor at which the models are compared", "rad", "compared"),
        Quantity("speed_deviation", at.speed, "speed, full less slow", unit["speed"], "compared"),
        Quantity("radius_deviation", at.radius, "distance of the axis, full less slow", unit["radius"], "compared"),
    ]


_MOST_SAMPLES = 20_000  # of a run
_STORED_VARIABLES = (
    "speed",
    "amplitude",
    "phase",
    "energy_residual",
    "slow_speed",
    "slow_amplitude",
    "abscissa",
    "slow_abscissa",
)


def gather_runs(plan: Plan, results: Sequence[StudyResult], finished_count: int) -> xr.Dataset:
    """Return the runs as one Dataset with the dimension ``case``; its summary has a list ``cases``."""
    import xarray as xr_

    pairs = list(zip(plan.cases, results, strict=False))  # a run may be missing
    cases = [{"label": c.label, "start": dict(c.start), "value": c.value} | a.summary for c, a in pairs]
    reduced_runs = [_reduce_run(dataset_from_quantities(a.quantities), plan.spec.over) for a in results]
    longest = max(r.sizes["sample"] for r in reduced_runs)
    padded_runs = [r.pad(sample=(0, longest - r.sizes["sample"])) for r in reduced_runs]
    result = xr_.concat(padded_runs, dim="case", combine_attrs="override")
    result["time"].attrs = {"long_name": "time", "units": plan.machine.units.time}
    labels = Quantity("case", [c["label"] for c in cases], "case", "", "case")
    result = result.assign_coords(case=labels.variable)
    count = Counter(c["outcome"] for c in cases)
    warnings = [f"{c.label}: {w}" for c, a in pairs for w in a.warnings]
    if finished_count < len(plan.cases):
        warnings.append(f"{finished_count} of {len(plan.cases)} runs are finished")
    outcome = next(iter(count)) if len(count) == 1 and finished_count == len(plan.cases) else None
    parts = {q.name: (q.long_name, q.unit) for q in results[0].quantities if q.dimensions is None or q.in_summary}
    quantities = [
        Quantity("outcome", outcome, "outcome, where all have the same"),
        Quantity("outcomes", dict(count), "number of runs of each outcome"),
        Quantity("along", plan.spec.along, "parameter that differs"),
        Quantity("cases", cases, "the runs", parts=parts),
    ]
    sentence = ", ".join(f"{n} {name}" for name, n in count.most_common())
    failure = next((a.failure for a in results if a.failure), None)
    return StudyResult(quantities, sentence, warnings, (), failure, {"outcome": outcome or "several"}).dataset(result)


def _reduce_run(run: xr.Dataset, over: str) -> xr.Dataset:
    """Reduce a run to a few variables, sampled no more densely than a figure needs, and the figure's abscissa."""
    abscissae = {"phi": ("angle of the rotor", rotor_angle), "psi": ("mean phase of the bodies", mean_phase)}
    for model in ("", "slow_") if "slow_angle" in run else ("",):
        if over in abscissae:
            name, at = abscissae[over]
            run[f"{model}abscissa"] = Quantity("", at(run, model), name, "rad", "time").variable
    samples = run[[n for n in _STORED_VARIABLES if n in run]].isel(
        time=slice(None, None, -(-run.sizes["time"] // _MOST_SAMPLES))
    )
    return samples.rename_dims(time="sample").reset_index("time").reset_coords("time")
