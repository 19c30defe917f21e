"""What is kept of the runs from the start, so that an interrupted study of entrainment can be gone on with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import Variable, variable
from wucht.studies.entrainment.along import Along
from wucht.studies.entrainment.runs import RunAt

if TYPE_CHECKING:
    import xarray as xr


def kept(machine: Machine, along: Along, runs: Sequence[RunAt]) -> dict[str, Variable]:
    """Variables of the runs, by name.

    Of each (run): run_value, run_taken, run_speed (mean of the main rotor, in magnitude), run_mean_speed (with its sign),
    run_drift, run_until (how long it was asked to be), run_end_time, run_failed (a sentence). run_window (end, run): of the
    means. run_rotor_speed, run_rotor_phase (rotor, run): mean speeds, and phases to the main rotor, of this one to the
    vibration. run_end_state (state, run).
    """
    units, names = machine.units, [r.name for r in machine.rotors]
    angle = "rad" if units.time else ""
    size, count = len(machine.state_names), len(runs)

    def each(values: Sequence[Any]) -> np.ndarray:
        return np.array(values, float)

    speeds = each([[r.speeds.get(n, math.nan) for n in names] for r in runs]).reshape(count, len(names)).T
    phases = each([[r.phases.get(_key(n, names), math.nan) for n in names] for r in runs]).reshape(count, len(names)).T
    return {
        "run_value": variable("run", each([r.value for r in runs]), along.what, along.unit),
        "run_taken": variable("run", np.array([r.taken for r in runs], np.int8), "taken along"),
        "run_speed": variable("run", each([abs(r.mean_speed) for r in runs]), "mean speed", units.speed),
        "run_mean_speed": variable("run", each([r.mean_speed for r in runs]), "mean speed", units.speed),
        "run_drift": variable("run", each([r.drift for r in runs]), "drift of the phase", angle),
        "run_until": variable("run", each([r.until for r in runs]), "time asked for", units.time),
        "run_end_time": variable("run", each([r.end_time for r in runs]), "end", units.time),
        "run_failed": variable("run", np.array([r.failure or "" for r in runs], str), "why the run failed"),
        "run_window": variable(
            "end run", each([r.window for r in runs]).reshape(count, 2).T, "window of the means", units.time
        ),
        "run_rotor_speed": variable("rotor run", speeds, "mean speed", units.speed),
        "run_rotor_phase": variable("rotor run", phases, "phase", angle),
        "run_end_state": variable("state run", each([r.end_state for r in runs]).reshape(count, size).T, "state at the end"),
    }


def _key(name: str, names: Sequence[str]) -> str:
    """Under which the phase of a rotor is kept: that of the main one is its phase to the vibration."""
    return "vibration" if name == names[0] else name


def restored(machine: Machine, earlier: xr.Dataset) -> list[RunAt]:
    """The runs of an earlier result of the same machine."""
    names, found = [r.name for r in machine.rotors], []
    for r in (earlier.isel(run=k) for k in range(earlier.sizes["run"])):
        speeds, phases = r.run_rotor_speed.values.tolist(), r.run_rotor_phase.values.tolist()
        begin, end = r.run_window.values.tolist()
        run = RunAt(
            value=float(r.run_value),
            until=float(r.run_until),
            taken=bool(r.run_taken),
            mean_speed=float(r.run_mean_speed),
            window=(begin, end),
            end_time=float(r.run_end_time),
            end_state=r.run_end_state.values,
            speeds={n: x for n, x in zip(names, speeds, strict=True) if not math.isnan(x)},
            phases={_key(n, names): x for n, x in zip(names, phases, strict=True) if not math.isnan(x)},
            drift=float(r.run_drift),
            failure=str(r.run_failed.values) or None,
        )
        found.append(run)
    return found
