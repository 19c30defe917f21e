"""What cannot be corrected: a sentence each, with the file and the key, and exit code 2."""

import pytest

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
CASES = {
    "turns back": ('"2.4 rad/s"', '"51 rad/s"', ("speed:", "must not stand still or turn back", "-1 rad/s")),
    "unit": ('"50 rad/s"', '"50 mm"', ("speed.mean", "50 mm")),
    "order 0": ('mean = "50 rad/s"', 'mean = "50 rad/s"\nperiod = "0.2 s"', ("speed.mean", "order 0 must be 2 pi/T")),
    "no speed": ('[speed]\nmean = "50 rad/s"\ncosine = ["0 rad/s", "2.4 rad/s"]\n', "", ("the table [speed] is missing",)),
    "undercut": ('"10 mm"', '"95 mm"', ("follower.roller_radius", "would cut the contour away", "at most 0.0928")),
    "stands": ('cosine = ["-10 deg", "-2 deg"]', 'cosine = ["0 deg"]', ("law:", "the output does not move")),
    "points": ("points = 36", "points = 10", ("study.points", "a whole number from 36 to 20000")),
    "orders": ("points = 36", "orders = 0", ("study.orders", "1")),
    "unknown": ("points = 36", "point = 36", ("study.point", "did you mean 'points'")),
    "acceleration": ("points = 36", "acceleration = 3", ("study.acceleration", "table")),
    "decimals": ("points = 36", "decimals = 13", ("study.decimals", "from 0 to 12")),
    "tolerance": ("points = 36", 'chord_tolerance = "0 um"', ("study.chord_tolerance", "greater than 0")),
    "counter": (
        'angle = "-135 deg"', 'angle = "-135 deg"\ncounter = { arm = 0.07, roller_radius = 0.01, angle = "-100 deg" }',
        ("follower.counter.angle", "do not push the lever opposite ways"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_what_cannot_be_is_a_sentence(refused, here, case):
    old, new, says = CASES[case]
    assert old in FILE
    (here / "drive.toml").write_text(FILE.replace(old, new), encoding="utf-8")
    refused("run", "drive.toml", says=("drive.toml", *says))


def test_the_largest_roller_that_is_named_is_not_refused(refused, wucht, here):
    (here / "drive.toml").write_text(FILE.replace('"10 mm"', '"95 mm"'), encoding="utf-8")
    said = refused("run", "drive.toml")
    allowed = said.split("at most ")[1].split(" m")[0]
    assert wucht("run", "drive.toml", "--set", f"follower.roller_radius={allowed}").code == 0


def test_a_fluctuation_near_standstill_leaves_out_what_would_turn_back(wucht, here):
    (here / "drive.toml").write_text(FILE.replace('"2.4 rad/s"', '"48 rad/s"').split("[follower]")[0]
                                     + FILE[FILE.index("[speed]"):].replace('"2.4 rad/s"', '"48 rad/s"'))  # fmt: skip
    command = wucht("run", "drive.toml", "--json")
    assert command.code == 0, command.err
    what = [r["what"] for r in command.document["summary"]["residuals"]]
    assert "90% of the fluctuation" in what
    assert "110% of the fluctuation" not in what
