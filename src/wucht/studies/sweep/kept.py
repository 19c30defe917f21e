"""What is kept of a sweep beside its answer, so that an interrupted one can be gone on with."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.results.conventions import Variable, variable
from wucht.results.store import to_json
from wucht.studies.resuming import check_same, whole_fingerprint
from wucht.studies.sweep.flow import Mover, Place, Reading
from wucht.studies.sweep.jumps import Jump

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.sweep.study import Record, Sweep

_READING = {"value": "value", "speed": "speed", "low": "min_speed", "high": "max_speed", "amplitude": "amplitude"}
_READING |= {"energy_residual": "energy_residual"}  # fields of a reading, and the variables that they are kept in


def places(machine: Machine, mover: Mover, record: Record, samples: int) -> dict[str, Variable]:
    """Variables of the places after each leg, NaN where a ramp ended early.

    place_time, place_parameter (direction, sample); place_state (direction, sample, state), the works behind the states;
    place_parameters (direction, sample, run_parameter).
    """
    system, ways = mover.flow.system, list(record.places)
    widths = len(system.states) + len(system.quadratures), len(system.parameter_names)
    shape = (len(ways), samples)
    time, value = (np.full(shape, math.nan) for _ in range(2))
    state, parameters = (np.full((*shape, width), math.nan) for width in widths)
    for i, way in enumerate(ways):
        for k, place in enumerate(record.places[way]):
            time[i, k], value[i, k], state[i, k], parameters[i, k] = place.time, place.value, place.state, place.parameters
    along = machine.parameters[mover.path]
    return {
        "place_time": variable("direction sample", time, "end of the leg", machine.units.time),
        "place_parameter": variable("direction sample", value, f"{along.what} at the end of the leg", along.unit),
        "place_state": variable("direction sample state", state, "state and works at the end of the leg"),
        "place_parameters": variable("direction sample run_parameter", parameters, "run-time parameters there"),
    }


def attributes_of(machine: Machine, question: Sweep, record: Record) -> dict[str, Any]:
    """Attributes that a sweep is gone on with."""
    return {
        "asked": whole_fingerprint(machine, question),
        "complete": to_json(record.complete, indent=None),
        "said": to_json(record.warnings, indent=None),
        "jumps_found": to_json([asdict(j) for j in record.jumps], indent=None),
        "energies": to_json(record.energies, indent=None),
    }


def restore(machine: Machine, question: Sweep, earlier: xr.Dataset, mover: Mover, record: Record) -> None:
    """Put what an earlier result kept into ``mover`` and ``record``. Raises ``InputError`` if it answers another question."""
    check_same(earlier, whole_fingerprint(machine, question), "machine or sweep")
    read = {key: json.loads(earlier.attrs[key]) for key in ("complete", "said", "jumps_found", "energies")}
    mover.scale, mover.stored_at_start = record.energies = tuple(read["energies"])
    record.complete = read["complete"]
    record.warnings = list(dict.fromkeys([*record.warnings, *read["said"]]))
    # Of a ramp whose jumps were not all found, they are looked for again.
    record.jumps = [j for j in map(_jump, read["jumps_found"]) if ("up" if j.upward else "down") in record.complete]
    for way in earlier.direction.values.tolist():
        mine = earlier.sel(direction=way)
        count = int(np.isfinite(mine.place_time.values).sum())
        columns = [mine[name].values[:count].tolist() for name in _READING.values()]
        record.readings[way] = [Reading(**dict(zip(_READING, row, strict=True))) for row in zip(*columns, strict=True)]
        record.places[way] = _places(mine, count)


def _places(ramp: xr.Dataset, count: int) -> list[Place]:
    names: Sequence[str] = ("place_time", "place_parameter", "place_state", "place_parameters")
    rows = zip(*(ramp[name].values[:count] for name in names), strict=True)
    return [Place(float(t), float(v), state, parameters) for t, v, state, parameters in rows]


def _jump(found: dict[str, Any]) -> Jump:
    low, high = found["bracket"]
    return Jump(**(found | {"after": Reading(**found["after"]), "bracket": (low, high)}))
