"""The practical machines of the catalogue give what docs/practice/ says about them."""

import math

import numpy as np
import pytest
import xarray as xr
from tests import stated

from wucht import CamPrediction, TorqueBalance, run
from wucht.machines.tracks import angular_width
from wucht.numerics.fourier_series import even_angles
from wucht.studies.study_file import read_study

# name: outcome, final speed in rad/s, peak amplitude in m. Where balls collide, their final places are chance; these
# do not.
EXPECTED = {
    "practice/angle-grinder": ("compensated", 1130.183, 1.3135e-4),
    "practice/balls-at-resonance": ("balancer-captured", 418.38, 6.83e-4),
    "practice/balls-at-resonance-thick-oil": ("compensated", 418.46, 8.12e-4),
    "practice/fan-ball-ring": ("compensated", 760.893, 2.032e-4),
    "practice/fan-on-belt": ("passed", 211.997, 2.0786e-3),
    "practice/fan-on-inverter": ("passed", 151.8436, 0.010047),
    "practice/grinder-10-balls": ("compensated", 1130.183, 1.42e-4),
    "practice/grinder-2-balls": ("passed", 1130.168, 1.3169e-4),
    "practice/grinder-4-balls": ("compensated", 1130.183, 1.3150e-4),
    "practice/grinder-6-balls": ("compensated", 1130.183, 1.3135e-4),
    "practice/laundry-drum": ("compensated", 126.14, 0.01067),
    "practice/laundry-drum-friction": ("passed", 125.6647, 0.011654),
    "practice/laundry-drum-tumbling": ("compensated", 126.166, 0.00892),
    "practice/screen": ("synchronised", 155.1556, 0.00601),
    "practice/screen-loaded": ("synchronised", 154.7105, 0.004035),
    "practice/screen-unsynchronised": ("not-synchronised", 155.232, 0.00467),
}


@pytest.mark.slow
def test_the_carton_pusher_gives_what_its_notes_say() -> None:
    """The shaft swings by 12 %; the cam for an even shaft leaves orders, the corrected one none; pressure angle 42 degrees."""
    study = read_study("practice/carton-pusher")
    s = run(CamPrediction(simulate=5, cuts=1), study.subject).wucht.summary
    assert s["fluctuation"] == pytest.approx(0.1158, abs=1e-4)
    assert s["corrected"]["fluctuation"] == pytest.approx(0.1253, abs=1e-4)
    assert s["inertia_ratio"] == pytest.approx(0.305, abs=1e-3)
    assert s["above"]["original"] == pytest.approx(0.0735, abs=1e-4)
    assert s["above"]["corrected"] < 1e-12
    assert s["simulation"]["corrected"]["deviation"] < 1e-9
    cam = study.subject.make_cams(study.subject.motion_law.function)["cam"]
    assert math.degrees(np.abs(cam.pressure_angle(even_angles(3600))).max()) == pytest.approx(42.0, abs=0.3)


@pytest.mark.slow
def test_switchable_pendulums_leave_the_resonance_of_the_laundry_drum_as_it_is() -> None:
    """What docs/switchable-pendulums.md says: 7.3 mm as without any, rigid ones 6.6 to 15 mm; all compensate."""
    study = read_study("practice/laundry-drum-switchable")
    result = run(study.spec, study.subject)
    s = result.wucht.summary
    assert s["none"]["peak_amplitude"] == pytest.approx(7.302e-3, rel=1e-3)
    assert float(result.curve_amplitude.sel(curve="without pendulums").dropna("point")[-1]) == pytest.approx(2.4e-3, rel=0.03)
    assert result.peak.values == pytest.approx(np.full((1, 2, 4), 7.328e-3), rel=1e-3)
    assert (result.rigid_peak.values.min(), result.rigid_peak.values.max()) == pytest.approx((6.575e-3, 15.04e-3), rel=1e-2)
    assert (result.peak_after.values.min(), result.peak_after.values.max()) == pytest.approx((4.11e-3, 6.08e-3), rel=1e-2)
    assert float(result.final_amplitude.max()) < 1e-6
    assert set(result.outcome.values.ravel()) == {"compensated"}
    pendulum = s["pendulums"][0]
    assert [pendulum[k][0] for k in ("opening", "closing", "after_opening")] == pytest.approx([40.0, 33.166, 34.235], rel=1e-4)
    assert sorted(s["natural_frequencies"].values()) == pytest.approx([13.87, 16.41], abs=0.01)
    assert s["energy_residual"] < 1e-10


@pytest.fixture(scope="module")
def results() -> dict[str, xr.Dataset]:
    return {}


@pytest.fixture
def ran(results: dict[str, xr.Dataset]):
    """The result of a catalogue name, computed once."""

    def of(name: str) -> xr.Dataset:
        if name not in results:
            study = read_study(name)
            results[name] = run(study.spec, study.subject)
            if name in REPEATABLE:
                stated.check(name, results[name])
        return results[name]

    return of


# The other numbers of balls of the grinder lie between those of 2, 6 and 10.
LONG = (
    "practice/laundry-drum", "practice/angle-grinder", "practice/balls-at-resonance-thick-oil",
    "practice/balls-at-resonance", "practice/fan-ball-ring", "practice/fan-on-belt", "practice/grinder-4-balls",
    "practice/grinder-10-balls", "practice/grinder-6-balls",
    "practice/laundry-drum-friction", "practice/laundry-drum-tumbling", "practice/screen-loaded",
)  # fmt: skip
REPEATABLE = ("practice/fan-on-belt", "practice/fan-on-inverter", "practice/screen", "practice/screen-unsynchronised")
WITHOUT_BALLS = ("fan-on", "friction", "screen")


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in sorted(EXPECTED)])
def test_runs_and_gives_its_numbers(name: str, ran) -> None:
    outcome, speed, peak = EXPECTED[name]
    actual = ran(name).wucht.summary
    assert actual["outcome"] == outcome
    assert actual["final_speed"] == pytest.approx(speed, rel=1e-4)
    # As in test_catalogue_runs; where balls collide before the peak, it moves a little with the last bit.
    assert actual["peak_amplitude"] == pytest.approx(peak, rel=5e-2)
    assert actual["energy_residual"] < 1e-8


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=pytest.mark.slow) if n in LONG else n
        for n in sorted(EXPECTED)
        if not any(word in n for word in WITHOUT_BALLS)
    ],
)
def test_no_ball_passes_another(name: str, ran) -> None:
    """The balls keep their order on the track, and are pressed into each other by less than a hundredth of a radian."""
    track = read_study(name).subject.tracks[0]
    angles = np.array([ran(name).angle.sel(body=b.name).values for b in track.bodies])
    angles = angles[np.argsort(angles[:, 0] % (2 * math.pi))]
    ahead = np.diff(np.vstack([angles, angles[:1]]), axis=0)
    ahead -= 2 * math.pi * np.floor(ahead[:, :1] / (2 * math.pi))
    assert (ahead - angular_width(track.bodies[0], track.bodies[1])).min() > -0.01


def test_two_balls_side_by_side_leave_the_rest_of_the_unbalance(ran) -> None:
    """1 - (2 m eps/U) cos(beta/2), beta = 2 asin(r/eps) between balls that touch: 2 m eps = 105, U = 150 g mm, eps = 25 mm."""
    left = 1 - 105 / 150 * math.sqrt(1 - (4 / 25) ** 2)
    assert ran("practice/grinder-2-balls").wucht.summary["final_residual_unbalance"] == pytest.approx(left, abs=1e-3)


def test_the_fan_on_a_belt_is_driven_by_the_motor_of_its_nameplate() -> None:
    """4 kW, three times the rated torque, through the belt; at the end V/f control has the rated voltage and frequency."""
    study = read_study("practice/fan-on-belt")
    machine = study.subject
    motor, rated = machine.drives[0], 4000 / (1435 * math.pi / 30)
    assert motor.torque_at(1435 * math.pi / 30 / 0.714) == pytest.approx(0.95 * 0.714 * rated, rel=1e-9)
    assert motor.reduced_breakdown()[2] == pytest.approx(0.95 * 0.714 * 3 * rated, rel=1e-9)
    assert machine.at(6.0).values["drive.voltage"] == pytest.approx(400.0)
    assert machine.at(3.0).values["drive.voltage"] == pytest.approx((400 + 12) / 2)
    s = run(TorqueBalance(), machine).wucht.summary
    (point,) = s["working_points"]
    assert (point["speed"], point["slip"], point["torque"]) == pytest.approx((211.997, 0.0364, 15.39), rel=2e-3)
    assert machine.notes[0].startswith("drive: circuit of the nameplate, ohm a phase: stator 3.231, rotor 4.188 (6.328 at")
    assert machine.warnings == ()


def test_the_balls_of_the_ring_stand_where_their_seed_says() -> None:
    machine = read_study("practice/fan-ball-ring", {"b3.mass": "3 g", "b.count": 5}).subject
    assert [b.name for b in machine.bodies] == ["impeller", *(f"b{k}" for k in range(1, 6))]
    assert [machine.values[f"b{k}.mass"] for k in (2, 3)] == pytest.approx([2.1e-3, 3e-3])
    assert machine.drives[0].torque_at(6940 * math.pi / 30) == pytest.approx(0.177)


@pytest.mark.slow
def test_balls_in_thin_oil_hang_in_a_heap_below_the_resonance(ran) -> None:
    result = ran("practice/balls-at-resonance")
    speeds = result.speed.isel(time=slice(-5000, None)).mean("time").values
    assert speeds[1:] == pytest.approx([55.52] * 4, abs=0.05)
    radius, late = result.radius.values, slice(-5000, None)
    turn = np.floor(result.angle.values[0, late] / (2 * math.pi)).astype(int)
    largest = [radius[late][turn == k].max() for k in range(turn[0] + 1, turn[-1])]
    amplitudes = result.wucht.summary["final_amplitude"], float(result.amplitude[late].mean()), float(np.mean(largest))
    assert amplitudes == pytest.approx((4.585e-4,) * 3, rel=2e-3), "of the report, of the Dataset, and largest within a turn"
    assert speeds[1] < min(result.wucht.summary["natural_frequencies"].values())


def test_the_screen_throws_along_the_line_between_its_exciters(ran) -> None:
    """Angles of e1 and e2 add up to 90.37 degrees: the forces add up along 45.2 degrees; amplitude 2 U/M, a little more."""
    result = ran("practice/screen")
    actual = result.wucht.summary
    assert math.degrees(actual["rotor_phases"]["e2"]) == pytest.approx(360 - 90.37, abs=0.1)
    assert actual["final_amplitude"] == pytest.approx(2.29e-3, rel=1e-2)
    last = result.displacement.isel(time=slice(-300, None))
    x, y = last.sel(direction="x").values, last.sel(direction="y").values
    spread, axes = np.linalg.eigh(np.cov(x, y))
    assert math.degrees(math.atan2(axes[1, 1], axes[0, 1])) % 180 == pytest.approx(45.5, abs=0.5)
    assert math.sqrt(spread[0] / spread[1]) < 0.01  # straight


def test_the_line_of_an_unsynchronised_screen_turns(ran) -> None:
    result = ran("practice/screen-unsynchronised")
    actual = result.wucht.summary
    speeds = actual["mean_speeds"]
    assert 1 + speeds["e2"] / speeds["e1"] == pytest.approx(0.0134, abs=5e-4)
    assert actual["modulation_period"] == pytest.approx(3.04, abs=0.02)


@pytest.mark.slow
def test_laundry_that_loses_water_is_followed_without_vibration(ran) -> None:
    """While the unbalance falls from 0.12 to 0.08 kg m between 60 and 80 s, the axis moves by micrometres."""
    result = ran("practice/laundry-drum-tumbling")
    blow = float(result.amplitude.sel(time=slice(40.0, 42.0)).max())
    water = float(result.amplitude.sel(time=slice(62.0, 80.0)).max())
    assert 4e-4 < blow < 7e-4
    assert water < 2e-5


@pytest.mark.slow
def test_free_travel_saves_power_at_full_speed(ran) -> None:
    """What docs/practice/washing-machine.md says: 4 F (a - d) a cycle and damper less; without dampers it hits its buffers."""

    def changed(**values: float) -> tuple[float, float, float]:
        study = read_study(
            "practice/laundry-drum-friction", {f"{n}.{key}": v for key, v in values.items() for n in ("left", "right")}
        )
        result = run(study.spec, study.subject)
        power = float(result.motor_power.isel(time=result.time > 19).mean())
        return result.wucht.summary["peak_amplitude"], power, float(np.abs(result.displacement.sel(direction="x")).max())

    usual = ran("practice/laundry-drum-friction")
    assert usual.wucht.summary["final_amplitude"] == pytest.approx(2.355e-3, rel=1e-3)
    assert float(usual.speed.max()) < 1.006 * 125.664
    assert float(usual.motor_power.max()) == pytest.approx(500.0, rel=1e-9)
    power = float(usual.motor_power.isel(time=usual.time > 19).mean())
    peak, tight, _ = changed(free_travel=0.0)
    assert peak == pytest.approx(3.707e-3, rel=1e-2)
    assert tight - power == pytest.approx(2 * 4 * 60.0 * (2.42e-3 - 2e-4) * 20.0, rel=2e-2)
    peak, free, aside = changed(force=0.0)
    assert peak == pytest.approx(19.37e-3, rel=1e-2)
    assert free == pytest.approx(power, rel=1e-4)
    assert aside > 12e-3


@pytest.mark.slow
def test_the_material_slows_the_screen_down(ran) -> None:
    """Throw number 2.58, and 170 W: what the damper takes at the amplitudes of its place."""
    result = ran("practice/screen-loaded")
    last = result.displacement.isel(time=slice(-300, None))
    across = np.ptp(last.sel(direction="y").values) / 2
    assert across * 154.71**2 / 9.81 == pytest.approx(2.58, abs=0.02)
    assert result.wucht.summary["final_amplitude"] == pytest.approx(1.483e-3, rel=1e-3)


@pytest.mark.slow
def test_a_ring_of_balls_compensates_as_far_as_it_goes_wherever_the_balls_begin() -> None:
    """Side by side n balls have m eps sin(n a/2)/sin(a/2), a = 2 asin(r/eps): 14 of them 0.770 kg m, more than the laundry's
    0.72 and less than 0.82 kg m; 12 have 0.710, and 1.4 % is left where all touch, a little more where they do not."""
    track, radius, mass = 0.26 - 0.021, 0.021, 0.3
    half = math.asin(radius / track)
    capacity = {n: mass * track * math.sin(n * half) / math.sin(half) for n in (6, 12, 14)}
    assert list(capacity.values()) == pytest.approx([0.411, 0.710, 0.770], abs=5e-4)
    study = read_study("practice/washing-machine-ring")
    result = run(study.spec, study.subject)
    assert result.estimate.values.tolist() == [1.0, 0.0]
    assert result.low.values[0] == pytest.approx(0.025 ** (1 / 128))
    assert result.high.values[1] == pytest.approx(1 - 0.025 ** (1 / 128))
    assert (result.wucht.summary["runs"], result.wucht.summary["impossible"]) == (256, 0)
    fewer = read_study("practice/washing-machine-ring", {"b.count": 12, "study.samples": 8, "study.range": [0.6, 0.72]})
    assert run(fewer.spec, fewer.subject).estimate.values.tolist() == [1.0, 0.0]
    for count, outcome in ((6, "passed"), (12, "passed"), (14, "compensated")):
        study = read_study("practice/washing-machine-ring", {"b.count": count, "study.kind": "run-up"})
        s = run(study.spec, study.subject).wucht.summary
        assert s["outcome"] == outcome
        left = max(1 - capacity[count] / 0.72, 0.0)
        assert left - 1e-3 < s["final_residual_unbalance"] < left + 6e-3, count
