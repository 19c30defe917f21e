"""What cannot be corrected: a sentence each, with the file and the key, and exit code 2."""

import pytest
from tests.refusals import cases_of, check_file, refused

from wucht import run_file

FILE = """\
[study]
kind = "cam-correction"
points = 36
[law]
kind = "harmonic"
coefficients = { mean = "12 deg", cosine = ["-10 deg", "-2 deg"] }
[follower]
kind = "oscillating-roller"
pivot = "120 mm"
arm = "70 mm"
roller_radius = "10 mm"
angle = "-135 deg"
[speed]
mean = "50 rad/s"
cosine = ["0 rad/s", "2.4 rad/s"]
"""
CHANGES = {
    '"2.4 rad/s"': ['"51 rad/s"'], '"50 rad/s"': ['"50 mm"'], 'mean = "50 rad/s"': ['mean = "50 rad/s"\nperiod = "0.2 s"'],
    '[speed]\nmean = "50 rad/s"\ncosine = ["0 rad/s", "2.4 rad/s"]\n': [""],
    'cosine = ["-10 deg", "-2 deg"]': ['cosine = ["0 deg"]'],
    "points = 36": [
        "points = 10", "orders = 0", "point = 36", "acceleration = 3", "decimals = 13", 'chord_tolerance = "0 um"',
    ],
    'angle = "-135 deg"': ['angle = "-135 deg"\ncounter = { arm = 0.07, roller_radius = 0.01, angle = "-100 deg" }'],
}  # fmt: skip


@pytest.mark.parametrize(("old", "new"), cases_of(CHANGES))
def test_what_cannot_be_is_a_sentence(here, old, new):
    check_file("cam-correction", FILE, {old: new})


@pytest.mark.slow
def test_the_largest_roller_that_is_named_is_not_refused(here):
    (here / "drive.toml").write_text(FILE.replace('"10 mm"', '"95 mm"'), encoding="utf-8")
    with refused("follower.roller_radius", given="95 mm", file="drive.toml") as raised:
        run_file("drive.toml")
    allowed = str(raised.value).split("at most ")[1].split(",")[0]
    assert allowed.startswith("92.8")
    run_file("drive.toml", {"follower.roller_radius": allowed})
    counter = {"arm": "70 mm", "roller_radius": "130 mm", "angle": "110 deg"}
    with refused("follower.counter.roller_radius", given="130 mm", file="drive.toml"):
        run_file("drive.toml", {"follower.roller_radius": "10 mm", "follower.counter": counter})


@pytest.mark.parametrize("value", ["0.0", "9.81"])
def test_a_dead_sensor_is_told(here, value):
    rows = "\n".join(f"{0.001 * i:.3f},{value}" for i in range(500))
    (here / "dead.csv").write_text(f"time [s],a [rad/s^2]\n{rows}\n", encoding="utf-8")
    asked = 'points = 36\nacceleration = { file = "dead.csv", column = "a" }'
    check_file(f"cam-correction, {value}", FILE, {"points = 36": asked})


def test_a_fluctuation_near_standstill_leaves_out_what_would_turn_back(here):
    law, speed = FILE.split("[follower]", maxsplit=1)[0], FILE[FILE.index("[speed]") :].replace('"2.4 rad/s"', '"48 rad/s"')
    (here / "drive.toml").write_text(law + speed, encoding="utf-8")
    what = [r["what"] for r in run_file("drive.toml").wucht.summary["residuals"]]
    assert "90 % of the fluctuation" in what and "110 % of the fluctuation" not in what
