"""The figure and the sentences of the study cam-correction, from the Dataset alone."""

import io
import math

import numpy as np
import pytest
from known_cam import LAW, SHAFT, ZERO, write
from matplotlib.colors import to_hex
from tests.refusals import refused

import wucht
from wucht import CamCorrection
from wucht.cams.drive import cam_drive_from
from wucht.plots.style import COLOURS

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


@pytest.fixture(scope="module")
def known(whole):
    """That result with orders and errors that are known, in eight orders."""
    made, nan = whole.isel(order=slice(0, 8)).copy(deep=True), math.nan
    made.amplitude.values[:] = [[500, 200, 0, 0, 0, 100, 0, 0], [500, 250, 0, 0, 125, 0, 0, 0]]
    made.recovered.values[:] = [[500, 0, 0, 0, 0, 1e-9, 0, 0], [400, 0, 0, 0, 0, 2e-8, 0, 0]]
    made.speed_error.values[:] = [nan, 0.3, nan, 0.4, nan]
    made.computed_amplitude.values[:] = [50, 10, *[nan] * 6]
    made.measured_amplitude.values[:] = [50, 20, 10, *[nan] * 5]
    return made


@pytest.fixture(scope="module")
def axes(known):
    return wucht.draw(known).axes


def bars(axis):
    """Middle, bottom, top and colour of each bar that is there."""
    places = [
        (b.get_x() + b.get_width() / 2, b.get_y(), b.get_y() + b.get_height(), to_hex(b.get_facecolor())) for b in axis.patches
    ]
    return [bar for bar in places if np.isfinite(bar[2])]


def test_the_orders_of_both_versions_stand_side_by_side_above_a_floor(axes):
    """A millionth of order 1 of the corrected cam, 500; up to one order beyond the last above it."""
    spectrum, floor = axes[1], 5e-4
    amplitudes = [500, 200, floor, floor, floor, 100, floor], [500, 250, floor, floor, 125, floor, floor]
    for values, side, colour in zip(amplitudes, (-0.2, 0.2), (COLOURS[1], COLOURS[0]), strict=True):
        mine = [bar for bar in bars(spectrum) if (bar[0] % 1 > 0.5) == (side < 0)]
        assert [bar[0] for bar in mine] == pytest.approx([j + side for j in range(1, 8)])
        assert [bar[2] for bar in mine] == pytest.approx(values)
        assert {bar[3] for bar in mine} == {to_hex(colour)} and [bar[1] for bar in mine] == pytest.approx([floor / 2] * 7)
    dots = lines(spectrum)["corrected, from its points"]
    assert dots.get_ydata() == pytest.approx([500, *[floor] * 6]), "the larger of both cams"
    line = next(x for x in spectrum.get_lines() if x.get_linestyle() == "-.")
    assert line.get_ydata()[0] == pytest.approx(floor) and line.get_label() == "10⁻⁶ of order 1, or less"
    assert spectrum.get_ylim() == pytest.approx((floor / 2, 1500)) and spectrum.get_xlim() == (0.3, 7.7)
    ticks = spectrum.get_yticks()
    assert ticks[1] / ticks[0] == pytest.approx(1e3) and floor <= ticks[0] < 10 * floor
    assert spectrum.get_xticks().tolist() == list(range(1, 8))


def test_orders_of_the_speed_have_their_errors_and_the_mean_its_line(known, axes):
    _, _, speed, orders, *_ = axes
    mean = known.wucht.summary["mean_speed"]
    assert lines(speed)["mean speed"].get_ydata()[0] == pytest.approx(30 / math.pi * mean)
    assert speed.get_lines()[0].get_xdata() == pytest.approx(1e3 * known.time.values)
    assert speed.get_xlim() == pytest.approx((0.0, 2e3 * math.pi / mean))
    (segments,) = [c.get_segments() for c in orders.collections]
    spans = {round(float(s[0, 0])): float(s[1, 1] - s[0, 1]) / 2 for s in segments if len(s) and np.isfinite(s).all()}
    assert spans == pytest.approx({2: 0.3, 4: 0.4})
    assert [bar[2] for bar in bars(orders)][:5] == pytest.approx(known.speed_amplitude.values)


def test_the_versions_of_each_cam_have_its_colour_and_the_original_is_dashed(known, axes):
    degrees = np.degrees(known.cam_angle.values)
    history, contour, moved, pressure, radius = axes[0], *axes[4:8]
    looks = [("original", COLOURS[1]), ("corrected", COLOURS[0])]
    assert [(line.get_label(), line.get_color()) for line in history.get_lines()] == [(f"{v} cam", c) for v, c in looks]
    contours = [line for line in contour.get_lines() if len(line.get_xdata()) == 361]
    for drawn in (contours, pressure.get_lines()[:4], radius.get_lines()[:4]):
        assert [line.get_color() for line in drawn] == [COLOURS[1], COLOURS[0], COLOURS[2], COLOURS[2]]
        assert [line.get_linestyle() for line in drawn] == ["--", "-"] * 2
    assert [line.get_color() for line in moved.get_lines()[1:]] == [COLOURS[0], COLOURS[2]]
    for k, (cam, version) in enumerate(((0, 0), (0, 1), (1, 0), (1, 1))):
        assert contours[k].get_xdata()[:-1] == pytest.approx(1e3 * known.contour_x.values[version, cam])
        assert pressure.get_lines()[k].get_ydata() == pytest.approx(np.degrees(known.pressure_angle.values[version, cam]))
        drawn = radius.get_lines()[k].get_ydata()
        assert drawn[np.isfinite(drawn)] == pytest.approx(1e3 / known.curvature.values[version, cam][np.isfinite(drawn)])
    for line, row in zip(moved.get_lines()[1:], known.moved.values, strict=True):
        assert line.get_xdata() == pytest.approx(degrees) and line.get_ydata() == pytest.approx(1e3 * row)
    limits = [x.get_ydata()[0] for x in pressure.get_lines() if x.get_linestyle() == ":"]
    assert limits == pytest.approx([45.0, -45.0])


def test_the_rollers_and_the_base_circle_are_those_of_the_corrected_cam(known, axes):
    circles = [line.get_data() for line in axes[4].get_lines() if len(line.get_xdata()) == 181]
    found = [((max(x) + min(x)) / 2, (max(y) + min(y)) / 2, (max(x) - min(x)) / 2) for x, y in circles]
    centres = 1e3 * known.follower_x.values, 1e3 * known.follower_y.values
    assert np.hypot(centres[0] - 120, centres[1]) == pytest.approx([70, 70]), "on the arms of the lever about its pivot"
    base = (0.0, 0.0, 1e3 * float(known.base_radius[1, 0]))
    for circle, expected in zip(found, (base, *((x, y, 10.0) for x, y in zip(*centres, strict=True))), strict=True):
        assert circle == pytest.approx(expected, rel=1e-3, abs=1e-2)


def test_measured_orders_have_the_colours_of_the_lines_over_time(known, axes):
    """Left of each order the computed bar, of the original cam; right of it the measured one."""
    history, orders = axes[-2:]
    computed, measured = to_hex(COLOURS[1]), to_hex(COLOURS[6])
    assert [(bar[0], bar[2], bar[3]) for bar in bars(orders)] == [
        *((pytest.approx(k - 0.2), pytest.approx(a), computed) for k, a in ((1, 50), (2, 10))),
        *((pytest.approx(k + 0.2), pytest.approx(a), measured) for k, a in ((1, 50), (2, 20), (3, 10))),
    ]
    drawn = {line.get_linewidth(): line for line in history.get_lines()}
    assert (drawn[2.6].get_color(), drawn[0.9].get_color()) == (COLOURS[1], COLOURS[6])
    assert drawn[2.6].get_ydata() == pytest.approx(known.acceleration.values[0]), "of the cam that was measured"
    assert drawn[0.9].get_ydata() == pytest.approx(known.measured_acceleration.values)


@pytest.mark.parametrize(("count", "ticks", "moved", "unit", "words", "least", "floor"), [
    (15, [*range(1, 16)], 1e-4, "mm", [], 1.0, 0.5), (16, [*range(2, 17, 2)], 0.99e-4, "µm", ["hollow"], 1e-9, 1e-3),
    (3, [1, 2, 3], 1e-4, "mm", [], 99.0, 1.0), (3, [1, 2, 3], 1e-4, "mm", [], 4e-3, 2e-3),
])  # fmt: skip
def test_scales_are_chosen_by_what_is_drawn(whole, count, ticks, moved, unit, words, least, floor):
    """Orders that can be read; displacements below 0.1 mm in µm; hollow stretches are named; orders that are measured begin at
    half of the least, but a hundred thousandth to a hundredth of the largest, 100."""
    made = whole.isel(order=slice(0, count)).copy(deep=True)
    made.moved.values[:] *= moved / np.abs(made.moved.values).max()
    made.curvature.values[:] = np.abs(made.curvature.values)
    if words:
        made.curvature.values[1, 0, 3] *= -1
    made.measured_amplitude.values[:], made.computed_amplitude.values[:] = math.nan, 100.0
    made.measured_amplitude.values[:3] = 100.0, 99.0, least
    axes = wucht.draw(made).axes
    assert axes[-1].get_xticks().tolist() == ticks
    assert axes[5].get_ylabel() == f"moved outwards ({unit})"
    assert max(np.abs(line.get_ydata()).max() for line in axes[5].get_lines()[1:]) == pytest.approx(
        moved * (1e3 if unit == "mm" else 1e6)
    )
    assert [t.get_text() for t in axes[7].texts] == words
    assert axes[-1].get_ylim() == pytest.approx((floor / 2, 300.0))
    decades = axes[-1].get_yticks()
    assert decades[1] / decades[0] == pytest.approx(10.0) and 1.0 <= decades[0] / floor * 1.0001 < 10.1


def test_a_flat_face_is_drawn_over_the_height_of_the_contour(known):
    flat = known.copy(deep=True)
    flat.roller_radius.values[:] = np.nan
    contour, _, motion, _ = wucht.draw(flat).axes[4:8]
    faces = [line for line in contour.get_lines() if line.get_label() == "face"]
    for face, x, y in zip(faces, flat.follower_x.values, flat.contour_y.values[1], strict=True):
        assert list(face.get_xdata()) == pytest.approx([1e3 * x] * 2)
        assert list(face.get_ydata()) == pytest.approx([1e3 * y.min(), 1e3 * y.max()]), "of the corrected contour"
    for k, line in enumerate(motion.get_lines()[:2]):
        assert line.get_ydata() == pytest.approx(np.degrees(flat.output.values[k]))
    assert motion.get_ylabel() == "motion in the cam (°)"


def test_a_law_alone_has_its_table_instead_of_a_contour(law):
    drawn = wucht.draw(law)
    assert [" ".join(a.get_ylabel().split()) for a in drawn.axes[4:]] == [
        "motion in the cam (°)",
        "acceleration in the cam (°/rad²)",
    ]
    assert set(legend(drawn)) == {"original cam", "corrected cam", "10⁻⁶ of order 1, or less", "mean speed"}
    for axis, name in zip(drawn.axes[4:], ("output", "output_acceleration"), strict=True):
        for k, line in enumerate(axis.get_lines()):
            assert line.get_ydata() == pytest.approx(np.degrees(law[name].values[k]))


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


def test_the_lines_of_the_report(whole):
    """Numbers of the summary, in the formats of the trade; a distance from the law that is rounding is none."""
    s, d = whole.wucht.summary, math.degrees
    told = {line[2:15].strip(): line[15:] for line in wucht.report(whole)[2:] if line[2] != " "}
    r, m, cam = s["record"], s["measured"], s["contours"]["cam"]
    old, new = cam["original"], cam["corrected"]
    assert told["record"].startswith(f"7.4 turns, 6000 samples, orders explain {100 * r['explained']:.2f} %, ")
    noise = f"{float(format(100 * r['left_by_errors'], '.2g')):g} %"
    assert told["record"].endswith(f"; the noise leaves about {noise}, no order left out matters")
    assert s["position_error_after"] > 0
    assert told["acceleration"] == (
        f"at most {s['peak_after']:.4g} rad/s²; of the original cam {s['peak_before']:.4g} rad/s²; off the law over time by at "
        f"most 0°; with the original cam by {d(s['position_error_before']):.4g}°"
    )
    shares = ", ".join(f"{name} {share:.2g}" for name, share in s["recovered"].items())
    rounded = ", ".join(f"{share:.2g}" for share in s["rounded"].values())
    assert told["from points"] == f"{shares} of order 1; rounded to 5 decimals of a mm {rounded}"
    assert told["cam"] == (
        f"pressure angle at most {d(new['max_pressure_angle']):.3g}° at {d(new['max_pressure_angle_at']):.4g}° (original "
        f"{d(old['max_pressure_angle']):.3g}°), least radius of curvature {1e3 * new['min_curvature_radius']:.4g} mm "
        f"({1e3 * old['min_curvature_radius']:.4g} mm)"
    )
    sizes = [f"largest {what} {1e3 * new[key]:.4g} mm" for what, key in (
        ("roller", "largest_roller"), ("grinding wheel", "largest_wheel")) if new[key] is not None]  # fmt: skip
    assert f"               moved by {1e3 * cam['moved']:.4g} mm at most, not undercut, {', '.join(sizes)}" in wucht.report(
        whole
    )
    outside = f"{m['noise_rms']:.4g} of {m['rms']:.4g} rad/s² rms lie outside these"
    assert told["measured"] == (
        f"7.4 turns: {100 * m['explained']:.1f} % explained by the computed motion of the original cam "
        f"({100 * m['explained_orders']:.1f} % of its 15 orders; {outside})"
    )
    assert [s["min_curvature_radius"], s["max_pressure_angle"]] == [
        choose(one["corrected"][key] for one in s["contours"].values())
        for choose, key in ((min, "min_curvature_radius"), (max, "max_pressure_angle"))
    ]


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


@pytest.mark.parametrize(("sign", "word"), [(1, "later"), (-1, "earlier")])
def test_a_delay_is_told_and_taken_out(tmp_path, sign, word):
    late = sign * 5 / 360 * 2 * np.pi / SHAFT.mean
    result = acceleration(tmp_path, zero=ZERO - late)
    m = result.wucht.summary["measured"]
    assert m["explained"] < 0.95
    assert m["explained_without_delay"] > 0.999
    assert np.degrees(m["delay"]) == pytest.approx(5 * sign, abs=0.1)
    by = f"{abs(np.degrees(m['delay'])):.3g}° ({abs(1e3 * m['delay'] / SHAFT.mean):.3g} ms) {word} than computed"
    assert f"it comes {by}; without it 100.0 % of its orders" in "\n".join(wucht.report(result))
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
    assert f"of its 3 orders; {m['noise_rms']:.4g} of {m['rms']:.4g} rad/s² rms lie outside" in "\n".join(wucht.report(result))
    (said,) = (w for w in result.wucht.warnings if w.startswith("Only 3 orders are fitted"))
    enough = int(said.split("orders = ")[1].rstrip("."))
    assert 5 < enough < 15
    assert not any("orders are fitted" in w for w in acceleration(tmp_path, orders=enough).wucht.warnings)


def test_a_dataset_that_is_no_correction_is_refused(law):
    with refused("cam-correction", given=None):
        wucht.draw(law.drop_vars("amplitude"))
