"""The band of existence of a rotor on a carrier with prescribed vibration, by hand: (21) and (25) of paper 001, and the decay.

On a carrier that vibrates as a cos(w t), a rotor with the unbalance m r and the moment of inertia J about its axis, on a motor
of the slope k, has the averaged equation J p'' + k p' = k (W - w) - T sin(p), T = m r a w^2/2, with its phase p.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase, swept_parameter
from wucht.dynamics.entrainment.entrainment_equations import EntrainmentEquations
from wucht.dynamics.entrainment.existence import (
    Existence,
    StableRange,
    existence,
    range_around,
    threshold,
)
from wucht.dynamics.entrainment.locked_motions import LockedMotions
from wucht.dynamics.entrainment.runs_from_start import RunFromStart, capture_band, values_to_run
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

W, SLOPE, UNBALANCE, AMPLITUDE = 2 * math.pi, 1e-5, 0.1 * 0.01, 1e-3
TORQUE = UNBALANCE * AMPLITUDE * W**2 / 2


def machine(speed: float) -> Machine:
    return load_machine("sperling-vibration/figure-2a").with_values({"drive.no_load_speed": speed})


def case_of(speed: float) -> EntrainmentCase:
    return EntrainmentCase.of(machine(speed), swept_parameter(machine(speed)), {}, 25)


def not_entrained(case: EntrainmentCase) -> RunFromStart:
    return RunFromStart(case.parameter.nominal_value, 1.0, 1.0, case.initial)


def existing(speed: float, sense: float) -> Existence:
    case = case_of(speed)
    return existence(case, not_entrained(case), {"rotor": sense}, Work())


@pytest.mark.parametrize("speed", [5.0, 6.0, 7.9])
def test_the_slowest_decay(speed: float) -> None:
    """J s^2 + k s + T cos(p) = 0 with sin(p) = k (W - w)/T."""
    found, inertia = existing(speed, 1.0), machine(speed).values["rotor.inertia"]
    cosine = math.sqrt(1 - (SLOPE * (speed - W) / TORQUE) ** 2)
    roots = np.roots([inertia, SLOPE, TORQUE * cosine])
    assert found.slowest_rate == pytest.approx(-roots.real.max(), rel=1e-9)
    assert found.slowest_rate > 0


def test_outside_the_band_the_decay_is_that_well_inside() -> None:
    """A tenth of the band from its end."""
    beyond, width = existing(20.0, 1.0), TORQUE / SLOPE
    assert beyond.slowest_rate == pytest.approx(existing(W + 0.8 * width, 1.0).slowest_rate, rel=1e-6)
    assert beyond.phases == {}


@pytest.mark.parametrize("speed", [5.0, 7.9])
def test_clockwise_it_is_the_mirror_image(speed: float) -> None:
    forward, backward = existing(speed, 1.0), existing(-speed, -1.0)
    assert forward.band is not None
    assert backward.band is not None
    width = TORQUE / SLOPE
    assert forward.band.ends == pytest.approx((W - width, W + width), rel=1e-9)
    assert backward.band.ends == pytest.approx((-W - width, -W + width), rel=1e-9)
    assert backward.slowest_rate == pytest.approx(forward.slowest_rate, rel=1e-9)
    assert backward.phases["rotor"] == pytest.approx(forward.phases["rotor"], rel=1e-9), "in its sense"


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_least_amplitude_against_the_drive(sense: float) -> None:
    """(25): k |W - w| = m r a w^2/2."""
    case = case_of(5.0 * sense)
    found = existence(case, not_entrained(case), {"rotor": sense}, Work())
    assert threshold(case, found, Work()) == pytest.approx(2 * SLOPE * (W - 5.0) / (UNBALANCE * W**2), rel=1e-9)


def band(low: float, high: float, kind: str = "fold") -> StableRange:
    return StableRange(0, (low, high), (kind, "range"), np.array([0]))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_below_the_band_the_decay_is_that_well_inside(sense: float) -> None:
    beyond, width = existing(1.0 * sense, sense), TORQUE / SLOPE
    assert beyond.slowest_rate == pytest.approx(existing((W - 0.8 * width) * sense, sense).slowest_rate, rel=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_near_an_edge_the_slower_of_two_decays_counts(sense: float) -> None:
    """There both are real."""
    width, inertia = TORQUE / SLOPE, machine(5.0).values["rotor.inertia"]
    cosine = 0.1 * SLOPE**2 / (4 * inertia * TORQUE)
    found = existing(sense * (W + width * math.sqrt(1 - cosine**2)), sense)
    roots = np.roots([inertia, SLOPE, TORQUE * cosine])
    assert not roots.imag.any()
    assert found.slowest_rate == pytest.approx(-roots.real.max(), rel=1e-3)


@pytest.mark.parametrize("phase", [0.3, 1.2, 2.5, -0.7])
def test_the_value_at_which_a_phase_is_steady(phase: float) -> None:
    of = EntrainmentEquations(machine(7.0), swept_parameter(machine(7.0)), {"rotor": 1.0}, (-50.0, 50.0))
    start = np.where(of.phases, phase, 1.1 * W)[:, None]
    states, values = of.with_fixed_phase(start, 7.0)
    assert values == pytest.approx([W + TORQUE * math.sin(phase) / SLOPE], rel=1e-9)
    assert states[of.phases, 0] == pytest.approx([phase]) and of.speed(states) == pytest.approx([W])
    cosine, inertia = math.cos(phase), of.machine.values["rotor.inertia"]
    exact = np.roots([inertia, SLOPE, TORQUE * cosine])
    assert np.sort_complex(of.eigenvalues(states[:, 0], values[0])) == pytest.approx(np.sort_complex(exact), rel=1e-6)
    assert of.is_stable(states[:, 0], values[0]) is bool(cosine > 0)


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
    case = case_of(7.0)
    band = StableRange(0, (low, high), ("fold", "fold"), np.zeros(0, int))
    begin, end = range_around(case, band)
    least, most = min(low, 7.0), max(high, 7.0)
    assert least - begin == pytest.approx(end - most) and 0 < least - begin < most - least
    wide = range_around(case, StableRange(0, (-1e5, 1e5), ("fold", "fold"), np.zeros(0, int)))
    assert wide == case.limits
    assert range_around(case, None) == pytest.approx((0.0, 14.0)), "a hundredth of the limits, or the value itself"


def entrained(value: float, *bands: tuple[float, float]) -> RunFromStart:
    return RunFromStart(value, 1.0, 1.0, np.zeros(1), is_entrained=any(a <= value <= b for a, b in bands))


def test_the_band_of_the_value_comes_before_the_widest_one() -> None:
    scan = [entrained(float(v), (1.0, 2.0), (4.0, 8.0)) for v in range(11)]
    of_value, widest = capture_band(scan, 1.5), capture_band(scan, 3.0)
    assert of_value is not None and widest is not None
    assert (of_value.brackets, of_value.islands) == (((1.0, 0.0), (2.0, 3.0)), ((4.0, 8.0),))
    assert (widest.brackets, widest.edges, widest.islands) == (((4.0, 3.0), (8.0, 9.0)), (3.5, 8.5), ((1.0, 2.0),))
    assert capture_band([entrained(0.0), entrained(1.0)], 0.0) is None
    whole = capture_band([entrained(0.0, (0.0, 1.0)), entrained(1.0, (0.0, 1.0))], 0.0)
    assert whole is not None and whole.edges == (None, None)


def test_probes_lie_to_both_sides_of_each_edge() -> None:
    """Eight to each side, over the distance of two values of the scan."""
    scan = [entrained(float(v), (3.0, 6.0)) for v in range(11)]
    later = list(values_to_run(scan, 4.0, 1.5))
    expected = [
        edge + side * (k + 0.5) / 8 for edge in (2.5, 6.5) for k in range(8) for side in (-1, 1)
    ]  # 1.5: the brackets of the scan are narrow enough
    assert later == pytest.approx(expected)


@pytest.mark.parametrize(("sense", "time"), [(1.0, 0.0), (1.0, 0.3), (-1.0, 0.3)])
def test_the_phase_of_a_locked_motion(sense: float, time: float) -> None:
    """k (W - w) = T sin(p) to first order, as sigma phi - w t, whenever the period begins."""
    case, phase = case_of(sense * 7.0), math.asin(SLOPE * (7.0 - W) / TORQUE)
    motions = LockedMotions(case, {"rotor": sense}, time)
    machine = case.machine
    guess = np.zeros(len(machine.state_names))
    guess[machine.row(machine.rotor.coordinate.position)] = sense * (W * time + phase)
    guess[machine.row(machine.rotor.coordinate.velocity)] = sense * W
    for row, name in enumerate(machine.state_names):
        if name.startswith("carrier."):
            guess[row] = case.initial[row]
    shake = AMPLITUDE * math.cos(W * time)
    guess[machine.row(machine.carrier[0].position)] = shake
    motion = motions.motion(sense * 7.0, guess, W)
    assert math.remainder(float(motion.phases[0]) - phase, 2 * math.pi) == pytest.approx(0.0, abs=5e-3)
    assert (motion.value, motion.speed) == (sense * 7.0, pytest.approx(W, rel=1e-9)) and motion.stable
    inertia, period = machine.values["rotor.inertia"], 2 * math.pi / W
    roots = np.roots([inertia, SLOPE, TORQUE * math.cos(phase)])
    assert motion.multiplier == pytest.approx(math.exp(roots.real.max() * period), abs=2e-3)
