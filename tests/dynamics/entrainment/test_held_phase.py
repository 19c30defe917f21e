"""EquilibriumContinuation of averaged equations whose first phase is held, in closed form: sin(p) = k (W - w)/T."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase, swept_parameter
from wucht.dynamics.entrainment.entrainment_equations import EntrainmentEquations
from wucht.dynamics.entrainment.existence import Continuation, StableRange, range_around
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine

W, SLOPE, UNBALANCE, AMPLITUDE = 2 * math.pi, 1e-5, 0.1 * 0.01, 1e-3
TORQUE = UNBALANCE * AMPLITUDE * W**2 / 2


def equations(limits: tuple[float, float]) -> EntrainmentEquations:
    machine = load_machine("sperling-vibration/figure-2a").with_values({"drive.no_load_speed": 7.0})
    return EntrainmentEquations(machine, swept_parameter(machine), {"rotor": 1.0}, limits)


@pytest.mark.parametrize("phase", [0.3, 1.2, 2.5, -0.7])
def test_the_value_at_which_a_phase_is_steady(phase: float) -> None:
    of = equations((-50.0, 50.0))
    start = np.where(of.phases, phase, 1.1 * W)[:, None]
    states, values = of.with_fixed_phase(start, 7.0)
    assert values == pytest.approx([W + TORQUE * math.sin(phase) / SLOPE], rel=1e-9)
    assert states[of.phases, 0] == pytest.approx([phase]) and of.speed(states) == pytest.approx([W])
    cosine, inertia = math.cos(phase), of.machine.values["rotor.inertia"]
    exact = np.roots([inertia, SLOPE, TORQUE * cosine])
    assert np.sort_complex(of.eigenvalues(states[:, 0], values[0])) == pytest.approx(np.sort_complex(exact), rel=1e-6)
    assert of.is_stable(states[:, 0], values[0]) is bool(cosine > 0)


def test_equilibria_at_other_values_lie_within_the_limits() -> None:
    """The band is from W - T/k to W + T/k, of which the limits leave the upper half."""
    reach = TORQUE / SLOPE
    continuation: Any = SimpleNamespace(equations=equations((W, W + 0.9 * reach)))
    found = Continuation._equilibria_anywhere(continuation, 7.0)
    values = np.array([value for _, value in found])
    assert len(found) > 1 and (values >= W).all() and (values <= W + 0.9 * reach).all()
    for state, value in found:
        at = float(state[continuation.equations.phases][0])
        assert -math.pi < at <= math.pi and math.sin(at) == pytest.approx(SLOPE * (value - W) / TORQUE, abs=1e-7)


def test_a_detuning_moves_both_motors_in_the_averaged_equations() -> None:
    """Steady speeds of two exciters on motors of the slope k: the sum of their torques vanishes at the mean of their speeds."""
    rotor = {"kind": "rotor", "mass": 1.0, "unbalance": 1e-3, "inertia": 1e-3}
    drives = [{"on": n, "kind": "linear", "slope": 1e-2, "no_load_speed": s} for n, s in (("a", 12.0), ("b", 13.0))]
    machine = machine_from({
        "carrier": {"mass": 5.0, "directions": "x", "stiffness": 5e4, "damping": 1.0},
        "bodies": [rotor | {"name": "a"}, rotor | {"name": "b"}], "drives": drives,
    })  # fmt: skip
    swept = swept_parameter(machine)
    of = EntrainmentEquations(machine, swept, {"a": 1.0, "b": 1.0}, (-2.0, 2.0))
    assert of.unit == 4.0
    states = np.where(of.phases, 0.0, 12.5)[:, None]
    for detuning in (-1.0, 0.5):
        rates, _ = of.rates(states, detuning)
        rate = dict(zip(of.names, rates[:, 0], strict=True))
        inertia = machine.values["a.inertia"]
        scale = of.pace * of.pace
        expected = 1e-2 * detuning / 2 / inertia / scale
        assert rate["b.speed"] - rate["a.speed"] == pytest.approx(2 * expected, rel=1e-3)


@pytest.mark.parametrize(("low", "high"), [(5.0, 6.0), (8.0, 9.0)])
def test_a_range_about_a_band_contains_the_value_of_the_machine(low: float, high: float) -> None:
    """A margin on both sides, a share of all that is shown; within the limits."""
    machine = load_machine("sperling-vibration/figure-2a").with_values({"drive.no_load_speed": 7.0})
    case = EntrainmentCase.of(machine, swept_parameter(machine), {}, 25)
    band = StableRange(0, (low, high), ("fold", "fold"), np.zeros(0, int))
    begin, end = range_around(case, band)
    least, most = min(low, 7.0), max(high, 7.0)
    assert least - begin == pytest.approx(end - most) and 0 < least - begin < most - least
    wide = range_around(case, StableRange(0, (-1e5, 1e5), ("fold", "fold"), np.zeros(0, int)))
    assert wide == case.limits
    assert range_around(case, None) == pytest.approx((0.0, 14.0)), "a hundredth of the limits, or the value itself"
