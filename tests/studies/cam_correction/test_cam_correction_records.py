"""The correction from records: what noise leaves, what to check, and a measured acceleration beside the computed one."""

import json
import math

import numpy as np
import pytest
from known_cam import LAW, SHAFT, ZERO, write
from tests.refusals import check_refusal, refused

import wucht
from wucht import CamCorrection, InputError, run_file
from wucht.cams.correction import CorrectedLaw, MotionOverTime, orders, share_above_order
from wucht.cams.drive import cam_drive_from
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries

pytestmark = pytest.mark.usefixtures("coarse_angles")

LAW_TABLE = {"kind": "harmonic", "coefficients": {"mean": LAW.mean, "cosine": [*LAW.cosine], "sine": [*LAW.sine]}}
SPEED = {"mean": SHAFT.mean, "cosine": [*SHAFT.speed.cosine], "sine": [*SHAFT.speed.sine]}
FILE = f"""
[study]
kind = "cam-correction"
points = 36
[law]
kind = "harmonic"
coefficients = {{ mean = {LAW.mean}, cosine = {LAW.cosine.tolist()}, sine = {LAW.sine.tolist()} }}
[speed]
file = "record.csv"
column = "speed"
orders = [2, 3, 4, 5]
index = "index"
"""
COEFFICIENTS = f"""[speed]
mean = {SHAFT.mean}
cosine = {SHAFT.speed.cosine.tolist()}
sine = {SHAFT.speed.sine.tolist()}
"""


def asked(folder, text=FILE, **settings):
    path = folder / "drive.toml"
    path.write_text(text, encoding="utf-8")
    return run_file(path, settings)


def truly_left(result):
    """What the cam made for the measured speed leaves on the shaft as it truly turns."""
    fitted = ShaftMotion(
        FourierSeries(result.wucht.summary["mean_speed"], result.speed_cosine.values, result.speed_sine.values)
    )
    return share_above_order(orders(MotionOverTime(CorrectedLaw(LAW, fitted), SHAFT)), 5)


@pytest.mark.parametrize("noise", [0.01, 0.1])
def test_what_noise_leaves_is_as_large_as_is_said(tmp_path, noise):
    """The index pulse rises at a sample, one of 810 in a turn, so that the phase is known to 0.4 deg: here it is set right."""
    write(tmp_path / "record.csv", noise=noise)
    result = asked(tmp_path, FILE.replace('index = "index"\n', ""))
    by = SHAFT.mean * (result.wucht.summary["record"]["zero"] - ZERO)
    fitted = FourierSeries(0.0, result.speed_cosine.values, result.speed_sine.values).shift(by)
    aligned = result.assign(speed_cosine=("speed_order", fitted.cosine), speed_sine=("speed_order", fitted.sine))
    said = result.wucht.summary["record"]["left_by_errors"]
    assert said / 6 < truly_left(aligned) < 3 * said
    assert said < 0.05 * noise


def test_the_index_pulse_sets_the_phase(tmp_path):
    write(tmp_path / "record.csv", noise=0.01)
    result = asked(tmp_path)
    assert truly_left(result) < 0.02
    s = result.wucht.summary
    assert s["record"]["orders"] == [2, 3, 4, 5]
    assert s["record"]["turns"] == pytest.approx(7.4, rel=1e-3)
    assert s["record"]["explained"] > 0.999
    errors = result.speed_error.values
    assert np.isnan(errors[0])
    assert (errors[1:] > 0).all()
    assert (np.abs(result.speed_amplitude.values[1:] - SHAFT.speed.amplitudes[1:]) < 5 * errors[1:]).all()


def test_what_to_check_of_a_record_is_told(tmp_path):
    write(tmp_path / "record.csv")
    warnings = json.loads(asked(tmp_path, **{"speed.orders": [3, 4, 5]}).attrs["warnings"])
    assert any(w.startswith("Order 2 is left out, but the record holds") for w in warnings)
    assert not any("no index pulse" in w for w in warnings)
    without = asked(tmp_path, FILE.replace('index = "index"\n', ""), **{"speed.orders": [2, 3, 5]})
    texts = without.wucht.warnings
    assert any("no index pulse: cam angle zero is taken to be at 0 s." in w for w in texts)
    assert any(w.startswith("Order 4 is left out, but the record holds 1.0") for w in texts)


@pytest.mark.parametrize("cam", ["original", "corrected"])
def test_a_measured_acceleration_beside_the_computed_one(tmp_path, cam):
    """Figures 2 and 4 of 004: with the cam it was measured with it is explained, with the other one it is not."""
    law = LAW if cam == "original" else CorrectedLaw(LAW, SHAFT)
    write(tmp_path / "record.csv", law, noise=0.05)
    other = {"original": "corrected", "corrected": "original"}[cam]
    acceleration = {"file": "record.csv", "column": "acceleration", "orders": 12, "zero": ZERO}
    text = FILE.split("[speed]", maxsplit=1)[0] + COEFFICIENTS
    right, wrong = (asked(tmp_path, text, **{"study.acceleration": acceleration | {"cam": c}}) for c in (cam, other))
    m = right.wucht.summary["measured"]
    assert m["explained"] > 0.999
    assert wrong.wucht.summary["measured"]["explained"] < 0.99
    assert m["noise_rms"] == pytest.approx(50, rel=0.1)
    assert m["rms"] == pytest.approx(np.hypot(right.measured_acceleration.values.std(), m["noise_rms"]), rel=0.01)
    assert (m["orders"], m["cam"]) == (12, cam)
    measured, made = right.measured_acceleration.values, right.acceleration.sel(version=cam).values
    # Above order 12 the original cam makes 0.2 % more.
    assert measured == pytest.approx(made, abs=4e-3 * np.abs(made).max())
    assert right.measured_amplitude.values[:5] == pytest.approx(right.computed_amplitude.values[:5], rel=0.02)
    assert np.isnan(right.measured_amplitude.values[12:]).all()
    assert right.sizes["order"] == 24


def test_a_speed_that_is_a_little_wrong_does_not_smear_the_orders(tmp_path):
    write(tmp_path / "record.csv", turns=40, count=16000)
    text = FILE.split("[speed]", maxsplit=1)[0] + COEFFICIENTS
    # The record's middle is 20 turns from zero: 0.3 % are 22 degrees there, so that the phase is given near it.
    result = asked(tmp_path, text, **{
        "speed.mean": 1.003 * SHAFT.mean,
        "study.acceleration": {"file": "record.csv", "column": "acceleration", "zero": ZERO + 20 * 2 * math.pi / SHAFT.mean},
    })  # fmt: skip
    assert any("repeats at 0.99701 times the mean speed" in w for w in result.wucht.warnings)
    assert result.measured_amplitude.values[:10] == pytest.approx(orders_of_original()[:10], rel=0.02, abs=1.0)


def orders_of_original():
    return SHAFT.mean**2 * orders(MotionOverTime(LAW, SHAFT)).amplitudes


def test_a_sensor_on_a_lever_measures_along_its_circle(tmp_path):
    heading = "time [s],speed [rad/s],index [V],acceleration [m/s^2]"
    write(tmp_path / "record.csv", heading=heading)
    given = {"file": "record.csv", "column": "acceleration", "zero": ZERO}
    with refused("record.csv: acceleration", given="m/s^2"):
        asked(tmp_path, **{"study.acceleration": given})
    amplitude = asked(tmp_path, **{"study.acceleration": given | {"radius": "500 mm"}}).measured_amplitude.values
    assert amplitude[:5] == pytest.approx(2 * orders_of_original()[:5], rel=1e-3)


def test_an_acceleration_that_is_not_that_of_this_cam_is_told(tmp_path):
    write(tmp_path / "record.csv")
    given = {"file": "record.csv", "column": "acceleration", "zero": ZERO + 0.06}
    result = asked(tmp_path, **{"study.acceleration": given})
    assert any("check its sign and unit" in w for w in result.wucht.warnings)
    assert result.wucht.summary["measured"]["explained"] < 0


SPOILT = [
    ({"speed.orders": [2, 900]}, {}), ({}, {"turns": 0.8}),
    ({}, {"heading": "time [s],speed [m],index [V],acceleration [rad/s^2]"}),
    ({"study.acceleration": {"file": "no.csv", "column": "a"}}, {}),
    ({"study.acceleration": {"file": "record.csv", "column": "accel"}}, {}),
    ({"study.acceleration": {"file": "record.csv"}}, {}),
    ({"study.acceleration": {"file": "record.csv", "column": "acceleration", "cam": "old"}}, {}),
    ({"study.acceleration": {"file": "record.csv", "column": "acceleration", "orders": 251}}, {}),
]  # fmt: skip


@pytest.mark.parametrize(("settings", "record"), SPOILT)
def test_records_that_cannot_be_used(tmp_path, settings, record):
    write(tmp_path / "record.csv", **record)
    error = check_refusal(f"cam-correction of a record: {settings} {record}", lambda: asked(tmp_path, **settings))
    assert str(error).startswith(str(tmp_path / "drive.toml"))


@pytest.mark.parametrize("column", ["speed", "acceleration"])
def test_a_gap(tmp_path, column):
    table = write(tmp_path / "record.csv")
    kept = table[(table[:, 0] < 0.2) | (table[:, 0] > 0.5)]
    name = "record.csv" if column == "speed" else "gap.csv"
    heading = "time [s],speed [rad/s],index [V],acceleration [rad/s^2]"
    np.savetxt(tmp_path / name, kept, delimiter=",", header=heading, comments="", fmt="%.12g")
    settings = {"study.acceleration": {"file": name, "column": "acceleration"}} if column == "acceleration" else {}
    check_refusal(f"cam-correction of a record: a gap of {column}", lambda: asked(tmp_path, **settings))


def test_rows_of_different_length(tmp_path):
    write(tmp_path / "record.csv")
    lines = (tmp_path / "record.csv").read_text().splitlines()
    lines[50] = lines[50].rsplit(",", 1)[0]
    (tmp_path / "record.csv").write_text("\n".join(lines))
    with refused("record.csv", "line 51", "4 columns", code="count"):
        asked(tmp_path)


def test_a_record_that_has_changed_is_told_by_its_name(tmp_path):
    """Not by its hash, which the facts of the drive hold."""
    write(tmp_path / "record.csv")
    path = tmp_path / "drive.toml"
    path.write_text(FILE, encoding="utf-8")
    run_file(path, folder=tmp_path / "out")
    write(tmp_path / "record.csv", noise=0.01)
    with pytest.raises(InputError) as raised:
        run_file(path, folder=tmp_path / "out", resume=True)
    assert str(raised.value).endswith("answers another question: the record record.csv has changed")
    (tmp_path / "record.csv").rename(tmp_path / "other.csv")
    with pytest.raises(InputError) as raised:
        run_file(path, {"speed.file": "other.csv"}, folder=tmp_path / "out", resume=True)
    assert str(raised.value).endswith("another question: speed.file was 'record.csv', now 'other.csv'")


@pytest.mark.parametrize(
    ("heading", "keys", "turned"),
    [
        ("acceleration [rad/s^2]", {"scale": -1}, -1.0),
        ("acceleration [m/s]", {"unit": "rad/s^2"}, 1.0),
        ("acceleration", {"unit": "deg/s^2", "scale": 180 / math.pi}, 1.0),
    ],
)
def test_what_is_said_of_the_acceleration(tmp_path, heading, keys, turned):
    write(tmp_path / "record.csv", noise=0.01, heading=f"time [s],speed [rad/s],index [V],{heading}")
    given = {"file": "record.csv", "column": "acceleration", "zero": ZERO, **keys}
    text = FILE.split("[speed]", maxsplit=1)[0] + COEFFICIENTS
    result = asked(tmp_path, text, **{"study.acceleration": given})
    m, recorded = result.wucht.summary["measured"], np.loadtxt(tmp_path / "record.csv", delimiter=",", skiprows=1)[:, 3]
    assert m["explained_orders"] == pytest.approx(1.0, abs=1e-3) if turned > 0 else m["explained_orders"] < 0
    assert m["rms"] == pytest.approx(recorded.std(), rel=0.05)
    assert result.wucht.unit_at("measured.rms") == "rad/s^2"


def test_a_unit_of_the_acceleration_that_is_wrong_is_told_at_its_key(tmp_path):
    write(tmp_path / "record.csv")
    with pytest.raises(InputError) as raised:
        asked(tmp_path, **{"study.acceleration": {"file": "record.csv", "column": "acceleration", "unit": "mm"}})
    assert raised.value.key == "study.acceleration.unit"


@pytest.mark.parametrize(("mean_share", "errors", "told"), [(1.1e-3, 30, True), (0.9e-3, 30, False), (3e-3, 2, False)])
def test_an_order_that_a_record_holds_is_warned_of_where_it_is_significant_and_matters(tmp_path, mean_share, errors, told):
    """Above a thousandth of the mean speed, and above three standard errors, of which each is sigma sqrt(2/n)."""
    rng, count, mean = np.random.default_rng(3), 4000, 50.0
    time, amplitude = np.linspace(0.0, 8 * 2 * math.pi / mean, count), mean_share * mean
    noise = amplitude / errors / math.sqrt(2 / count) * rng.standard_normal(count)
    speed = mean + 5 * np.cos(2 * mean * time) + amplitude * np.sin(3 * mean * time) + noise
    table = np.column_stack([time, speed])
    np.savetxt(tmp_path / "record.csv", table, delimiter=",", header="time [s],speed [rad/s]", comments="", fmt="%.12g")
    result = asked(tmp_path, FILE.replace('index = "index"\n', ""), **{"speed.orders": [2]})
    warnings = [w for w in result.wucht.warnings if w.startswith("Order ") and "is left out, but the record holds" in w]
    assert [w.split(" of the speed")[0] for w in warnings] == ["Order 3 is left out, but the record holds 0.11 %"] * told


COUNTER = {"arm": 0.07, "roller_radius": 0.01, "angle": "110 deg"}
LEVER = {"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07, "roller_radius": 0.01, "angle": "-135 deg"}


def test_two_cams_with_a_measured_acceleration_and_its_samples_are_drawn(tmp_path):
    write(tmp_path / "record.csv", noise=0.05)
    speed = {"file": "record.csv", "column": "speed", "orders": [2, 3, 4, 5], "index": "index"}
    tables = {"law": LAW_TABLE, "follower": LEVER | {"counter": COUNTER}, "speed": speed}
    given = {"file": "record.csv", "column": "acceleration", "zero": ZERO}
    whole = wucht.run(CamCorrection(points=36, acceleration=given), cam_drive_from(tables, "Two cams", tmp_path))
    assert whole.wucht.summary["record"]["explained"] > 0.999 and wucht.report(whole)
    time, spectrum = wucht.draw(whole).axes[-2:]
    assert spectrum.get_yscale() == "log"
    assert min(bar.get_y() + bar.get_height() for bar in spectrum.patches) > spectrum.get_ylim()[0]
    dots = time.get_lines()[0]
    assert len(dots.get_xdata()) == whole.sizes["sample"] == 3000
    assert 0 <= dots.get_xdata().min() < dots.get_xdata().max() <= time.get_xlim()[1]
    # Noise of 50 rad/s^2 beside the orders that were fitted to all of the record.
    fitted = np.interp(dots.get_xdata(), 1e3 * whole.time.values, whole.measured_acceleration.values)
    assert np.std(dots.get_ydata() - fitted) == pytest.approx(50, rel=0.15)


def test_orders_of_a_record_that_are_left_out_are_told_with_what_they_leave(tmp_path):
    write(tmp_path / "record.csv", noise=0.05)
    speed = {"file": "record.csv", "column": "speed", "orders": [2, 4, 5], "index": "index"}
    result = wucht.run(CamCorrection(points=36), cam_drive_from({"law": LAW_TABLE, "speed": speed}, "Three missing", tmp_path))
    record = result.wucht.summary["record"]
    three = record["left_out"][0]
    assert three["order"] == 3
    assert three["amplitude"] == pytest.approx(SHAFT.speed.amplitudes[2], rel=0.02)
    assert three["share"] == pytest.approx(0.28, rel=0.1)  # as a known order 3 leaves that is not corrected for
    assert record["left_by_left_out"] == pytest.approx(three["share"], rel=0.01)
    assert record["left_by_errors"] < 0.1 * three["share"]
    assert float(result.left_out_amplitude.sel(left_out_order=3)) == three["amplitude"]
    errors = np.hypot(result.speed_cosine_error, result.speed_sine_error)
    assert (result.speed_error <= errors)[[1, 3, 4]].all()
    assert np.isnan(result.speed_cosine_error[2])
    assert wucht.report(result) and wucht.draw(result).axes


def acceleration(folder, **asked):
    """A report beside a record of the acceleration with its zero at ZERO."""
    write(folder / "record.csv", noise=0.05)
    drive = cam_drive_from({"law": LAW_TABLE, "speed": SPEED}, "Measured", folder)
    given = {"file": "record.csv", "column": "acceleration", "zero": ZERO, **asked}
    return wucht.run(CamCorrection(points=36, acceleration=given), drive)


@pytest.mark.parametrize(("sign", "word"), [(1, "later"), (-1, "earlier")])
def test_a_delay_is_told_and_taken_out(tmp_path, sign, word):
    late = sign * 5 / 360 * 2 * np.pi / SHAFT.mean
    result = acceleration(tmp_path, zero=ZERO - late)
    m = result.wucht.summary["measured"]
    assert m["explained"] < 0.95
    assert m["explained_without_delay"] > 0.999
    assert np.degrees(m["delay"]) == pytest.approx(5 * sign, abs=0.1)
    assert wucht.report(result)
    (said,) = (w for w in result.wucht.warnings if f"{word} than" in w)
    better = acceleration(tmp_path, zero=said.split('zero = "')[1].split('"')[0])
    assert better.wucht.summary["measured"]["explained"] > 0.999
    assert better.wucht.summary["measured"]["delay"] is None


def test_too_few_orders_are_told_and_hide_no_misfit(tmp_path):
    result = acceleration(tmp_path, orders=3)
    m = result.wucht.summary["measured"]
    assert m["explained_orders"] > 0.98
    assert m["explained"] < 0.55
    assert m["noise_rms"] > 1000
    assert m["delay"] is None  # what there is of one comes of the speed, which is not well known
    (said,) = (w for w in result.wucht.warnings if w.startswith("Only 3 orders are fitted"))
    enough = int(said.split("orders = ")[1].rstrip("."))
    assert 5 < enough < 15
    assert not any("orders are fitted" in w for w in acceleration(tmp_path, orders=enough).wucht.warnings)
