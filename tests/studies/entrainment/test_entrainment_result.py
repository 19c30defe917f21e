"""What ``entrainment`` answers of a rotor on a shaken axis, either way round: phases, bands, runs, sentences and lines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

from wucht import Entrainment, draw, load_machine, report, run
from wucht.files.building import machine_from

FREQUENCY = 2 * math.pi
ROTOR = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}


def answered(drive: float = 5.5, inertia: float = 1e-5, **table: Any) -> xr.Dataset:
    machine = load_machine("sperling-vibration/figure-2a")
    values = {"drive.no_load_speed": drive, "rotor.inertia": inertia}
    return run(Entrainment.from_table({"points": 5, "resolution": 0.5} | table), machine.with_values(values))


@pytest.fixture(scope="module")
def band() -> xr.Dataset:
    return answered()


@pytest.fixture(scope="module")
def clockwise() -> xr.Dataset:
    return answered(-5.5, range=[-7.0, -5.0])


# --- the Dataset ---


@pytest.mark.slow
def test_points_of_the_averaged_equations(band: xr.Dataset) -> None:
    """001 (21), (22): the motor is set the sine of the phase times half the band beyond the frequency, stable inside it."""
    half = 0.1 * 0.01 * 1e-3 * FREQUENCY**2 / 2 / 1e-5
    phase = band.phase.values[0]
    assert band.value.values == pytest.approx(FREQUENCY + half * np.sin(phase), rel=1e-9)
    assert (np.abs(phase) <= math.pi).all() and band.body.values.tolist() == ["rotor"]
    inside = np.abs(np.abs(phase) - math.pi / 2) > 1e-3
    assert (band.stable.values[inside] == (np.abs(phase[inside]) < math.pi / 2)).all()
    assert set(band.branch.values) == {0} and band.speed.values == pytest.approx(FREQUENCY)


def test_locked_motions_go_on_from_the_machine_to_their_ends(band: xr.Dataset) -> None:
    """They are dense inside the band of existence, seven to each side."""
    s, values = band.wucht.summary, band.orbit_value.values
    low, high = s["existence_band"]
    assert values == pytest.approx([*np.linspace(low, 5.5, 9)[1:], *np.linspace(5.5, high, 9)[1:-1]])
    least, most = s["existence_band_full"]
    assert least < low < values[0] and values[-1] < high < most
    assert band.orbit_phase.values[0] == pytest.approx(np.interp(values, [low, 5.5, high], [-1.4, -0.408, 1.4]), abs=0.3)
    assert (band.orbit_stable.values == (band.orbit_multiplier.values < 1)).all()
    assert (s["multiplier"], s["stable"]) == (float(band.orbit_multiplier.sel(orbit=values == 5.5).item()), True)
    assert s["phases"] == {"rotor": s["phase"]} and s["phase"] == float(band.orbit_phase.values[0][values == 5.5].item())
    assert s["phase"] == pytest.approx(s["phase_slow"], abs=1e-3) and s["phases_slow"] == {"rotor": s["phase_slow"]}


def test_within_a_narrow_range_they_go_to_its_ends(clockwise: xr.Dataset) -> None:
    expected = [*np.linspace(-7.0, -5.5, 9), *np.linspace(-5.5, -5.0, 9)[1:]]
    assert clockwise.orbit_value.values == pytest.approx(expected)
    s = clockwise.wucht.summary
    assert s["existence_band"] == s["existence_band_full"] == s["band_from_rest"] == [None, None]
    assert s["existence_edges"] == ["range", "range"] and s["range"] == [-7.0, -5.0]
    assert report(clockwise)


def test_runs_from_the_start(band: xr.Dataset) -> None:
    s, values = band.wucht.summary, band.run_value.values
    assert (np.diff(values) > 0).all() and s["value"] == 5.5 and 5.5 in values
    assert {*np.linspace(*s["range"], 5)} <= set(values)
    low, high = s["band_from_rest"]
    assert (band.run_taken.values == ((values > low) & (values < high))).all() and s["islands"] == []
    for edge in (low, high):  # half way between two runs, which are no further apart than the resolution
        below, above = values[values < edge][-1], values[values > edge][0]
        assert edge == (below + above) / 2 and above - below <= s["resolution"] == 0.5
    assert band.run_speed.values == pytest.approx(np.abs(band.run_mean_speed.values))
    taken = band.run_taken.values.astype(bool)
    assert band.run_mean_speed.values[taken] == pytest.approx(FREQUENCY, rel=1e-4)
    assert band.free_speed.values == pytest.approx(values), "without losses"
    assert band.run_rotor_speed.values[0][taken] == pytest.approx(FREQUENCY, rel=1e-4)
    sine = (values[taken] - FREQUENCY) / (0.1 * 0.01 * 1e-3 * FREQUENCY**2 / 2 / 1e-5)
    assert np.sin(band.run_rotor_phase.values[0][taken]) == pytest.approx(sine, abs=0.02)
    assert (band.run_drift.values[taken] < 1e-4).all()
    begin, end = band.run_window.values
    assert (begin > 0).all() and (begin < end).all() and (end <= band.run_end_time.values).all()
    assert (band.run_end_time.values >= band.run_until.values).all() and set(band.run_failed.values) == {""}
    assert band.run_end_state.shape == (3, len(values))
    assert s["window"] == band.run_window.values[:, values == 5.5].ravel().tolist()
    assert band.attrs["frequency"] == FREQUENCY and band.attrs["along"] == s["along"] == "drive.no_load_speed"


def test_a_clockwise_rotor_has_its_speed_with_its_sign(clockwise: xr.Dataset) -> None:
    assert clockwise.wucht.summary["mean_speed"] == pytest.approx(-FREQUENCY)
    assert clockwise.run_mean_speed.values == pytest.approx(-FREQUENCY) and clockwise.run_speed.values == pytest.approx(
        FREQUENCY
    )
    assert clockwise.orbit_speed.values == pytest.approx(FREQUENCY)


@pytest.mark.parametrize(("inertia", "again"), [(1.9e-5, False), (2.1e-5, True)])
def test_a_run_that_was_much_too_short_is_made_again(inertia: float, again: bool) -> None:
    """It takes 200 s; 25 times J/slope more are needed: 1.475 times as long, or 1.525 times."""
    result = answered(inertia=inertia, range=[5.0, 7.0])
    own = result.run_value.values == 5.5
    needed = 200.0 + 25 * 2 * inertia / 1e-5
    assert result.run_until.values[~own] == pytest.approx(needed, rel=1e-3)
    assert result.run_until.values[own] == pytest.approx(needed if again else 200.0, rel=1e-3)


def test_a_motor_far_beyond_the_band() -> None:
    """Without an entrained run nothing is followed; else it begins at the run nearest to the machine."""
    alone = answered(9.5, range=[9.0, 10.0])
    s = alone.wucht.summary
    assert (s["outcome"], s["phases"], s["phase"], s["band_from_rest"]) == ("not-entrained", {}, None, None)
    assert alone.attrs["sentence"].endswith("; it is not reached from the start anywhere in the range")
    assert (alone.sizes["orbit"], s["existence_band_full"], s["multiplier"], alone.wucht.warnings) == (0, None, None, [])
    assert report(alone)
    wide = answered(9.5, range=[5.0, 9.6])
    seed = wide.run_value.values[wide.run_taken.values == 1][-1]
    low, high = 5.0, wide.wucht.summary["existence_band"][1]
    assert wide.orbit_value.values == pytest.approx([*np.linspace(low, seed, 9), *np.linspace(seed, high, 9)[1:-1]])
    assert wide.wucht.summary["phase"] is None, "the machine itself is not entrained"
    assert report(wide)


def test_a_machine_that_cannot_run_reports_why() -> None:
    wild = load_machine("sperling-vibration/figure-2a").with_unchecked_values({"rotor.inertia": 1e-300})
    result = run(Entrainment.from_table({"points": 5}), wild)
    assert result.attrs["failure"] == result.attrs["sentence"] == result.run_failed.values.item()
    assert not result.attrs["finished"] and result.wucht.summary["outcome"] == "failed"


@pytest.mark.slow
def test_two_exciters_have_a_phase_to_each_other() -> None:
    carrier = {"mass": 0.8, "directions": "x", "stiffness": 355.0, "damping": 0.4}
    drives = [{"on": on, "kind": "linear", "slope": 3e-5, "no_load_speed": w} for on, w in (("e1", 12.0), ("e2", 12.2))]
    machine = machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "e1"}, ROTOR | {"name": "e2"}], "drives": drives})
    start = {"e1": {"speed": 12.0}, "e2": {"angle": 0.5, "speed": 12.0}}
    result = run(Entrainment.from_table({"start": start, "range": [-1.0, 1.0], "points": 5, "resolution": 0.5}), machine)
    s = result.wucht.summary
    assert s["outcome"] == "synchronised" and list(s["phases"]) == ["e2"] == result.body.values.tolist()
    assert 0 <= s["phase"] < 2 * math.pi and np.isnan(result.run_rotor_phase.values[0]).all()
    assert "frequency" not in result.attrs and s["threshold_amplitude"] is None and draw(result).axes


@pytest.mark.parametrize("points", [4, 2001])
def test_numbers_of_runs_that_are_refused(points: int) -> None:
    with refused("study.points", given=points):
        Entrainment(points=points)
    assert Entrainment(points=5).points == 5 and Entrainment(points=2000).points == 2000


def test_stable_is_solid_unstable_dashed_and_bands_are_where_they_are(band: xr.Dataset) -> None:
    phase, _ = draw(band).axes

    def lines(style: str) -> list[Any]:
        return [x for x in phase.get_lines() if x.get_linestyle() == style and len(x.get_xdata()) > 2]

    (solid,), (dashed,) = lines("-"), lines("--")
    assert np.nanmax(np.abs(solid.get_ydata())) <= 90 + 1e-6
    assert np.nanmin(np.abs(dashed.get_ydata())) >= 85  # one point of the stable part, so that the lines meet
    assert np.nanmax(np.abs(dashed.get_ydata())) == pytest.approx(180)  # up to the border of the panel
    (shade,) = phase.patches
    box = shade.get_extents().transformed(phase.transData.inverted())
    assert [box.x0, box.x1] == pytest.approx(band.wucht.summary["existence_band"])
    edges = sorted(x.get_xdata()[0] for x in phase.get_lines() if x.get_linestyle() == "-.")
    assert edges == pytest.approx(band.wucht.summary["band_from_rest"])


def test_open_bands_are_drawn(clockwise: xr.Dataset) -> None:
    assert draw(clockwise).axes and draw(clockwise.isel(point=slice(0, 0), orbit=slice(0, 0))).axes
