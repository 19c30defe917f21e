"""Many run-ups in one result: from several starts, or with several values of a parameter."""

from __future__ import annotations

import json
import time as clock
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import variable
from wucht.results.store import to_json
from wucht.studies.attributes import attributes
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.resuming import check_same, fingerprint
from wucht.studies.run_up.study import RunUp, single_run_up

if TYPE_CHECKING:
    import xarray as xr

_MOST_SAMPLES = 20_000  # a case
_KEPT = ("speed", "amplitude", "phase", "energy_residual", "slow_speed", "slow_amplitude", "abscissa", "slow_abscissa")


def run_ups(
    machine: Machine,
    question: RunUp,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """A run for each case. Returns a Dataset with the dimension ``case``; its summary has a list ``cases``.

    Runs that were finished when an earlier result was saved are not run again. Raises ``InputError`` as ``run_up`` does.
    """
    begun, cases = clock.perf_counter(), question.cases()
    done = [] if resume is None else _restored(machine, question, resume)
    for k in range(len(done), len(cases)):
        case = cases[k]
        mine = machine if case.along is None else machine.with_values({case.along: case.values[0]})
        share = None if progress is None else _share(progress, k, len(cases))
        run = single_run_up(mine, case, share)
        if not run.attrs["finished"] and not run.attrs["failure"]:
            # The first is shown as far as it came; later ones are given up, as they would be taken for finished.
            return _joined(machine, question, done or [_reduced(run, question.over)], len(done), begun)
        done.append(_reduced(run, question.over))
        if checkpoint is not None and k + 1 < len(cases):
            checkpoint(_joined(machine, question, done, len(done), begun))
    return _joined(machine, question, done, len(done), begun)


def labels_of(question: RunUp) -> list[str]:
    """What distinguishes each case, for a legend: the value of the parameter, the start, or both."""
    found = []
    for case in question.cases():
        value = f"{case.along} = {case.values[0]:.6g}" if case.values else ""
        start = ", ".join(f"{k} = {_shown(v)}" for k, v in case.start.items()) or "at rest"
        found.append("; ".join(part for part in (value, start if question.starts else "") if part))
    return found


def _shown(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k} {_shown(v)}" for k, v in value.items()) + "}"
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)


def _share(progress: Progress, k: int, count: int) -> Progress:
    return lambda reached, goal: progress((k + min(reached / goal, 1.0) if goal else k) / count, 1.0)


def _reduced(run: xr.Dataset, over: str) -> xr.Dataset:
    """What is kept of a run: a few variables, sampled no more densely than a figure shows, and the figure's abscissa."""
    stride = -(-run.sizes["time"] // _MOST_SAMPLES)
    for model in ("", "slow_") if "slow_angle" in run else ("",):
        angle = run[f"{model}angle"]
        rotor = angle.isel(body=0, drop=True)
        if over == "phi":
            turned = (rotor - rotor[0]).assign_attrs(long_name="angle of the rotor", units="rad")
            run = run.assign({f"{model}abscissa": turned})
        if over == "psi":
            mean = angle.sel(body=run.balancer.values).mean(dim="body") - rotor
            run = run.assign({f"{model}abscissa": mean.assign_attrs(long_name="mean phase of the bodies", units="rad")})
    kept = run[[n for n in _KEPT if n in run]].isel(time=slice(None, None, stride))
    kept.attrs = {key: run.attrs[key] for key in ("summary", "outcome", "failure", "warnings")}
    return kept


def _joined(machine: Machine, question: RunUp, runs: Sequence[xr.Dataset], finished: int, begun: float) -> xr.Dataset:
    """The runs as one Dataset, at least one. finished: how many of them are."""
    import xarray as xr_

    cases = question.cases()
    labels = labels_of(question)[: len(runs)]
    padded = [r.drop_vars("time").assign(time_of_case=("time", r.time.values)) for r in runs]
    longest = max(r.sizes["time"] for r in runs)
    padded = [r.pad(time=(0, longest - r.sizes["time"])) for r in padded]
    found = xr_.concat(padded, dim="case", combine_attrs="override").rename({"time": "sample", "time_of_case": "time"})
    found["time"].attrs = {"long_name": "time", "units": machine.units.time}
    found = found.assign_coords(case=variable("case", labels, "case"))
    summaries = [json.loads(r.attrs["summary"]) for r in runs]
    own = [
        {"label": n, "start": dict(c.start), "value": c.values[0] if c.values else None}
        for n, c in zip(labels, cases, strict=False)
    ]
    count = Counter(s["outcome"] for s in summaries)
    sentence = ", ".join(f"{n} {outcome}" for outcome, n in count.most_common())
    interrupted = finished < len(cases)
    failures = [r.attrs["failure"] for r in runs if r.attrs["failure"]]
    warnings = [
        f"{label}: {w}"
        for label, r in zip(labels, runs, strict=True)
        for w in json.loads(r.attrs["warnings"])
        if w not in machine.warnings
    ]
    if interrupted:
        warnings.append(f"interrupted after {finished} of {len(cases)} runs; --resume goes on")
    summary = {
        "outcome": next(iter(count)) if len(count) == 1 and not interrupted else None,
        "outcomes": dict(count),
        "along": question.along,
        "cases": [o | s for o, s in zip(own, summaries, strict=True)],
    }
    found.attrs = attributes(
        machine, question, summary, sentence, warnings, begun, failures[0] if failures else None, interrupted
    ) | {"outcome": summary["outcome"] or "several", "asked": _fingerprint(machine, question), "done": finished}
    return found


def _fingerprint(machine: Machine, question: RunUp) -> str:
    cases = question.cases()
    asked = [[dict(c.start), list(c.values), c.until, c.turns, c.tolerance, c.model, c.inertia, c.order] for c in cases]
    return fingerprint(machine, [question.along, asked])


def _restored(machine: Machine, question: RunUp, earlier: xr.Dataset) -> list[xr.Dataset]:
    """The finished runs of an earlier result. Raises ``InputError`` if it answers another question."""
    check_same(earlier, _fingerprint(machine, question), "machine, starts or values")
    found = []
    for k, summary in enumerate(json.loads(earlier.attrs["summary"])["cases"][: int(earlier.attrs["done"])]):
        own = {key: value for key, value in summary.items() if key not in ("label", "start", "value")}
        run = earlier.isel(case=k).drop_vars("case")
        whole = np.isfinite(run.time.values)
        run = run.rename({"time": "at", "sample": "time"}).isel(time=whole)
        run = run.assign_coords(time=("time", run["at"].values)).drop_vars("at")
        run.attrs = {"summary": to_json(own, indent=None), "outcome": own["outcome"], "failure": "", "warnings": "[]"}
        found.append(run)
    return found
