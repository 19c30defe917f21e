"""Where the signal of a failure is largest, against the balance of torques of a rotor alone: nothing beats there.

On an isotropic carrier, (M, c, k), the vibration brakes a rotor of the unbalance U with c w r^2, where r is its amplitude at w.
"""

from __future__ import annotations

import numpy as np
import pytest

import wucht

MASS, STIFFNESS, DAMPING, UNBALANCE, NO_LOAD, REMAINING = 10.0, 1e5, 60.0, 5e-3, 150.0, 0.9


def exciter(inertia: float, fall: float) -> wucht.Machine:
    p = wucht.parts
    schedule = {"parameter": "carrier.stiffness", "points": [(fall, STIFFNESS), (fall + 1.0, REMAINING * STIFFNESS)]}
    return wucht.Machine(
        p.Carrier(mass=MASS - 5.0, directions="xy", stiffness=STIFFNESS, damping=DAMPING),
        [p.Rotor(name="drum", mass=5.0, unbalance=UNBALANCE, inertia=inertia)],
        [p.LinearDrive(slope=0.004, no_load_speed=NO_LOAD)],
        schedules=[schedule],
    )


def steady_speeds(slope: float, stiffness: float) -> np.ndarray:
    """Speeds at which the drive balances the vibration, ascending; the first one is that of a captured rotor if they are 3."""
    w = np.linspace(1.0, NO_LOAD, 150_001)
    amplitude = UNBALANCE * w**2 / np.hypot(stiffness - MASS * w**2, DAMPING * w)
    surplus = slope * (NO_LOAD - w) - DAMPING * w * amplitude**2
    return np.asarray(w[np.flatnonzero(np.diff(np.sign(surplus)))])


def signals(slope: float) -> tuple[float, float]:
    """Signal of a rotor that remains captured, and of one that passes as the stiffness falls; nan if there is none."""
    before, after = steady_speeds(slope, STIFFNESS), steady_speeds(slope, REMAINING * STIFFNESS)
    return (before[0] - after[0] if len(after) == 3 else np.nan), after[-1] - before[0]


def is_largest_of_what_is_shown(low: float, high: float, inertia: float, fall: float) -> None:
    """With the larger inertia the rotor is captured on its way up, and passes as the stiffness falls, from a slope on."""
    sensor = {"interval": 0.15, "noise": 1.0, "false_alarm_every": 1e5, "change": 3.0}
    keys = {"until": 3 * fall + 6.0, "after": fall - 2.0, "sensor": sensor, "along": "drive.slope", "points": 5}
    result = wucht.run(wucht.FailureDetection(range=(low, high), **keys), exciter(inertia, fall))
    largest = result.wucht.summary["largest"]
    assert largest["signal"] == pytest.approx(np.nanmax(result.signal.values))
    assert all(n["signal"] <= largest["signal"] for n in largest["neighbours"])
    known = np.array([signals(slope) for slope in result.along.values])
    passes = np.abs(result.signal.values - known[:, 1]) < np.abs(np.nan_to_num(result.signal.values - known[:, 0], nan=np.inf))
    assert result.signal.values == pytest.approx(np.where(passes, known[:, 1], known[:, 0]), rel=0.01)
    assert (np.diff(passes.astype(int)) >= 0).all(), "from one slope on it passes"
    slopes = np.linspace(low, high, 400)
    if passes.any():  # the weaker the motor that passes, the better, but for the time that the passage takes
        assert largest["drive.slope"] <= 1.05 * result.along.values[passes].min()
        cliff = largest["cliff"]
        assert (cliff is None) == passes.all() or cliff["value"] < largest["drive.slope"]
        assert cliff is None or cliff["signal"] == pytest.approx(signals(cliff["value"])[0], rel=0.01)
    else:
        remains = np.array([signals(slope)[0] for slope in slopes])
        assert largest["signal"] == pytest.approx(remains.max(), rel=5e-3) and largest["cliff"] is None
        assert signals(largest["drive.slope"])[0] > remains.max() * (1 - 2e-3)


@pytest.mark.slow
def test_the_largest_signal_is_the_known_one() -> None:
    """With a weak motor the speed follows the root of the stiffness, with a strong one it is held back less: between them."""
    is_largest_of_what_is_shown(0.0022, 0.005, 4e-3, 5.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lows", "highs", "inertia", "fall"),
    [((0.002, 0.003), (0.0035, 0.0055), 4e-3, 6.0), ((0.0035, 0.0045), (0.0068, 0.0078), 0.02, 12.0)],
)
def test_ten_ranges_each(lows: tuple[float, float], highs: tuple[float, float], inertia: float, fall: float) -> None:
    """On which the rotor remains captured, and with a slope from which on it passes."""
    random = np.random.default_rng(1)
    for _ in range(10):
        is_largest_of_what_is_shown(random.uniform(*lows), random.uniform(*highs), inertia, fall)
