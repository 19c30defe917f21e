"""Two rotors that turn at different speeds: each vibrates the linear carrier as if it were alone (superposition).

Closed form for each direction: z = U w^2/(k - m w^2 + i c w), and the place is the sum of Re[z exp(i angle)] over the rotors,
the velocity that of Re[i w z exp(i angle)], where y lags x by a quarter turn in the sense of the rotor.
"""

from __future__ import annotations

import numpy as np
import pytest

from wucht import CoastDown, run
from wucht.files.building import machine_from

MASS, DAMPING, STIFFNESS = 20.0, np.array([4.0, 2.5]), 20.0 * np.array([30.0, 47.0]) ** 2
UNBALANCES, SPEEDS, ANGLES = (2e-3, 3e-3), (40.0, -70.0), (0.3, 1.0)


def test_a_carrier_that_starts_in_the_vibration_of_both_rotors_has_no_transient() -> None:
    """Each speed with its own response: after 0.2 s, when a free vibration would hardly have decayed, the sum still holds."""
    rotors = [
        {"kind": "rotor", "name": name, "mass": 1.0, "unbalance": u, "inertia": 1e7}
        for name, u in zip("ab", UNBALANCES, strict=True)
    ]
    carrier = {"mass": MASS - 2, "stiffness": STIFFNESS.tolist(), "damping": DAMPING.tolist(), "gravity": 0.0}
    start = {name: {"speed": w, "angle": a} for name, w, a in zip("ab", SPEEDS, ANGLES, strict=True)}
    machine = machine_from({"carrier": carrier, "bodies": rotors})
    result = run(CoastDown(until=0.2, start=start, bodies="held", vibration="steady"), machine)
    end = dict(zip(machine.state_names, result.end_state.values.tolist(), strict=False))  # works come last
    place, velocity = np.zeros(2), np.zeros(2)
    for u, w, a in zip(UNBALANCES, SPEEDS, ANGLES, strict=True):
        turning = np.array([1.0, -1j * np.sign(w)]) * np.exp(1j * (abs(w) * 0.2 + np.sign(w) * a))
        z = u * w**2 / (STIFFNESS - MASS * w**2 + 1j * DAMPING * abs(w)) * turning
        place, velocity = place + z.real, velocity + (1j * abs(w) * z).real
    assert [end["carrier.x"], end["carrier.y"]] == pytest.approx(place.tolist(), rel=1e-5)
    assert [end["carrier.vx"], end["carrier.vy"]] == pytest.approx(velocity.tolist(), rel=1e-5)
