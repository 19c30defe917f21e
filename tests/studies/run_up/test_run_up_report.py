"""The lines of a run-up that cheap runs do not come to: of many cases, of both models, of several rotors."""

from __future__ import annotations

import math
from typing import Any

import pytest
import xarray as xr
from tests.hand_made import answered, five_functions, titled

STUDY = five_functions("run-up")
ENDED = {"outcome": "passed", "final_speed": 10.0, "final_amplitude": 2e-3, "amplitude_unit": "m"}
SINGLE: dict[str, Any] = ENDED | {
    "sentence": "it passes", "modulation_period": None, "min_speed": None, "max_speed": None, "free_speed": None,
    "natural_frequencies": {}, "peak_amplitude": 3e-3, "final_phases": {}, "final_residual_unbalance": None,
    "settling_time": None, "modulation_period_phi": None, "modulation_depth": None, "dimensionless": {},
    "energy_residual": None,
}  # fmt: skip
SPEED = "10 rad/s (95 rpm)"


def lines(dimensionless: bool = False, /, **summary: Any) -> list[str]:
    made = answered(xr.Dataset(), summary, dimensionless=dimensionless)
    told: list[str] = STUDY.report(titled(made, dimensionless))
    return told


def single(**other: Any) -> list[str]:
    """The lines below title and verdict."""
    told = lines(**SINGLE | other)
    assert told[:2] == ["A machine", "verdict: PASSED: it passes"]
    return told[2:]


def test_a_line_a_case() -> None:
    cases = [ENDED | {"label": "p1 = 1"}, ENDED | {"label": "p1 = 20", "outcome": "captured", "final_speed": 5.0}]
    assert lines(cases=cases, outcomes={"passed": 1, "captured": 1}) == [
        "A machine",
        "verdict: 1 passed, 1 captured",
        f"  p1 = 1   passed               {SPEED}, amplitude 2 mm",
        "  p1 = 20  captured             5 rad/s (48 rpm), amplitude 2 mm",
    ]
    assert lines(cases=[], outcomes={"passed": 0}) == ["A machine", "verdict: 0 passed"]
    turned = lines(cases=[ENDED | {"label": "a", "amplitude_unit": "rad", "final_amplitude": 0.5}], outcomes={"passed": 1})
    assert turned[2] == f"  a  passed               {SPEED}, amplitude {math.degrees(0.5):.4g}°"


def test_two_lines_a_case_of_both_models() -> None:
    slow = ENDED | {"outcome": "captured", "final_speed": 5.0}
    first = ENDED | {"label": "a", "slow": slow, "deviations": {"at_equal_angle": {"speed": 5.0, "amplitude": 1e-3}}}
    second = ENDED | {"label": "b", "slow": slow, "deviations": {"at_equal_angle": None}}
    head = "  a" + 19 * " "
    assert lines(cases=[first, second], outcomes={"passed": 2})[2:] == [
        f"{head}  passed               {SPEED}, amplitude 2 mm",
        "    averaged equations  captured             5 rad/s (48 rpm), amplitude 2 mm; deviation 5 rad/s (48 rpm), 1 mm at "
        "most",
        f"{head.replace('a', 'b')}  passed               {SPEED}, amplitude 2 mm",
        "    averaged equations  captured             5 rad/s (48 rpm), amplitude 2 mm",
    ]


def test_the_fewest_lines() -> None:
    assert single() == [f"  speed        {SPEED}", "  amplitude    2 mm at the end, 3 mm at most"]


def test_both_models_of_one_run() -> None:
    slow = ENDED | {"outcome": "captured", "final_speed": 5.0}
    apart = {"at_equal_time": {"speed": 5.0, "amplitude": 1e-3}, "at_equal_angle": None}
    assert single(slow=slow, deviations=apart)[2:] == [
        "  slow         captured, 5 rad/s (48 rpm), amplitude 2 mm",
        "  deviation    speed 5 rad/s (48 rpm), amplitude 1 mm at most, at equal time",
    ]


def test_mean_speeds_of_several_rotors() -> None:
    assert single(mean_speeds={"a": 10.0, "b": 5.0})[1] == f"  mean speeds  a {SPEED}, b 5 rad/s (48 rpm)"
    assert single(mean_speeds={"a": 10.0}) == single()


def test_phases_natural_frequencies_and_what_is_left() -> None:
    told = single(
        rotor_phases={"e2": math.pi}, natural_frequencies={"x": 10.0}, final_phases={"p1": -0.5 * math.pi},
        final_residual_unbalance=0.12345, energy_residual=1.5e-9, dimensionless={"u": 0.123456}, free_speed=5.0,
    )  # fmt: skip
    assert told == [
        f"  speed        {SPEED} of 5 rad/s (48 rpm) without vibration",
        "  phase        e2 180.0°",
        f"  resonance    x: {SPEED}",
        "  amplitude    2 mm at the end, 3 mm at most",
        "  phases       p1 -90.0°",
        "  unbalance    12.3 % of the rotor's remains",
        "  in numbers   u 0.1235",
        "  energy       balance closed to 1.5e-09",
    ]


def test_without_balancing_bodies_no_unbalance_remains() -> None:
    """The whole unbalance of an exciter remains because nothing is there to compensate it."""
    assert single(final_residual_unbalance=1.0, final_phases={}) == single()


def test_a_rotor_that_vibration_sustains_has_no_speed_without_it() -> None:
    assert single(free_speed=0.0) == single()
    assert single(free_speed=-5.0)[0] == f"  speed        {SPEED} of -5 rad/s (-48 rpm) without vibration"


@pytest.mark.parametrize(("depth", "more"), [(None, ""), (0.025, ", +-2.5 % of the speed averaged over turns")])
def test_a_modulated_run(depth: float | None, more: str) -> None:
    told = single(
        modulation_period=1.5, modulation_period_phi=20 * math.pi, min_speed=5.0, max_speed=10.0, modulation_depth=depth
    )
    assert told[0] == f"  speed        {SPEED}, modulated, between 5 rad/s (48 rpm) and {SPEED}"
    assert told[2:] == [f"  modulation   period 1.5 s, 10 turns{more}"]
    plain = lines(True, **SINGLE | {"settling_time": 1.5, "amplitude_settling_time": 1.0, "dimensionless": {"u": 1.0}})
    assert plain[2:] == ["  speed        10", "  amplitude    0.002 at the end, 0.003 at most", "  settled at   1.5"]


@pytest.mark.parametrize(
    ("amplitude", "line"),
    [
        (None, "1.5 s, the speed"), (1.5, "1.5 s"), (1.25, "1.5 s"), (2.5, "1.5 s; the amplitude at 2.5 s"),
    ],
)  # fmt: skip
def test_when_it_has_settled(amplitude: float | None, line: str) -> None:
    assert single(settling_time=1.5, amplitude_settling_time=amplitude)[2] == f"  settled at   {line}"


FELT: dict[str, Any] = {
    "stroke": 8e-3, "throw_ratio": 0.25, "throw_direction": math.pi / 4, "machine_number": 3.456, "acceleration": 33.87654,
    "bearing_force": 999.96,
}  # fmt: skip


def felt(**other: Any) -> list[str]:
    return single(**FELT | other)[2:]


def test_what_the_vibration_is_to_the_machine() -> None:
    assert felt() == [
        "  stroke       8 mm peak to peak at 45.0°, 2 mm across",
        "  acceleration 33.88 m/s², machine number 3.46",
        "  force        1000 N at most, of the bodies on the carrier",
    ]
    assert felt(bearing_force=1000.0)[2] == "  force        1 kN at most, of the bodies on the carrier"
    assert felt(throw_ratio=0.5)[0] == "  stroke       8 mm peak to peak at 45.0°, 4 mm across"
    assert felt(throw_ratio=0.5, throw_direction=None)[0] == "  stroke       8 mm peak to peak, 4 mm across"
    assert felt(throw_ratio=0.98)[0] == "  stroke       8 mm peak to peak on a circle"
    thrown = "; throw number 2.34 of a deck at 20°"
    assert felt(deck=math.radians(20), throw_number=2.3449)[1] == f"  acceleration 33.88 m/s², machine number 3.46{thrown}"


def test_what_is_gentle_is_left_out_but_on_a_deck() -> None:
    assert felt(machine_number=0.049) == [] and felt(stroke=None) == []
    assert len(felt(machine_number=0.05)) == 3
    assert len(felt(machine_number=0.049, deck=0.5, throw_number=0.1)) == 3


def bearings(steady: dict[str, float], **more: Any) -> list[str]:
    largest, peak = ({n: k * f for n, f in steady.items()} for k in (1.1, 2.0))
    return felt(steady_bearing_forces=steady, bearing_forces=largest, peak_bearing_forces=peak, **more)


def test_the_bearing_forces_of_many_rotors() -> None:
    some = {f"r{k}": 100.0 * (1 + k % 4) for k in range(8)}
    listing = ", ".join(f"r{k} {f:.0f} N ({1.1 * f:.0f} N at most)" for k, f in enumerate(some.values()) if k not in (0, 4))
    assert bearings(some)[3:] == [f"  bearings     {listing} at the end; 2 smaller ones; 800 N at most in the whole run"]
    two = {"r0": 2500.0, "r1": 10.0}
    line = "r0 2.5 kN (2.75 kN at most), r1 10 N (11 N at most) at the end; 5 kN at most in the whole run"
    assert bearings(two)[3:] == [f"  bearings     {line}"]
    assert len(bearings(two, machine_number=0.049)) == 0


def test_one_bearing_is_listed_with_its_life() -> None:
    one = {"r0": 2500.0}
    assert len(bearings(one)) == 3, "the force on the carrier is that of its bearing"
    shown = bearings(one, bearing_life={"r0": 1234.56}, equivalent_bearing_loads={"r0": 2600.0}, machine_number=0.0)
    assert shown == [
        "  bearings     r0 2.5 kN (2.75 kN at most) at the end; 5 kN at most in the whole run",
        "  bearing life r0 1235 h under 2.6 kN (ISO 281, nine of ten)",
    ]
    for life, load, text in ((1e7, 1.0, "more than 1e+07 h"), (None, 0.0, "has no load"), (None, None, "does not turn")):
        shown = bearings(one, bearing_life={"r0": life}, equivalent_bearing_loads={"r0": load})
        assert shown[-1] == f"  bearing life r0 {text} (ISO 281, nine of ten)"


def test_of_many_bearings_the_shortest_lives_are_listed() -> None:
    lives, loads = {f"r{k}": 900.0 - 100 * k for k in range(8)}, {f"r{k}": 10.0 for k in range(8)}
    shown = bearings(dict(loads), bearing_life=lives, equivalent_bearing_loads=loads)[-1]
    assert "r0 " not in shown and "r1 " not in shown and "r2 700 h under 10 N, " in shown and shown.endswith("; 2 longer ones")
