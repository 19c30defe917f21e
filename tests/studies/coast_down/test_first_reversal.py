"""The first reversal falls on a breakpoint: the load of a fan, k w abs(w), has another formula on either side of standstill."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wucht import CoastDown, run
from wucht.files.building import machine_from

UNBALANCE, INERTIA, LOSS, FAN, GRAVITY = 0.03, 0.07, 3e-3, 5e-4, 9.81
WHEEL = {
    "carrier": {"directions": "fixed", "gravity": GRAVITY},
    "bodies": [
        {"kind": "rotor", "name": "fan", "mass": 5.0, "unbalance": UNBALANCE, "inertia": INERTIA, "bearing_damping": LOSS},
    ],
    "drive": {"on": "fan", "kind": "linear", "slope": 0.05, "no_load_speed": 100.0},
    "loads": [{"on": "fan", "kind": "quadratic", "coefficient": FAN}],
}  # fmt: skip
ROLLER = {"kind": "roller", "about": "fan", "mass": 0.2, "track_radius": 0.12, "radius": 0.02, "damping": 2e-3}


def own_reversal(speed: float) -> float:
    """By DOP853 alone, in steps short against a turn."""

    def rates(_: float, y: np.ndarray) -> list[float]:
        angle, w = y
        return [w, (-UNBALANCE * GRAVITY * np.cos(angle) - LOSS * w - FAN * w * abs(w)) / INERTIA]

    def turning(_: float, y: np.ndarray) -> float:
        return float(y[1])

    turning.terminal = True  # type: ignore[attr-defined]
    own = solve_ivp(rates, (0, 60), [0.0, speed], "DOP853", rtol=1e-11, atol=1e-11, max_step=0.05, events=turning)
    return float(own.t_events[0][0])


@pytest.mark.parametrize("speed", [36.339, 30.0, 160.0])
def test_a_fan_wheel_turns_back_when_it_stops(speed: float) -> None:
    """36.339 rad/s: at 24.929 s, not with the swing after next, at 51.07 s."""
    result = run(CoastDown(start={"fan": {"speed": speed}}, until=60.0), machine_from(WHEEL))
    assert result.wucht.summary["reversal_time"] == pytest.approx(own_reversal(speed), abs=1e-6)


def test_the_reversal_does_not_depend_on_the_end_of_the_run() -> None:
    """With two rollers, whose samples lie elsewhere with each end."""
    machine = machine_from(WHEEL | {"bodies": [*WHEEL["bodies"], ROLLER | {"name": "r1"}, ROLLER | {"name": "r2"}]})
    start = {"fan": {"speed": 36.0}, "r1": 0.4, "r2": 2.5}
    times = [run(CoastDown(start=start, until=until), machine).wucht.summary["reversal_time"] for until in (40.0, 47.3)]
    assert times == pytest.approx(times[:1] * len(times), abs=1e-6)
