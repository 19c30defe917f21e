"""What is kept of a coast-down beside its answer, so that an interrupted one can be gone on with."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.numerics.flow.trajectory import Trajectory
from wucht.results.conventions import Variable, variable
from wucht.results.store import to_json
from wucht.studies.coast_down.record import ROW, Record
from wucht.studies.resuming import check_same, whole_fingerprint

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.coast_down.study import CoastDown

_SCALARS = ("legs", "half_time", "reversal_time", "swings", "stride", "stored", "scale")


def ends(record: Record, trajectory: Trajectory) -> dict[str, Variable]:
    """Variables of where it is: end_state (state), parameters_at_end (own), unaveraged (column, left): time, angle, speed."""
    return {
        "end_state": variable("state", trajectory.end_state, "state and accumulated works at the end"),
        "parameters_at_end": variable("own", trajectory.parameters, "run-time parameters at the end"),
        "unaveraged": variable("column left", record.tail, "time, angle and speed of the last turns"),
    }


def attributes_of(machine: Machine, question: CoastDown, record: Record, trajectory: Trajectory) -> dict[str, Any]:
    """Attributes that it is gone on with."""
    scalars = {name: getattr(record, name) for name in _SCALARS} | {"end_time": trajectory.end_time}
    return {"asked": whole_fingerprint(machine, question), "so_far": to_json(scalars, indent=None)}


def restore(machine: Machine, question: CoastDown, earlier: xr.Dataset, record: Record) -> Trajectory | None:
    """Put what an earlier result kept into ``record``. Returns its last sample, None where not even its first leg is whole.

    Raises ``InputError`` if it answers another question.
    """
    check_same(earlier, whole_fingerprint(machine, question), "machine or coast-down")
    so_far = json.loads(earlier.attrs["so_far"])
    if not so_far["legs"]:
        return None
    for name in _SCALARS:
        setattr(record, name, so_far[name])
    record.rows = {name: earlier[name].values.tolist() for name in ROW}
    record.turn_time, record.turn_speed = earlier.turn_time.values.tolist(), earlier.mean_speed.values.tolist()
    record.tail = earlier.unaveraged.values
    state, size = earlier.end_state.values, len(machine.state_names)
    return Trajectory(
        np.array([so_far["end_time"]]),
        state[:size, None],
        {},
        earlier.parameters_at_end.values,
        so_far["end_time"],
        state,
    )
