"""Many run-ups in one Dataset: from several initial states, or with several values of a parameter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from wucht.results.quantities import Answer, Quantity
from wucht.studies.run_up.figure import mean_phase, rotor_angle
from wucht.studies.run_up.prepare import Plan

if TYPE_CHECKING:
    import xarray as xr

_MOST_SAMPLES = 20_000  # of a run
_SHOWN = ("speed", "amplitude", "phase", "energy_residual", "slow_speed", "slow_amplitude", "abscissa", "slow_abscissa")


def gathered(plan: Plan, answers: Sequence[Answer], finished: int) -> xr.Dataset:
    """The runs as one Dataset with the dimension ``case``; its summary has a list ``cases``. finished: how many runs are."""
    import xarray as xr_

    pairs = list(zip(plan.cases, answers, strict=False))  # a run may be missing
    cases = [{"label": c.label, "start": dict(c.start), "value": c.value} | a.summary for c, a in pairs]
    reduced = [_reduced(a.dataset(), plan.spec.over) for a in answers]
    longest = max(r.sizes["sample"] for r in reduced)
    padded = [r.pad(sample=(0, longest - r.sizes["sample"])) for r in reduced]
    result = xr_.concat(padded, dim="case", combine_attrs="override")
    result["time"].attrs = {"long_name": "time", "units": plan.machine.units.time}
    labels = Quantity("case", [c["label"] for c in cases], "case", "", "case")
    result = result.assign_coords(case=labels.variable)
    count = Counter(c["outcome"] for c in cases)
    warnings = [f"{c.label}: {w}" for c, a in pairs for w in a.warnings]
    if finished < len(plan.cases):
        warnings.append(f"{finished} of {len(plan.cases)} runs are finished")
    outcome = next(iter(count)) if len(count) == 1 and finished == len(plan.cases) else None
    parts = {q.name: (q.what, q.unit) for q in answers[0].quantities if q.dimensions is None or q.in_summary}
    quantities = [
        Quantity("outcome", outcome, "outcome, where all have the same"),
        Quantity("outcomes", dict(count), "number of runs of each outcome"),
        Quantity("along", plan.spec.along, "parameter that differs"),
        Quantity("cases", cases, "the runs", parts=parts),
    ]
    sentence = ", ".join(f"{n} {name}" for name, n in count.most_common())
    failure = next((a.failure for a in answers if a.failure), None)
    return Answer(quantities, sentence, warnings, (), failure, {"outcome": outcome or "several"}).dataset(result)


def _reduced(run: xr.Dataset, over: str) -> xr.Dataset:
    """What is kept of a run: a few variables, sampled no more densely than a figure shows, and the figure's abscissa."""
    abscissae = {"phi": ("angle of the rotor", rotor_angle), "psi": ("mean phase of the bodies", mean_phase)}
    for model in ("", "slow_") if "slow_angle" in run else ("",):
        if over in abscissae:
            name, at = abscissae[over]
            run[f"{model}abscissa"] = Quantity("", at(run, model), name, "rad", "time").variable
    shown = run[[n for n in _SHOWN if n in run]].isel(time=slice(None, None, -(-run.sizes["time"] // _MOST_SAMPLES)))
    return shown.rename_dims(time="sample").reset_index("time").reset_coords("time")
