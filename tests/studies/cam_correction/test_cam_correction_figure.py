"""The figure and the sentences of the study cam-correction, from the Dataset alone."""

import io

import numpy as np
import pytest
from known_cam import LAW, SHAFT, ZERO, write

import wucht
from wucht.cams.drive import drive_from
from wucht.errors import InputError
from wucht.studies.cam_correction.spec import CamCorrection

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
    drive = drive_from({"law": LAW_TABLE, "follower": LEVER, "speed": speed}, "Two cams", folder)
    acceleration = {"file": "record.csv", "column": "acceleration", "zero": ZERO}
    return wucht.run(CamCorrection(points=360, acceleration=acceleration), drive)


@pytest.fixture(scope="module")
def law():
    return wucht.run(CamCorrection(points=36), drive_from({"law": LAW_TABLE, "speed": SPEED}, "Law", None))


def legend(drawn):
    return [text.get_text() for text in drawn.legends[0].get_texts()]


def lines(axis):
    return {drawn.get_label(): drawn for drawn in axis.get_lines()}


def test_panels_of_cams_with_a_measured_acceleration(whole):
    drawn = wucht.draw(whole)
    assert [a.get_ylabel() for a in drawn.axes] == [
        "acceleration (rad/s²)", "amplitude (rad/s²)", "camshaft (rpm)", "speed, amplitude (rad/s)", "y (mm)",
        "pressure angle (°)", "acceleration (rad/s²)", "amplitude (rad/s²)",
    ]  # fmt: skip
    assert len(legend(drawn)) == len(set(legend(drawn)))
    assert {
        "original cam",
        "corrected cam",
        "corrected, from its points",
        "base circle",
        "roller",
        "counter cam",
        "measured",
    } <= set(legend(drawn))
    assert whole.attrs["sentence"] in drawn.get_suptitle()


def test_what_is_drawn(whole):
    time, spectrum, speed, _, contour, *_ = wucht.draw(whole).axes
    after = lines(time)["corrected cam"]
    assert after.get_ydata() == pytest.approx(whole.acceleration.sel(version="corrected").values)
    assert after.get_xdata()[-1] == pytest.approx(1e3 * 2 * np.pi / whole.wucht.summary["mean_speed"])
    assert spectrum.get_yscale() == "log"
    least, reference = spectrum.get_ylim()[0], float(whole.amplitude.sel(version="corrected", order=1))
    assert least == pytest.approx(0.5e-12 * reference)
    tops = [bar.get_y() + bar.get_height() for bar in spectrum.patches]
    assert min(tops) == pytest.approx(1e-12 * reference)
    assert max(speed.get_lines()[0].get_ydata()) == pytest.approx(30 / np.pi * float(whole.shaft_speed.max()))
    assert contour.get_aspect() == 1
    x = contour.get_lines()[1].get_xdata()
    assert x[0] == x[-1] == pytest.approx(1e3 * float(whole.contour_x.sel(version="corrected", cam="cam")[0]))
    assert [drawn.get_linestyle() for drawn in contour.get_lines()[:2]] == ["--", "-"]


def test_a_law_alone_has_its_table_instead_of_a_contour(law):
    drawn = wucht.draw(law)
    assert [a.get_ylabel() for a in drawn.axes[4:]] == ["motion in the cam (°)", "acceleration in the cam (°/rad²)"]
    assert set(legend(drawn)) == {"original cam", "corrected cam", "1e-12 of order 1, or less", "mean speed"}


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
@pytest.mark.filterwarnings("error")
def test_every_format(whole, ending):
    file = io.BytesIO()
    wucht.draw(whole).savefig(file, format=ending)
    assert file.getbuffer().nbytes > 20_000


@pytest.mark.filterwarnings("error")
def test_a_shaft_that_turns_evenly_and_a_flat_face_can_be_drawn():
    tables = {"law": {"kind": "harmonic", "coefficients": {"mean": 0.0, "cosine": [0.005], "sine": []}},
              "speed": {"mean": 50.0}, "follower": {"kind": "flat-faced", "distance": 0.05}}  # fmt: skip
    result = wucht.run(CamCorrection(points=72), drive_from(tables, "Even", None))
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
        "off by 1°", "an order of the speed is left out: 52 % (2), 28 % (3)", "pressure angle at most 26.1°", "counter ",
        "rounded to 5 decimals of a mm", "explained by the motion computed for the original cam",
    ):  # fmt: skip
        assert words in whole_text


def test_a_dataset_that_is_no_correction_is_refused(law):
    with pytest.raises(InputError, match="no complete result"):
        wucht.draw(law.drop_vars("amplitude"))
