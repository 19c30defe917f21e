"""The journey of a designer of cams: a standard law, a record of the shaft's speed and the motor's nameplate, from the file to
the report and the workbook, with the numbers that are calculated by hand.

A cycloidal law of 30 mm over 120 degrees at 500 rpm: the largest acceleration 2 pi h w^2/beta^2 = 117.8 m/s^2, the largest
speed 2 h w/beta = 1.5 m/s, so that the shaft gives a slide of 12 kg its 13.5 J twice a turn, 225 W.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

H, BETA, W, MASS = 0.030, 2 * math.pi / 3, 500 * math.pi / 30, 12.0
PEAK = 2 * math.pi * H * W**2 / BETA**2
STEP = 2 * math.pi / W / 20_000  # s, of a turn
STUDY = """
title = "Slide cam, measured shaft"

[study]
kind = "cam-correction"

[law]
kind = "inclined-sine"
stroke = "30 mm"
rise = ["0 deg", "120 deg"]
return = ["180 deg", "300 deg"]

[follower]
kind = "translating-roller"
distance = "70 mm"
roller_radius = "12 mm"

[speed]
file = "speed.csv"
column = "Drehzahl"
orders = [1, 2, 3, 4]

[shaft]
inertia = "0.4 kg m^2"
output_mass = "12 kg"

[shaft.drive]
kind = "induction"
transmission = { ratio = 2.9, inertia = "0.004 kg m^2", efficiency = "95 %" }
[shaft.drive.nameplate]
power = "1.1 kW"
speed = "1450 rpm"
voltage = "400 V"
frequency = "50 Hz"
breakdown_torque_ratio = 2.8
"""


def shaft_speed(t: np.ndarray) -> np.ndarray:
    """The speed of the shaft in rad/s at times in s: orders 1 to 4."""
    cosine, sine = {1: 0.8, 2: 2.4, 3: 1.0, 4: 0.5}, {2: 1.0, 3: -1.3, 4: 0.2}
    waves = [a * np.cos(k * W * t) for k, a in cosine.items()] + [b * np.sin(k * W * t) for k, b in sine.items()]
    return np.asarray(W + sum(waves))


def write_record(path: Path) -> None:
    """Two seconds at 1 kHz with noise, as a logger in Germany writes them."""
    t = np.arange(0, 2.0, 1e-3)
    speed = shaft_speed(t) + np.random.default_rng(1).normal(0, 0.1, t.size)
    rows = (f"{x:.4f};{y * 30 / math.pi:.2f}".replace(".", ",") for x, y in zip(t, speed, strict=True))
    path.write_text("\n".join(["Zeit [s];Drehzahl [U/min]", *rows]) + "\n", encoding="utf-8")


def lift(angle: np.ndarray) -> np.ndarray:
    """The law by hand."""
    phi = np.mod(angle, 2 * math.pi)
    x = np.clip(phi / BETA, 0, 1) - np.clip((phi - math.pi) / BETA, 0, 1)
    return np.asarray(H * (x - np.sin(2 * math.pi * x) / (2 * math.pi)))


def motions_by_hand() -> tuple[np.ndarray, np.ndarray]:
    """The slide over a turn on a cam that is cut for constant speed, and its law."""
    t = np.arange(20_001) * STEP
    speed = shaft_speed(t)
    angle = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * STEP)])
    return lift(angle), lift(W * t)


def numbers_in(workbook: Path) -> np.ndarray:
    """All numbers of a workbook, in whatever sheet, those in texts too."""
    openpyxl = pytest.importorskip("openpyxl")
    cells = (cell for sheet in openpyxl.load_workbook(workbook) for row in sheet.iter_rows(values_only=True) for cell in row)
    texts = " ".join(str(cell) for cell in cells if cell is not None)
    return np.array([float(number) for number in re.findall(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", texts)])


@pytest.mark.usefixtures("coarse_angles", "unpainted")
def test_from_nameplate_and_record_to_report_and_workbook(wucht: Callable[..., Any], here: Path) -> None:
    write_record(here / "speed.csv")
    (here / "slide.toml").write_text(STUDY, encoding="utf-8")
    run = wucht("run", "slide.toml", "-o", "out", "--json")
    assert run.code == 0, run.err
    s = run.document["summary"]
    assert s["peak_after"] == pytest.approx(PEAK, rel=1e-3) and f"{PEAK:.1f}" == "117.8"
    swing = np.ptp(shaft_speed(np.linspace(0, 2 * math.pi / W, 2000))) / W
    assert s["mean_speed"] == pytest.approx(W, rel=1e-4) and s["fluctuation"] == pytest.approx(swing, rel=1e-2)
    output, law = motions_by_hand()
    noise = 1e-2  # of the orders that are fitted to the record: 0.1 rad/s sqrt(2/2000) of some 2.5 rad/s, twice in several
    assert s["peak_before"] == pytest.approx(np.abs(np.gradient(np.gradient(output, STEP), STEP)).max(), rel=noise)
    assert s["position_error_before"] == pytest.approx(np.abs(output - law).max(), rel=noise)
    assert s["position_error_rms_before"] == pytest.approx(math.sqrt(((output - law) ** 2).mean()), rel=noise)
    assert s["position_error_after"] < 1e-12
    power = s["camshaft_power_after"]
    assert power["mean_positive"] == pytest.approx(2 * MASS * (2 * H * W / BETA) ** 2 / 2 * W / (2 * math.pi), rel=1e-3)
    assert power["peak"] == pytest.approx(2 * math.pi * MASS * H**2 * (W / BETA) ** 3 * 0.75 * math.sqrt(3), rel=1e-3)
    assert s["undercut"] is False

    assert wucht("report", "out", "-o", "report.html").code == 0
    page = (here / "report.html").read_text(encoding="utf-8")
    error = f"{1e3 * s['position_error_before']:.4g} mm"
    assert all(words in page for words in ("117.8 m/s²", error, "1.377 kW"))
    assert wucht("export", "out", "--xlsx", "-o", "sheets").code == 0
    stated = numbers_in(here / "sheets" / "cam-correction.xlsx")
    for value in (PEAK, s["peak_before"]):
        assert np.abs(stated / value - 1).min() < 1e-3

    workshop = wucht("export", "out", "-o", "workshop")
    assert workshop.code == 0 and (here / "workshop" / "cam.txt").is_file() and (here / "workshop" / "law.csv").is_file()


@pytest.mark.slow
def test_the_same_file_predicts_the_speed_from_the_nameplate(wucht: Callable[..., Any], here: Path) -> None:
    """By its slip the motor turns the shaft at (1500 - slip)/2.9: faster than 1450/2.9 = 500 rpm, as the slide needs less."""
    write_record(here / "speed.csv")
    (here / "slide.toml").write_text(STUDY, encoding="utf-8")
    s = wucht("run", "slide.toml", "--set", "study.kind=cam-prediction", "--json").document["summary"]
    assert 500 < s["corrected"]["mean_speed"] * 30 / math.pi < 1500 / 2.9
    at_this_speed = 2 * math.pi * H * (s["corrected"]["mean_speed"] / BETA) ** 2
    assert s["peak_acceleration"]["corrected"] == pytest.approx(at_this_speed, rel=1e-5)
    assert s["position_error"]["corrected"] < 1e-10 and s["position_error"]["original"] > 1e-5
