"""The study cam-law: its numbers, its file, its figure and its sentences."""

import math

import numpy as np
import pytest
from tests.refusals import check_refusal, refused

import wucht
from wucht import run_file
from wucht.cams.drive import laws
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.studies.registry import study_of


def of_template(tmp_path, **settings):
    path = tmp_path / "law.toml"
    path.write_text(study_of("cam-law").template)
    return run_file(path, settings)


def test_the_template_gives_the_flattest_dwell(tmp_path):
    result = of_template(tmp_path)
    s = result.wucht.summary
    assert s["ripple"] == pytest.approx(math.radians(24) * 243 / 29525, rel=1e-6)
    assert s["stroke"] == pytest.approx(math.radians(24) + s["ripple"], rel=1e-5)
    assert s["harmonics"] == 5
    assert result.position.sel(cam_angle=math.pi, method="nearest") == pytest.approx(math.radians(24))
    assert result.amplitude.values == pytest.approx(np.hypot(s["coefficients"]["cosine"], s["coefficients"]["sine"]))
    series = s["coefficients"]["mean"] + sum(
        a * np.cos(k * result.cam_angle.values) for k, a in enumerate(s["coefficients"]["cosine"], 1)
    )
    assert result.position.values == pytest.approx(series, abs=1e-6)
    assert result.acceleration.values == pytest.approx(np.gradient(result.velocity.values, result.cam_angle.values), abs=0.01)
    assert result.greatest.values[1] == pytest.approx(s["ripple"], rel=1e-6)
    assert result.least.values[1] == pytest.approx(-s["ripple"], rel=1e-6)


def test_from_the_command_line_keys_are_set_by_their_path(tmp_path):
    result = of_template(tmp_path, **{"law.harmonics": 6, "law.restrictions.1.equals": "12 deg", "study.points": 36})
    assert result.wucht.summary["harmonics"] == 6
    assert float(result.position.max()) == pytest.approx(math.radians(12), rel=1e-3)
    assert len(result.cam_angle) == 37


def test_a_standard_law_has_the_largest_values_of_the_cases():
    """cases.md: modified sine 1.7596, 5.5280, 69.466, here over a quarter of a turn."""
    drive = wucht.CamDrive(laws()["modified-sine"](stroke="10 mm", rise=("60 deg", "150 deg")))
    s = wucht.run(wucht.CamLaw(orders=40), drive).wucht.summary
    by = [0.01 / (math.pi / 2) ** k for k in (1, 2, 3)]
    largest = [s["peaks"][name] / b for name, b in zip(("velocity", "acceleration", "jerk"), by, strict=True)]
    assert largest == pytest.approx([1.7596, 5.5280, 69.466], rel=1e-4)
    assert s["harmonics"] is None
    assert len(s["coefficients"]["cosine"]) == 40


@pytest.mark.parametrize("points", [16, 720])
@pytest.mark.parametrize(
    ("kind", "peaks", "jump"),
    [
        ("modified-sine", (4 * math.pi / (math.pi + 4), 4 * math.pi**2 / (math.pi + 4), 16 * math.pi**3 / (math.pi + 4)), 0.0),
        ("simple-harmonic", (math.pi / 2, math.pi**2 / 2, math.pi**3 / 2), math.pi**2 / 2),
    ],
)
def test_largest_values_do_not_depend_on_the_angles_that_are_shown(points, kind, peaks, jump):
    """Over ten degrees; of a law whose acceleration jumps it is told. Modified sine: cases.md; Ca = 4 pi^2/(pi + 4)."""
    arc = math.radians(10)
    drive = wucht.CamDrive(laws()[kind](stroke="8 deg", rise=(0.3, 0.3 + arc)))
    result = wucht.run(wucht.CamLaw(points=points), drive)
    s = result.wucht.summary
    by = [math.radians(8) / arc**k for k in (1, 2, 3)]
    assert [s["peaks"][name] / b for name, b in zip(("velocity", "acceleration", "jerk"), by, strict=True)] == pytest.approx(
        peaks, rel=1e-7
    )
    assert [*s["rise"].values()] == pytest.approx(peaks, rel=1e-7)
    assert s["acceleration_jumps"] / by[1] == pytest.approx(jump, rel=1e-12)
    assert ["the acceleration jumps" in warning for warning in result.wucht.warnings] == [True] * (jump > 0)


def test_largest_values_of_a_table_are_between_its_points():
    phi = np.linspace(0, 2 * math.pi, 37)
    table = laws()["table"](points=np.column_stack([phi, 1 - np.cos(phi + 0.05)]).tolist(), unit="rad")
    s = wucht.run(wucht.CamLaw(points=16), wucht.CamDrive(table)).wucht.summary
    assert [s["peaks"][name] for name in ("velocity", "acceleration", "jerk")] == pytest.approx([1, 1, 1], rel=1e-3)
    assert s["stroke"] == pytest.approx(2, rel=1e-6)


def test_bounds_and_caps_are_shown():
    table = HarmonicLawTable(
        harmonics=5,
        objective="least-mean-square-acceleration",
        restrictions=[
            {"at": "180 deg", "equals": "10 mm"},
            {"on": ["-60 deg", "60 deg"], "equals": 0, "tolerance": "0.1 mm"},
            {"of": "velocity", "max": "6 mm/rad"},
        ],
        caps=[{"harmonic": 3, "amplitude": "0.3 mm"}],
    )
    result = wucht.run(wucht.CamLaw(), wucht.CamDrive(table))
    assert result.restricted.values.tolist() == [0, 0, 1, -1]
    assert (result.greatest.values <= result.high.values + 1e-8).all()
    assert (result.least.values >= result.low.values - 1e-8).all()
    assert wucht.report(result) and wucht.draw(result).axes


@pytest.mark.parametrize(
    "settings",
    [
        {"law.harmonics": 2, "law.restrictions.2.tolerance": 0.0017, "law.objective": "least-peak-acceleration"},
        {"law.restrictions.1.equals": "24 kg"}, {"law.restrictions[0].equals": "24 kg"}, {"law.restrictions.7.equals": 1},
        {"law.restrictions.1.equals.x": 1}, {"gear.ratio": 2}, {"law": 2}, {"study.points": 3}, {"speed.mean": "0 rpm"},
    ],
)  # fmt: skip
def test_bad_input_is_a_sentence_with_the_file(tmp_path, settings):
    check_refusal(f"cam-law: {settings}", lambda: of_template(tmp_path, **settings))


def test_tables_of_a_machine_and_of_a_cam_do_not_mix(tmp_path):
    path = tmp_path / "both.toml"
    path.write_text(study_of("cam-law").template + '\n[machine]\nuse = "drozdetskaya-2020/r1"\n')
    with refused("machine", code="unknown-key"):
        run_file(path)
    path.write_text('[machine]\nuse = "drozdetskaya-2020/r1"\n[law]\nkind = "harmonic"\n')
    with refused("law", code="unknown-key"):
        run_file(path)
    with refused("cam drive"):
        wucht.run(wucht.CamLaw(), wucht.load_machine("drozdetskaya-2020/r1"))
