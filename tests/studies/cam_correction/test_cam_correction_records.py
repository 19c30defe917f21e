"""The correction from records: what noise leaves, what to check, and a measured acceleration beside the computed one."""

import json
import math

import numpy as np
import pytest
from known_cam import LAW, SHAFT, ZERO, write
from tests.refusals import check_refusal, refused

from wucht import InputError, run_file
from wucht.cams.correction import CorrectedLaw, MotionOverTime, orders, share_above_order
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries

pytestmark = pytest.mark.usefixtures("coarse_angles")

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


@pytest.mark.slow
def test_a_changed_record_of_the_acceleration_is_another_question(tmp_path):
    """It is told by its name; unchanged, the finished answer is read back."""
    record, file = tmp_path / "acc.csv", tmp_path / "cam.toml"
    t = np.linspace(0, 0.5, 800)
    rows = [f"{x:.6f}, {y:.6f}" for x, y in zip(t, np.cos(500 * math.pi / 30 * t), strict=True)]
    record.write_text("time [s], acceleration [rad/s^2]\n" + "\n".join(rows) + "\n")
    tables = "[law]\nkind = 'harmonic'\ncoefficients = { cosine = ['5 deg', '1 deg'] }\n[speed]\nmean = '500 rpm'\n"
    file.write_text(
        f"[study]\nkind = 'cam-correction'\nacceleration = {{ file = 'acc.csv', column = 'acceleration' }}\n{tables}"
    )
    first = run_file(file, folder=tmp_path / "out")
    again = run_file(file, folder=tmp_path / "out", resume=True)
    assert again.attrs["elapsed_s"] == first.attrs["elapsed_s"]
    record.write_text(record.read_text().replace("1.000000\n", "1.000001\n", 1))
    with refused("--resume", "acc.csv", code="other-question"):
        run_file(file, folder=tmp_path / "out", resume=True)
