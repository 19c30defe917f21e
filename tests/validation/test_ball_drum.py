"""A drum with 3 kg of laundry in one place and twelve balls on one track, against an independent program.

The program (C++, Dormand-Prince 5(4) with located events at 1e-9, its equations written by hand) shares nothing with this
package. Balls start evenly spaced and at rest; contacts are a spring and damper while two overlap, as here. Its largest
amplitude and deepest overlap are 38.640 mm and 0.0324 rad with contacts of 339.3 rad/s, 38.883 mm and 0.00424 rad with
2513.27 rad/s, twenty times the operation; both are reached in the passage, before 8 s. Tolerances: balls that knock into each
other carry the last digits to 0.02 mm of the amplitude; the overlap is the deepest at the ends of quarters of steps.
"""

from __future__ import annotations

import pytest

from wucht.files.building import machine_from
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run

DRUM = {
    "carrier": {
        "mass": "45 kg", "directions": "xy", "frequency": ["2.3 Hz", "2.7 Hz"], "damping_ratio": 0.15, "gravity": "9.81 m/s^2",
    },
    "bodies": [
        {"kind": "rotor", "name": "drum", "mass": "15 kg", "unbalance": "0.72 kg m", "inertia": "0.75 kg m^2"},
        {
            "kind": "roller", "name": "b", "count": 12, "about": "drum", "mass": "0.3 kg", "track_radius": "0.26 m",
            "radius": "21 mm", "shape_factor": 0.4, "damping": "0.05 N m s", "track": "ring",
        },
    ],
    "drive": {
        "on": "drum", "kind": "inverter", "set_speed": "1200 rpm", "gain": "3 N m s", "integral_time": "0.5 s",
        "torque_limit": "15 N m", "power_limit": "700 W",
    },
    "loads": [{"on": "drum", "kind": "quadratic", "coefficient": "1.2e-4 N m s^2"}],
    "schedules": [{"parameter": "drive.set_speed", "points": [["0 s", "0 rpm"], ["15 s", "1200 rpm"]]}],
}  # fmt: skip
EVEN = {"drum": {"speed": 0.0}}  # the balls where a track places them


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frequency", "amplitude", "overlap"), [(None, 38.883, 0.00424), (339.3, 38.640, 0.0324)], ids=["default", "soft"]
)
def test_twelve_balls_in_the_passage(frequency: float | None, amplitude: float, overlap: float) -> None:
    soft = {} if frequency is None else {"tracks": {"ring": {"contact_frequency": f"{frequency} rad/s"}}}
    result = run(RunUp(until=8.0, start=EVEN), machine_from(DRUM | soft))
    summary = result.wucht.summary
    assert result.attrs["engine"] == "compiled"
    assert summary["contact_frequencies"]["ring"] == pytest.approx(frequency or 2513.274, rel=1e-6)
    assert 1e3 * summary["peak_amplitude"] == pytest.approx(amplitude, abs=0.03)
    assert summary["overlaps"]["ring"] == pytest.approx(overlap, rel=0.02)
    assert any("overlap by up to" in w for w in result.wucht.warnings) == (frequency is not None)


@pytest.mark.parametrize("balls", [3, pytest.param(12, marks=pytest.mark.slow)])
def test_balls_that_knock_for_good_end_a_run_until_settled(balls: int) -> None:
    """Under gravity they knock for ever: the unbalance scatters by 0.3 %, whatever the length. The schedule ends at 15 s."""
    drum, ball = DRUM["bodies"]
    mass = {3: "1 kg", 12: "0.3 kg"}[balls]
    result = run(RunUp(start=EVEN), machine_from(DRUM | {"bodies": [drum, ball | {"count": balls, "mass": mass}]}))
    assert result.wucht.summary["outcome"] == "passed"
    assert 15 < result.wucht.summary["settling_time"] < 25
    assert result["time"].values[-1] < 150
