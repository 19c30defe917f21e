"""The study cam-correction: numbers before and after, the proof from the points, what is left, its file and its Dataset."""

import math

import numpy as np
import pytest
from known_cam import LAW, OMEGA, SHAFT, acceleration

import wucht
from wucht import CamCorrection, run_file
from wucht.cams.correction import MotionOverTime, orders, share_above_order
from wucht.cams.drive import cam_drive_from
from wucht.numerics.fourier_series import FourierSeries, even_angles
from wucht.studies.registry import study_of

pytestmark = pytest.mark.usefixtures("coarse_angles")

LAW_TABLE = {"kind": "harmonic", "coefficients": {"mean": LAW.mean, "cosine": [*LAW.cosine], "sine": [*LAW.sine]}}
SPEED = {"mean": OMEGA, "cosine": [*SHAFT.speed.cosine], "sine": [*SHAFT.speed.sine]}


def answered(spec=None, **tables):
    given = {"law": LAW_TABLE, "speed": SPEED, **tables}
    return wucht.run(spec or CamCorrection(points=180), cam_drive_from(given, "drive", None))


@pytest.fixture(scope="module")
def template(tmp_path_factory):
    path = tmp_path_factory.mktemp("cam") / "correction.toml"
    path.write_text(study_of("cam-correction").template, encoding="utf-8")
    return run_file(path)


def test_the_template_is_clean_and_its_points_prove_it(template):
    """Issue 11: from 1440 points orders above N below 1e-9 of order 1; the original cam has orders N + 1 to 2 N."""
    s = template.wucht.summary
    assert s["harmonics"] == 5
    assert s["after"] < 1e-12
    assert s["before"] > 0.1
    assert s["points"] == 1440
    assert s["recovered"]["cam"] < 1e-11
    assert 1e-8 < s["rounded"]["cam"] < 1e-4
    assert len(s["orders_before"]) == len(s["orders_after"]) == template.sizes["order"] == 24
    assert min(s["orders_before"][5:10]) > 5e-3 * s["orders_before"][0]
    assert max(s["orders_after"][5:]) < 1e-12 * s["orders_after"][0]
    assert s["sentence"].startswith("CLEAN: orders above 5 are below 1e-12 of order 1 (before: 0.56); from 1440 points")


def test_the_orders_are_those_of_an_integral_by_hand(template):
    """Of psi''(tau) over time by the trapezoidal rule, which is exact for a periodic function."""
    tau = even_angles(512)
    for version, values in (("original", acceleration(LAW, tau)), ("corrected", OMEGA**2 * LAW(tau, 2))):
        for k in (1, 4, 7):
            a, b = 2 * np.mean(values * np.cos(k * tau)), 2 * np.mean(values * np.sin(k * tau))
            of = template.sel(version=version, order=k)
            # The template's law is found by a linear programme: like the closed form to about 1e-6.
            assert [float(of.cosine), float(of.sine)] == pytest.approx([a, b], abs=2e-2)
        made = acceleration(LAW, template.tau.values) if version == "original" else OMEGA**2 * LAW(template.tau.values, 2)
        assert template.acceleration.sel(version=version).values == pytest.approx(made, abs=0.1)


def test_recovered_orders_are_the_laws_own(template):
    """Not only those above N vanish: the others are there, as the corrected cam should make them."""
    wanted = template.amplitude.sel(version="corrected").values
    assert template.recovered.sel(cam="cam").values == pytest.approx(wanted, abs=1e-10 * wanted.max())


def test_the_shaft_angle_is_004_equation_4(template):
    """errata.md: omega t + sum (a_j sin - b_j cos)/(j omega) + C; one turn in T = 2 pi/omega."""
    t, a, b = template.time.values, SHAFT.speed.cosine, SHAFT.speed.sine
    j = np.arange(1, 6)
    x = np.outer(t, j * OMEGA)
    phi = OMEGA * t + (np.sin(x) * a - (np.cos(x) - 1) * b) @ (1 / (j * OMEGA))
    assert template.shaft_angle.values == pytest.approx(phi, abs=1e-12)
    assert template.shaft_angle.values[-1] == pytest.approx(2 * math.pi, abs=1e-12)
    assert t[-1] == pytest.approx(0.12)
    assert template.shaft_speed.values == pytest.approx(np.gradient(phi, t), rel=2e-3)


def test_the_new_table_is_the_law_at_the_time_of_the_angle(template):
    """psi(phi(tau)) = law(tau), and each derivative is that of the one before it: by spectral differentiation."""
    corrected = template.sel(version="corrected")
    series = FourierSeries.from_samples(corrected.output.values)
    tau = np.linspace(0, 6, 50)
    assert series(SHAFT.angle(tau)) == pytest.approx(LAW(tau), abs=2e-6)
    for order, name in enumerate(("velocity", "acceleration", "jerk"), 1):
        of = corrected[f"output_{name}"].values
        assert of == pytest.approx(series(template.cam_angle.values, order), abs=1e-7 * np.abs(of).max())


def test_residuals_grow_with_what_is_wrong(template):
    s = template.wucht.summary
    left = {r["what"]: r["share"] for r in s["residuals"]}
    one, five = (left[f"the phase of the speed, or the cam on its shaft, off by {d}°"] for d in (1, 5))
    assert 0.01 < one < 0.05
    assert five == pytest.approx(5 * one, rel=0.05)
    # The mean 10 % lower and the same rad/s is a fluctuation of 1/0.9: ten ninths of what 110 % leave.
    slower = left["a mean speed off by 10 %, the fluctuation the same in rad/s"]
    assert slower == pytest.approx(left["110 % of the fluctuation"] * 10 / 9, rel=0.02)
    assert left["order 2 left out of the correction"] > 0.3
    assert template.share.values == pytest.approx([*left.values()])


def test_contours_before_and_after(template):
    s, points = template.wucht.summary, template.contour_x + 1j * template.contour_y
    cam = s["contours"]["cam"]
    assert (
        cam["corrected"]["max_pressure_angle"]
        == s["max_pressure_angle"]
        == pytest.approx(float(np.abs(template.pressure_angle.sel(version="corrected")).max()), rel=1e-5)
    )
    assert s["undercut"] is False
    assert s["min_curvature_radius"] == pytest.approx(1 / float(template.curvature.sel(version="corrected").max()), rel=1e-4)
    normal = template.normal_x + 1j * template.normal_y
    assert np.abs(normal.values) == pytest.approx(1)
    chords = np.diff(points.values, axis=-1)
    between = (normal.values[..., 1:] + normal.values[..., :-1]) / 2
    assert np.abs((chords.conj() * between).real).max() < 1e-4 * np.abs(chords).max()
    assert 1e-4 < cam["moved"] < 2e-3
    assert cam["corrected"]["largest_roller"] == pytest.approx(s["min_curvature_radius"] + 0.01, rel=1e-6)


def test_by_how_much_the_contour_has_moved(template):
    """Along the normal, outwards: the foot of each point on the original contour is that point moved back."""
    moved, cam = template.moved.sel(cam="cam").values, template.wucht.summary["contours"]["cam"]
    assert np.abs(moved).max() == cam["moved"]
    assert moved.max() > 5e-4
    assert moved.min() < -1e-4
    new, old = (template.sel(cam="cam", version=v) for v in ("corrected", "original"))
    back = new.contour_x + 1j * new.contour_y - moved * (new.normal_x + 1j * new.normal_y)
    points = (old.contour_x + 1j * old.contour_y).values
    chords = np.abs(np.diff(points)).max()
    apart = np.abs(back.values[:, None] - points[None, :]).min(axis=1)
    # No further than half a chord from the next point, and what the normals differ by: 0.8 mm times 3 degrees.
    assert apart.max() < 0.51 * chords
    sunk = np.hypot(new.contour_x, new.contour_y) - np.hypot(old.contour_x, old.contour_y)
    k = int(np.abs(moved).argmax())
    assert np.sign(float(sunk[k])) == np.sign(moved[k])


@pytest.mark.slow
def test_the_pressure_angle_is_judged_as_in_a_cam_contour(template):
    follower = {"kind": "oscillating-roller", "pivot": 0.03, "arm": 0.07, "roller_radius": 0.01, "angle": "-135 deg"}
    steep = answered(CamCorrection(points=36), follower=follower)
    drive = cam_drive_from({"law": LAW_TABLE, "speed": SPEED, "follower": follower}, "drive", None)
    contour = wucht.run(wucht.CamContour(points=16, chord_tolerance="1 mm", spacing="1 m", corrected=True), drive)
    (said,) = (w for w in steep.wucht.warnings if "pressure angle" in w)
    (there,) = (w for w in contour.wucht.warnings if "pressure angle" in w)
    assert there in said
    assert 'study.kind = "cam-contour"' in said
    assert steep.wucht.summary["max_pressure_angle"] == pytest.approx(contour.wucht.summary["max_pressure_angle"], rel=1e-12)
    assert steep.wucht.summary["min_curvature_radius"] == pytest.approx(
        contour.wucht.summary["min_curvature_radius"], rel=1e-12
    )
    assert math.degrees(steep.wucht.summary["max_pressure_angle"]) > 70
    assert "pressure angle" not in template.attrs["warnings"]


def test_a_constant_speed_changes_nothing():
    result = answered(speed={"mean": OMEGA}, follower={"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07,
                                                       "roller_radius": 0.01, "angle": math.radians(-135)})  # fmt: skip
    s = result.wucht.summary
    assert s["before"] < 1e-12
    assert s["contours"]["cam"]["moved"] < 1e-12
    for name in ("output", "output_jerk", "contour_x", "contour_y", "acceleration"):
        old, new = (result[name].sel(version=v).values for v in ("original", "corrected"))
        assert new == pytest.approx(old, abs=1e-11 * np.abs(old).max())
    assert [r["what"] for r in s["residuals"] if "left out" in r["what"]] == []


def test_without_a_follower_the_law_alone():
    result = answered()
    s = result.wucht.summary
    assert result.sizes["cam"] == 0
    assert (s["recovered"], s["contours"], s["undercut"]) == ({}, {}, None)
    assert s["before"] == pytest.approx(share_above_order(orders(MotionOverTime(LAW, SHAFT)), 5))
    assert result.follower.equals(result.output)
    assert wucht.draw(result).axes


@pytest.mark.slow
def test_an_output_behind_a_linkage_is_recovered_through_it():
    linkage = {"kind": "four-bar", "ground": 0.3, "input": 0.1, "coupler": 0.28, "output": 0.12, "angle": "80 deg"}
    follower = {"kind": "oscillating-roller", "pivot": 0.12, "arm": 0.07, "roller_radius": 0.01, "angle": "-135 deg"}
    result = answered(CamCorrection(points=720), linkage=linkage, follower=follower)
    s = result.wucht.summary
    assert s["recovered"]["cam"] < 1e-9
    wanted = result.amplitude.sel(version="corrected").values
    assert result.recovered.values[0] == pytest.approx(wanted, abs=1e-9 * wanted.max())
    assert float(np.abs(result.follower - result.output).max()) > 0.01


def test_a_flat_face_and_a_law_that_has_no_end_of_harmonics():
    law = {"kind": "modified-sine", "stroke": "10 mm", "rise": ["60 deg", "150 deg"], "return": ["210 deg", "300 deg"]}
    result = answered(CamCorrection(points=720), law=law, follower={"kind": "flat-faced", "distance": "80 mm"})
    s = result.wucht.summary
    assert s["harmonics"] is None
    assert s["after"] < 1e-11
    assert s["before"] > 0.05
    assert s["sentence"].startswith("CLEAN: orders differ from the law's by less than 1e-12 of order 1")
    assert result.acceleration.attrs["units"] == "m/s^2"
    assert result.sizes["order"] == 60, "as many as a figure shows"
    assert len(s["orders_before"]) == 250, "of a law whose orders never end the most that a study shows"
    assert np.isnan(result.roller_radius).all()
    assert wucht.draw(result).axes


def test_a_law_without_order_1_is_measured_by_the_first_there_is():
    twice = {"kind": "harmonic", "coefficients": {"mean": 0.0, "cosine": [0.0, 0.1], "sine": []}}
    s = answered(law=twice).wucht.summary
    assert s["reference_order"] == 2
    assert "of order 2" in s["sentence"]
    assert 0.01 < s["before"] < 10
    assert s["after"] < 1e-12


@pytest.mark.slow
def test_a_groove_has_two_flanks_and_both_prove_it():
    follower = {"kind": "translating-roller", "distance": 0.08, "roller_radius": 0.01, "groove": True}
    law = {"kind": "harmonic", "coefficients": {"mean": 0.005, "cosine": [-0.005, 0.001], "sine": []}}
    result = answered(CamCorrection(points=720), law=law, follower=follower)
    assert list(result.cam.values) == ["cam", "outer"]
    assert max(result.wucht.summary["recovered"].values()) < 1e-9
    apart = result.sel(cam="outer", version="corrected"), result.sel(cam="cam", version="corrected")
    assert np.hypot(*(apart[0][c].values - apart[1][c].values for c in ("contour_x", "contour_y"))) == pytest.approx(0.02)


def test_few_points_are_told():
    follower = {"kind": "flat-faced", "distance": 0.05}
    law = {"kind": "harmonic", "coefficients": {"mean": 0.005, "cosine": [-0.005, 0.0005], "sine": []}}
    result = answered(CamCorrection(points=48), law=law, follower=follower)
    assert result.wucht.summary["recovered"]["cam"] > 1e-9
    assert "which more points reduce" in result.attrs["sentence"]
    (warning,) = [w for w in result.wucht.warnings if w.startswith("Chords between 48 points")]
    needed = int(warning.split("points = ")[1].split(",")[0])
    chord = result.wucht.summary["contours"]["cam"]["chord"]
    assert f"leave the contour by {1e6 * chord:.3g} um, more than the tolerance of 1 um" in warning
    assert needed == math.ceil(1.01 * 48 * math.sqrt(chord / 1e-6))
    loose = answered(CamCorrection(points=48, chord_tolerance=chord * (1 + 1e-9)), law=law, follower=follower)
    assert "Chords" not in loose.attrs["warnings"]
    enough = answered(CamCorrection(points=needed), law=law, follower=follower)
    assert "Chords" not in enough.attrs["warnings"]


@pytest.mark.slow
def test_interrupted_it_is_taken_up_where_it_was(tmp_path):
    """Contours and their proofs are units of work with names, and progress tells them."""
    follower = {"kind": "translating-roller", "distance": 0.08, "roller_radius": 0.01}
    law = {"kind": "harmonic", "coefficients": {"mean": 0.005, "cosine": [-0.005, 0.001], "sine": []}}
    drive, asked = cam_drive_from({"law": law, "speed": SPEED, "follower": follower}, "drive", None), CamCorrection(points=72)
    told: list[tuple[float, str]] = []

    def stop(share, what):
        told.append((share, what))
        if what.startswith("motion from the points"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        wucht.run(asked, drive, folder=tmp_path, progress=stop)
    assert [what for _, what in told[1:]] == ["corrected cam", "original cam", "motion from the points of the corrected cam"]
    assert sorted(share for share, _ in told) == [share for share, _ in told]
    whole = wucht.run(asked, drive)
    for result in (wucht.run(asked, drive, folder=tmp_path, resume=True) for _ in range(2)):
        assert result.attrs["finished"] == 1
        for name in whole.variables:
            assert result[name].equals(whole[name])
    assert [f.name for f in tmp_path.iterdir()] == ["result.nc"]


@pytest.mark.parametrize("shown", [None, 3])
def test_orders_are_listed_to_the_last_that_is_not_negligible(shown):
    """psi = 0.2 cos phi, the speed fluctuating in order 3: order 4 is the largest after order 1, and order 12 is the last.

    By a Fourier transform of the second differences of psi over time, which know nothing of the derivatives by the angle.
    """
    law = {"kind": "harmonic", "coefficients": {"mean": 0.0, "cosine": [0.2], "sine": []}}
    omega, swing, n = 52.36, 8.0, 2**16
    spec = CamCorrection(points=180) if shown is None else CamCorrection(points=180, orders=shown)
    result = answered(spec, law=law, speed={"mean": omega, "cosine": [0, 0, swing]})
    tau = even_angles(n)
    psi = np.fft.rfft(0.2 * np.cos(tau + swing / (3 * omega) * np.sin(3 * tau))) / n * 2
    by_hand = np.abs(psi) * (omega * np.arange(len(psi))) ** 2
    listed = np.array([0.0, *result.wucht.summary["orders_before"]])
    assert listed == pytest.approx(by_hand[: len(listed)], rel=1e-9, abs=1e-9 * by_hand.max())
    assert int(np.argsort(listed)[-2]) == 4
    assert listed[-1] > 1e-9 * listed.max() > by_hand[len(listed) : 40].max()
    assert result.sizes["order"] == (len(listed) - 1 if shown is None else shown)


@pytest.mark.parametrize("arm", [0.07, None])
def test_the_position_error_in_the_dwell_is_that_of_the_motion_over_time(arm):
    """Directly: the angle of the shaft by a numerical integral of its speed, the output by its law at that angle."""
    restrictions = [{"at": "180 deg", "equals": "24 deg"}, {"on": ["-120 deg", "100 deg"], "equals": "0 deg"}]
    law = {"kind": "harmonic", "harmonics": 5, "restrictions": restrictions}
    speed = {"mean": OMEGA, "cosine": [3.0, 2.4], "sine": [0, 1]}
    roller = {"kind": "oscillating-roller", "pivot": 0.12, "roller_radius": 0.01, "angle": "-135 deg"}
    tables = {"law": law, "speed": speed} | ({} if arm is None else {"follower": roller | {"arm": arm}})
    result = answered(CamCorrection(points=36, decimals=3), **tables)
    s, motion = result.wucht.summary, cam_drive_from(tables, "", None).motion_law.function
    tau = np.linspace(-math.radians(120), math.radians(100), 200_001)
    rate = 1 + (3 * np.cos(tau) + 2.4 * np.cos(2 * tau) + np.sin(2 * tau)) / OMEGA
    steps = np.append(0.0, np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(tau)))
    phi = steps - np.interp(0.0, tau, steps)
    before, after = np.abs(motion(phi)).max(), np.abs(motion(tau)).max()
    assert s["dwells"] == [pytest.approx([tau[0], tau[-1]])]
    assert [s["dwell_error_before"], s["dwell_error_after"]] == pytest.approx([before, after], rel=1e-6)
    assert before > 2 * after > 0
    lengths = None if arm is None else [arm * before, arm * after]
    found = [s["dwell_travel_before"], s["dwell_travel_after"]]
    assert found == ([None, None] if lengths is None else pytest.approx(lengths, rel=1e-6))
    assert wucht.report(result)


def test_positions_off_the_dwell_of_a_slide_and_of_a_law_that_never_rests():
    law = {"kind": "3-4-5", "stroke": "20 mm", "rise": ["20 deg", "120 deg"], "return": ["160 deg", "300 deg"]}
    s = answered(CamCorrection(points=36, decimals=3), law=law).wucht.summary
    assert s["unit"] == "m" and s["dwell_travel_before"] == s["dwell_error_before"] > 1e-8
    s = answered(
        CamCorrection(points=36), law={"kind": "harmonic", "coefficients": {"mean": 0.0, "cosine": [0.2]}}
    ).wucht.summary
    assert (s["dwells"], s["dwell_error_before"]) == ([], None)
