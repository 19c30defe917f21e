"""The lines of a response that its cheap machines do not come to."""

from __future__ import annotations

from typing import Any

import pytest
import xarray as xr
from tests.hand_made import answered, five_functions, titled, variable

STUDY = five_functions("response")
AT = "10 rad/s (95 rpm)"


def lines(unit: str = "m", dimensionless: bool = False, **other: Any) -> list[str]:
    summary: dict[str, Any] = {
        "sentence": "as by hand", "range": [5.0, 10.0], "critical_speeds": [], "peak_speed": 10.0, "peak_amplitude": 2e-3,
        "bodies": "held", "peaks": [], "free_speed": None, "amplitude_at_free_speed": None, "throw_at_free_speed": None,
        "peak_torque_speed": None, "peak_torque": None, "torque_peaks": [], "self_centring_speed": None,
        "operation": [],
    } | other  # fmt: skip
    made = xr.Dataset({"amplitude": variable("speed", [0.0], "amplitude", unit)})
    told: list[str] = STUDY.report(titled(answered(made, summary, peak_amplitude=unit), dimensionless))
    assert told[:2] == ["A machine", "verdict: as by hand"]
    return told[2:]


def test_the_fewest_lines() -> None:
    assert lines() == [
        f"  range        5 rad/s (48 rpm) to {AT}",
        "  critical     none",
        f"  amplitude    2 mm at most, at {AT}",
    ]
    assert lines(critical_speeds=[5.0, 10.0])[1] == f"  critical     5 rad/s (48 rpm), {AT}"
    assert lines(dimensionless=True)[2] == "  amplitude    0.002 at most, at 10"
    assert lines("rad", peak_amplitude=0.5)[2] == f"  amplitude    28.65° at most, at {AT}"
    assert lines(peak_amplitude=None)[2] == f"  amplitude    infinite at most, at {AT}"


@pytest.mark.parametrize(
    ("bodies", "peak", "line"),
    [
        ("steady", 0.0, "  amplitude    none in stable steady phases"),
        ("steady", None, "  amplitude    there are no stable steady phases"),
    ],
)
def test_without_a_largest_amplitude(bodies: str, peak: float | None, line: str) -> None:
    given = {"peak_speed": None, "peak_amplitude": peak, "bodies": bodies, "self_centring_speed": 5.0}
    assert lines(**given)[2:] == [
        line,
        "  self-centred from 5 rad/s (48 rpm) on: the centre of mass moves inside the orbit of the axis",
    ]
    assert len(lines(**given | {"bodies": "held"})) == 2


def test_bodies_in_steady_phases() -> None:
    assert lines(bodies="steady")[2] == f"  amplitude    2 mm at most, at {AT} in stable steady phases"


def test_other_maxima() -> None:
    some = [{"amplitude": 1e-3 * k, "speed": float(k)} for k in range(1, 12)]
    told = lines(peaks=some)[3]
    each = ", ".join(f"{k} mm at {k} rad/s ({k * 30 / 3.14159265:{'.0f' if k > 1 else '.3g'}} rpm)" for k in range(1, 7))
    assert told == f"  also         {each} and 4 more", "that at 10 rad/s is the largest"
    assert lines(peaks=some[:6])[3].endswith("6 mm at 6 rad/s (57 rpm)")
    unstable = [some[0] | {"stable": False}, some[1] | {"stable": True}, {"amplitude": None, "speed": 5.0}]
    assert lines(peaks=unstable)[3] == "  also         2 mm at 2 rad/s (19 rpm), infinite at 5 rad/s (48 rpm)"
    assert len(lines(peaks=[{"amplitude": 2e-3, "speed": 10.0}])) == 3


def test_in_operation() -> None:
    throw = {"stroke": 4e-3, "acceleration": 12.3456, "machine_number": 1.25849}
    assert lines(free_speed=5.0, amplitude_at_free_speed=1e-3, throw_at_free_speed=throw)[3:] == [
        "  in operation 1 mm at 5 rad/s (48 rpm)",
        "               stroke 4 mm peak to peak, 12.35 m/s², machine number 1.26",
    ]
    assert len(lines(free_speed=5.0, amplitude_at_free_speed=1e-3)) == 4
    assert len(lines(free_speed=5.0)) == len(lines(amplitude_at_free_speed=1e-3)) == 3
    first = {"speed": 10.0, "configuration": "antiphase", "amplitude": 1e-3, "reached_from_rest": True} | throw
    second = {"speed": 5.0, "configuration": "", "amplitude": 2e-3, "reached_from_rest": False}
    assert lines(free_speed=5.0, amplitude_at_free_speed=1e-3, operation=[first, second])[3:] == [
        f"  in operation 1 mm at {AT}, antiphase; reached from rest",
        "               stroke 4 mm peak to peak, 12.35 m/s², machine number 1.26",
        "  in operation 2 mm at 5 rad/s (48 rpm)",
    ]
    assert len(lines(operation=[second] * 8)) == 3 + 6


def test_torques() -> None:
    peaks = [{"speed": 10.0, "torque": 2.5}, {"speed": 5.0, "torque": 1.25}, {"speed": 7.0, "torque": 2.0, "stable": False}]
    given = {"peak_torque_speed": 10.0, "peak_torque": 2.5, "torque_peaks": peaks}
    told = f"  torque       of the vibration: at most 2.5 N m at {AT}, also 1.25 N m at 5 rad/s (48 rpm)"
    assert lines(**given)[3] == told
    assert lines(dimensionless=True, **given)[3] == "  torque       of the vibration: at most 2.5 at 10, also 1.25 at 5"
    many = [{"speed": float(k), "torque": 1.0} for k in range(1, 9)]
    assert lines(**given | {"torque_peaks": many})[3].count(" 1 N m at ") == 6
