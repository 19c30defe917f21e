"""The residual unbalance over time against the sum of the unbalances as vectors, with the rotor's as its schedule gives it."""

from __future__ import annotations

import numpy as np

import wucht
from wucht.files.building import machine_from

_MASS, _LENGTH, _TIMES, _UNBALANCES = 0.1, 0.1, [0.0, 2.0, 3.0], [0.02, 0.02, 0.008]
_PENDULUM = {"kind": "pendulum", "about": "drum", "mass": _MASS, "length": _LENGTH, "damping": 0.01}
_MACHINE = {
    "carrier": {"mass": 10.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
    "bodies": [
        {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": _UNBALANCES[0], "inertia": 0.05},
        *(_PENDULUM | {"name": name} for name in ("p1", "p2")),
    ],
    "drive": {"on": "drum", "kind": "constant-speed", "speed": 200.0},
    "schedules": [{"parameter": "drum.unbalance", "points": list(zip(_TIMES, _UNBALANCES, strict=True))}],
}  # fmt: skip


def test_it_follows_a_schedule_of_the_rotors_unbalance() -> None:
    result = wucht.run(wucht.RunUp(until=4.0, start={"p1": 2.0, "p2": -2.5}), machine_from(_MACHINE))
    own = np.interp(result["time"].values, _TIMES, _UNBALANCES)
    angles = {name: result["angle"].sel(body=name).values for name in ("drum", "p1", "p2")}
    total = own + _MASS * _LENGTH * sum(np.exp(1j * (angles[name] - angles["drum"])) for name in ("p1", "p2"))
    np.testing.assert_allclose(result["residual_unbalance"], np.abs(total) / own, atol=1e-12)
    assert own.max() > 2 * own.min()
