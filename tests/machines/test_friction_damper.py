"""Friction dampers: the loss of a cycle and the decay of a vibration in closed form, sticking, free travel."""

import numpy as np
import pytest

from witness import energy_gap, moved

ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.03}
DAMPER = {"kind": "friction-damper", "name": "damper", "angle": 0.0, "force": 40.0}


@pytest.mark.parametrize("frequency", [3.0, 70.0])
@pytest.mark.parametrize(("travel", "build_up"), [(None, 1e-3), (3e-3, 1e-3)])
def test_the_loss_of_a_cycle(travel: float | None, build_up: float, frequency: float) -> None:
    """4 F (a - g - d tanh((a - g)/d)) at any frequency; a is the stroke along the line, which lies at 60 degrees."""
    a = 0.01 * np.cos(np.pi / 3)
    motion = {"direction": "x", "amplitude": 0.01, "frequency": frequency}
    damper = DAMPER | {"angle": "60 deg", "build_up": build_up} | ({} if travel is None else {"free_travel": travel})
    machine = {"carrier": {"directions": "x", "motion": motion}, "bodies": [ROTOR], "attachments": [damper]}
    rows = moved(machine, grid=np.arange(5) * 2 * np.pi / frequency)
    left = a - (travel or 0.0)
    loss = 4 * 40.0 * (left - build_up * np.tanh(left / build_up))
    assert np.diff(rows["dissipated_work"])[1:] == pytest.approx([loss] * 3, rel=1e-7)
    assert energy_gap(rows) < 1e-9


def test_a_vibration_decays_by_a_straight_line() -> None:
    """By 4 F/k a cycle, the amplitudes of a mass on a spring with dry friction; every half cycle at zero speed."""
    carrier = {"mass": 3.0, "directions": "x", "stiffness": 2e4}
    document = {"carrier": carrier, "bodies": [ROTOR], "attachments": [DAMPER | {"force": 10.0, "build_up": 1e-6}]}
    cycle = 2 * np.pi * np.sqrt(5.0 / 2e4)
    rows = moved(document, {"carrier": {"x": 0.02}}, np.arange(8) * cycle)
    assert rows["carrier.x"] == pytest.approx(0.02 - 4 * 10.0 / 2e4 * np.arange(8), abs=3e-6)
    assert energy_gap(rows) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "friction"), [(1.5, 0.3), (0.7, 0.4)])
def test_forced_vibration_with_dry_friction(ratio: float, friction: float) -> None:
    """J. P. Den Hartog, Trans. ASME 53 (1931) APM-53-9, 107-115: x_0 = (P/k) sqrt(V^2 - (F/P)^2 H^2) of steady motion
    without stops, V = 1/(1 - b^2), H = sin(pi/b)/(b (1 + cos(pi/b))), b the frequency by the natural one.

    The force turns over late by a time that goes with the square root of the build-up, and so does what is missing.
    """
    natural = np.sqrt(2e4 / 5.0)
    load = 2.0 * 1e-3 * (ratio * natural) ** 2
    v, angle = 1 / (1 - ratio**2), np.pi / ratio
    h = np.sin(angle) / (ratio * (1 + np.cos(angle)))

    def amplitude(build_up: float) -> float:
        document = {
            "carrier": {"mass": 3.0, "directions": "x", "stiffness": 2e4},
            "bodies": [ROTOR | {"eccentricity": 1e-3}],
            "drive": {"kind": "constant-speed", "speed": ratio * natural},
            "attachments": [DAMPER | {"force": friction * load, "build_up": build_up}],
        }
        return float(np.abs(moved(document, grid=np.linspace(0.0, 12.0, 12001))["carrier.x"][-2000:]).max())

    coarse, fine = amplitude(1e-6), amplitude(1e-7)
    expected = load / 2e4 * np.sqrt(v**2 - friction**2 * h**2)
    assert fine == pytest.approx(expected, rel=1.5e-2)
    assert fine + (fine - coarse) / (np.sqrt(10) - 1) == pytest.approx(expected, rel=3e-3)


def test_it_holds_what_pulls_with_less_than_its_force() -> None:
    """A spring pulls with half of it: the carrier gives way by a few d, and stays."""
    carrier = {"mass": 3.0, "directions": "x", "stiffness": 2e4, "damping": 60.0}
    document = {"carrier": carrier, "bodies": [ROTOR], "attachments": [DAMPER | {"build_up": 1e-5}]}
    rows = moved(document, {"carrier": {"x": 1e-3}}, np.linspace(0.0, 4.0, 41))
    assert np.ptp(rows["carrier.x"][20:]) < 1e-9
    assert 0 < 1e-3 - rows["carrier.x"][-1] < 5e-5
    assert -40.0 * rows["damper.lining"][-1] / 1e-5 == pytest.approx(2e4 * rows["carrier.x"][-1], rel=1e-6)
