"""Two balls that compensate only where they overlap: how far the stiffness of their contacts decides.

Rigid balls of half the unbalance each, an angle w apart, leave 1 - cos(w/2) of it.
"""

from __future__ import annotations

import math

import pytest
import xarray as xr
from tests.refusals import check_refusal

import wucht
from wucht.files.building import machine_from

APART = 0.32  # rad: centres of balls that touch
RIGID = 1 - math.cos(APART / 2)  # 1.28 %; below 1 % is compensated


def run(frequency: float | None, set_frequency: float | None = None, **study: object) -> xr.Dataset:
    """frequency: that the machine's file gives; set_frequency: a value of its parameter."""
    arm, mass, eccentricity = 0.1, 9.75, 1e-3
    ball = {
        "kind": "pendulum", "about": "drum", "mass": 0.5 * mass * eccentricity / arm, "length": arm, "damping": 0.02,
        "diameter": 2 * arm * math.sin(APART / 2), "track": "ring", "restitution": 0.5,
    }  # fmt: skip
    drum = {"kind": "rotor", "name": "drum", "mass": mass, "eccentricity": eccentricity, "inertia": 0.03}
    machine = machine_from(
        {
            "carrier": {"mass": 9.0, "stiffness": 1e5, "damping": 200.0, "directions": "xy"},
            "bodies": [drum, ball | {"name": "a"}, ball | {"name": "b"}],
            "drive": {"on": "drum", "kind": "linear", "slope": 0.05, "no_load_speed": 200.0},
        }
        | ({} if frequency is None else {"tracks": {"ring": {"contact_frequency": frequency}}})
    )
    machine = machine if set_frequency is None else machine.with_values({"tracks.ring.contact_frequency": set_frequency})
    return wucht.run(wucht.RunUp(start={"a": 0.0, "b": 3.0}, tolerance=1e-9, **study), machine)


def test_contacts_that_are_stiff_enough() -> None:
    """The numbers of the check are those of a run of the stiffer machine."""
    soft, stiff = run(200.0), run(400.0)
    s, t = soft.wucht.summary, stiff.wucht.summary
    assert s["outcome"] == s["contact_check_outcome"] == t["outcome"] == "passed"
    assert s["contact_frequencies"] == {"ring": 200.0}
    assert s["final_residual_unbalance"] == pytest.approx(RIGID, rel=0.01)
    difference = abs(t["final_residual_unbalance"] - s["final_residual_unbalance"])
    assert s["contact_check_residual"] == pytest.approx(difference, abs=1e-9)
    change = abs(t["peak_amplitude"] - s["peak_amplitude"]) / s["peak_amplitude"]
    assert s["contact_check_amplitude"] == pytest.approx(change, abs=1e-9)
    overlap, length = s["overlaps"]["ring"], s["overlap_lengths"]["ring"]
    told = f"of 200 rad/s; bodies overlap by {1e6 * length:.3g} µm at most, {math.degrees(overlap):.2g}°"
    assert told in "".join(wucht.report(soft))


@pytest.mark.parametrize(("frequency", "is_changed"), [(3.0, True), (7.0, False)])
def test_where_the_outcome_differs_the_stiffer_run_is_reported(frequency: float, is_changed: bool) -> None:
    """Contacts of 3 rad/s let the balls overlap until they compensate, those of 6 rad/s and 7 rad/s do not."""
    result = run(frequency)
    s = result.wucht.summary
    assert s["outcome"] == "passed"
    assert s["contact_check_outcome"] == ("compensated" if is_changed else "passed")
    assert s["contact_frequencies"]["ring"] == (2 * frequency if is_changed else frequency)
    assert (s["final_residual_unbalance"] > 0.01) and result.attrs["outcome"] == "passed"
    assert any("depends on the stiffness" in w for w in result.wucht.warnings) is is_changed


def test_what_one_of_both_runs_leaves_open_is_no_difference() -> None:
    """After 12 s the run with 3 rad/s has a verdict, the stiffer one not yet: it does not take the verdict's place."""
    result = run(3.0, until=12.0)
    s = result.wucht.summary
    assert (s["outcome"], s["contact_check_outcome"]) == ("compensated", "unidentified")
    assert s["contact_frequencies"] == {"ring": 3.0}
    assert not any("depends on the stiffness" in w for w in result.wucht.warnings)


def test_each_run_of_many_is_checked() -> None:
    result = run(7.0, along="tracks.ring.contact_frequency", values=[3.0, 100.0])
    assert [c["outcome"] for c in result.wucht.summary["cases"]] == ["passed", "passed"]
    assert any("depends on the stiffness" in w for w in result.wucht.warnings)


def test_a_frequency_that_is_set_holds_whether_the_file_gives_one_or_not() -> None:
    """Twenty times 200 rad/s if neither does."""
    for frequency, asked, expected in ((None, 300.0, 300.0), (500.0, 300.0, 300.0), (None, None, 4000.0)):
        summary = run(frequency, set_frequency=asked, until=0.3).wucht.summary
        assert summary["contact_frequencies"] == {"ring": expected}
    check_refusal("run-up: a contact frequency of 0", lambda: run(500.0, set_frequency=0.0))


def test_bodies_that_never_touch_are_not_checked() -> None:
    summary = run(None, until=0.05).wucht.summary
    assert summary["overlaps"] == {"ring": 0.0} and "contact_check" not in summary
