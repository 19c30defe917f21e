"""The figure and the sentences of the study cam-correction, from the Dataset alone."""

import io

import numpy as np
import pytest
from known_cam import LAW, SHAFT, ZERO, write
from tests.refusals import refused

import wucht
from wucht.cams.drive import cam_drive_from
from wucht.studies.cam_correction.spec import CamCorrection

pytestmark = pytest.mark.usefixtures("coarse_angles")

LAW_TABLE = {"kind": "harmonic", "coefficients": {"mean": LAW.mean, "cosine": [*LAW.cosine], "sine": [*LAW.sine]}}
SPEED = {"mean": SHAFT.mean, "cosine": [*SHAFT.speed.cosine], "sine": [*SHAFT.speed.sine]}
COUNTER = {"arm": 0.07, "roller_radius": 0.01, "angle": "110 deg"}
LEVER = {"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07, "roller_radius": 0.01, "angle": "-135 deg",
         "counter": COUNTER}  # fmt: skip


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A cam and a counter cam, from a record, with a measured acceleration."""
    folder = tmp_path_factory.mktemp("record")
    write(folder / "record.csv", noise=0.05)
    speed = {"file": "record.csv", "column": "speed", "orders": [2, 3, 4, 5], "index": "index"}
    drive = cam_drive_from({"law": LAW_TABLE, "follower": LEVER, "speed": speed}, "Two cams", folder)
    acceleration = {"file": "record.csv", "column": "acceleration", "zero": ZERO}
    return wucht.run(CamCorrection(points=360, acceleration=acceleration), drive)


@pytest.fixture(scope="module")
def law():
    return wucht.run(CamCorrection(points=36), cam_drive_from({"law": LAW_TABLE, "speed": SPEED}, "Law", None))


def legend(drawn):
    return [text.get_text() for text in drawn.legends[0].get_texts()]


def lines(axis):
    return {drawn.get_label(): drawn for drawn in axis.get_lines()}


@pytest.mark.slow
def test_panels_of_cams_with_a_measured_acceleration(whole):
    drawn = wucht.draw(whole)
    assert [" ".join(a.get_ylabel().split()) for a in drawn.axes] == [
        "acceleration (rad/s²)", "acceleration, amplitude (rad/s²)", "speed of the shaft (rpm)", "speed, amplitude (rad/s)",
        "y (mm)", "moved outwards (mm)", "pressure angle (°)", "radius of curvature (mm)",
        "measured (rad/s²)", "measured, amplitude (rad/s²)",
    ]  # fmt: skip
    assert set(legend(drawn)) == {
        "original cam", "corrected cam", "corrected, from its points", "10⁻⁶ of order 1, or less", "mean speed",
        "left out, in the record", "base circle", "roller", "counter cam", "common limit", "measured, samples",
        "measured (orders fitted)",
    }  # fmt: skip
    assert len(legend(drawn)) == len(set(legend(drawn)))
    words = [" ".join(text.get_text().split()) for text in drawn.texts]
    assert any(whole.attrs["sentence"] in text for text in words), "below the title, which has two lines at most"


def test_no_two_things_look_alike_in_the_legend(whole):
    looks = [
        (h.get_linestyle(), h.get_marker(), h.get_color(), h.get_linewidth()) for h in wucht.draw(whole).legends[0].get_lines()
    ]
    assert len(looks) == len(set(looks)) == 11


@pytest.mark.slow
def test_the_difference_of_the_contours_is_drawn(whole):
    moved = wucht.draw(whole).axes[5].get_lines()
    for line, name in zip(moved[1:], ("cam", "counter"), strict=True):
        assert line.get_ydata() == pytest.approx(1e3 * whole.moved.sel(cam=name).values)
    fine = whole.assign(moved=whole.moved / 100)
    assert wucht.draw(fine).axes[5].get_ylabel() == "moved outwards (µm)"


def test_a_measured_acceleration_is_drawn_with_its_samples(whole):
    time, spectrum = wucht.draw(whole).axes[-2:]
    assert spectrum.get_yscale() == "log"
    assert min(bar.get_y() + bar.get_height() for bar in spectrum.patches) > spectrum.get_ylim()[0]
    dots = time.get_lines()[0]
    assert len(dots.get_xdata()) == whole.sizes["sample"] == 3000
    assert 0 <= dots.get_xdata().min() < dots.get_xdata().max() <= time.get_xlim()[1]
    # Noise of 50 rad/s^2 beside the orders that were fitted to all of the record.
    fitted = np.interp(dots.get_xdata(), 1e3 * whole.time.values, whole.measured_acceleration.values)
    assert np.std(dots.get_ydata() - fitted) == pytest.approx(50, rel=0.15)


def test_what_is_drawn(whole):
    time, spectrum, speed, _, contour, *_ = wucht.draw(whole).axes
    after = lines(time)["corrected cam"]
    assert after.get_ydata() == pytest.approx(whole.acceleration.sel(version="corrected").values)
    assert after.get_xdata()[-1] == pytest.approx(1e3 * 2 * np.pi / whole.wucht.summary["mean_speed"])
    assert spectrum.get_yscale() == "log"
    least, reference = spectrum.get_ylim()[0], float(whole.amplitude.sel(version="corrected", order=1))
    assert least == pytest.approx(0.5e-6 * reference)
    tops = [bar.get_y() + bar.get_height() for bar in spectrum.patches]
    assert min(tops) == pytest.approx(1e-6 * reference)
    assert max(speed.get_lines()[0].get_ydata()) == pytest.approx(30 / np.pi * float(whole.shaft_speed.max()))
    assert contour.get_aspect() == 1
    x = contour.get_lines()[1].get_xdata()
    assert x[0] == x[-1] == pytest.approx(1e3 * float(whole.contour_x.sel(version="corrected", cam="cam")[0]))
    assert [drawn.get_linestyle() for drawn in contour.get_lines()[:2]] == ["--", "-"]


def test_a_law_alone_has_its_table_instead_of_a_contour(law):
    drawn = wucht.draw(law)
    assert [" ".join(a.get_ylabel().split()) for a in drawn.axes[4:]] == [
        "motion in the cam (°)",
        "acceleration in the cam (°/rad²)",
    ]
    assert set(legend(drawn)) == {"original cam", "corrected cam", "10⁻⁶ of order 1, or less", "mean speed"}


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
@pytest.mark.filterwarnings("error")
def test_every_format(whole, ending):
    file = io.BytesIO()
    wucht.draw(whole).savefig(file, format=ending)
    assert file.getbuffer().nbytes > 20_000


@pytest.mark.filterwarnings("error")
def test_more_orders_may_be_measured_than_are_proved(whole):
    recovered = whole.recovered.where(whole.order < 12)
    dots = lines(wucht.draw(whole.assign(recovered=recovered)).axes[1])["corrected, from its points"]
    assert np.flatnonzero(np.isfinite(dots.get_ydata())).tolist() == list(range(11)) and len(dots.get_ydata()) > 11


@pytest.mark.filterwarnings("error")
def test_a_shaft_that_turns_evenly_and_a_flat_face_can_be_drawn():
    tables = {"law": {"kind": "harmonic", "coefficients": {"mean": 0.0, "cosine": [0.005], "sine": []}},
              "speed": {"mean": 50.0}, "follower": {"kind": "flat-faced", "distance": 0.05}}  # fmt: skip
    result = wucht.run(CamCorrection(points=72), cam_drive_from(tables, "Even", None))
    drawn = wucht.draw(result)
    drawn.savefig(io.BytesIO(), format="png")
    assert "face" in legend(drawn)
    assert "it turns evenly" in "\n".join(wucht.report(result))


def test_the_report_says_what_an_engineer_asks(whole):
    text = wucht.report(whole)
    assert text[0] == "Two cams"
    assert text[1].startswith("verdict: CLEAN: orders above 5")
    assert len(text) < 20
    whole_text = "\n".join(text)
    for words in (
        "52.36 rad/s (500 rpm), a turn in 120 ms; it fluctuates by 15.2", "in orders 2, 3, 4, 5", "7.4 turns, 6000 samples",
        "0.482 rpm rms left; the noise leaves about", "no order left out matters", "a mean speed off by 10 %", "off by 1°",
        "an order of the speed is left out: 52 % (2), 28 % (3)", "moved by 0.7", "50.47 of", "(100.0 % of its 15 orders; ",
        "pressure angle at most 26.1°", "counter ",
        "rounded to 5 decimals of a mm", "explained by the computed motion of the original cam",
    ):  # fmt: skip
        assert words in whole_text


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
    text = "\n".join(wucht.report(result))
    for words in ("11.1 rpm rms left", "the orders left out about 29 %", "order 3 (15.", "of the speed), which leaves"):
        assert words in text
    assert "orders of the record that are not corrected leave about 0.29" in result.attrs["sentence"]
    bars = [
        bar for bar in wucht.draw(result).axes[3].patches if bar.get_facecolor()[:3] == pytest.approx((0.733,) * 3, abs=1e-2)
    ]
    assert max(bar.get_height() for bar in bars) == pytest.approx(three["amplitude"])


def acceleration(folder, **asked):
    """A report beside a record of the acceleration with its zero at ZERO."""
    write(folder / "record.csv", noise=0.05)
    drive = cam_drive_from({"law": LAW_TABLE, "speed": SPEED}, "Measured", folder)
    given = {"file": "record.csv", "column": "acceleration", "zero": ZERO, **asked}
    return wucht.run(CamCorrection(points=36, acceleration=given), drive)


def test_a_delay_is_told_and_taken_out(tmp_path):
    late = 5 / 360 * 2 * np.pi / SHAFT.mean
    result = acceleration(tmp_path, zero=ZERO - late)
    m = result.wucht.summary["measured"]
    assert m["explained"] < 0.95
    assert m["explained_without_delay"] > 0.999
    assert np.degrees(m["delay"]) == pytest.approx(5, abs=0.1)
    assert "it comes 4.99° (1.66 ms) later than computed; without it 100.0 % of its orders" in "\n".join(wucht.report(result))
    (said,) = (w for w in result.wucht.warnings if "later than" in w)
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
    assert f"of its 3 orders; {m['noise_rms']:.4g} of {m['rms']:.4g} rad/s² rms lie outside" in "\n".join(wucht.report(result))
    (said,) = (w for w in result.wucht.warnings if w.startswith("Only 3 orders are fitted"))
    enough = int(said.split("orders = ")[1].rstrip("."))
    assert 5 < enough < 15
    assert not any("orders are fitted" in w for w in acceleration(tmp_path, orders=enough).wucht.warnings)


def test_a_dataset_that_is_no_correction_is_refused(law):
    with refused("cam-correction", given=None):
        wucht.draw(law.drop_vars("amplitude"))
