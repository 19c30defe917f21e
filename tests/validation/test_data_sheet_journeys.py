"""Two machines from their data sheets to the report and the workbook, with the formulas that designers use by hand.

A vibratory screen of 1900 kg with two 3 kW unbalance motors of 900 kg cm working moment (2 m r), by L. Fischer's rule stroke =
working moment over vibrating mass; Kloss' torque-slip curve; ISO 281. A drum with 3 kg of laundry in one place, an inverter and
a ring of balls in oil: balls of diameter d side by side on a track of radius r balance m r sin(n a)/sin(a), sin(a) = d/(2 r).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

RPM = math.pi / 30
SCREEN = """
title = "Screen 1900 kg, two 3 kW vibrators"

[machine.carrier]
directions = "xyr"
mass = "1900 kg"
inertia = "2700 kg m^2"
gravity = "9.81 m/s^2"

[machine.mounts]
count = 8
pattern = [["-1.7 m", "-0.5 m"], ["1.7 m", "-0.5 m"], ["-1.5 m", "-0.5 m"], ["1.5 m", "-0.5 m"]]
stiffness = ["27.5 N/mm", "66.5 N/mm"]
damping = ["250 N s/m", "400 N s/m"]
EXCITERS
[study]
kind = "run-up"
"""
EXCITER = """
[[machine.bodies]]
kind = "rotor"
name = "NAME"
mass = "80 kg"
working_moment = "900 kg cm"
bearing = { C = "600 kN", p = "10/3", share = 0.5 }
bearing_damping = "0.02 N m s"
inertia = "0.6 kg m^2"
position = PLACE

[[machine.drives]]
on = "NAME"
kind = "induction"
stator = "carrier"
sense = SENSE
nameplate = { power = "3 kW", speed = "1450 rpm", voltage = "400 V", frequency = "50 Hz"TORQUES }
"""
PLACES = {"e1": ('["0.9 m", "0.45 m"]', "1"), "e2": ('["0.45 m", "0.9 m"]', "-1")}
DRUM = """
title = "Drum with 3 kg of laundry in one place, ball ring"

[machine.carrier]
mass = "45 kg"
directions = "xy"
frequency = ["2.3 Hz", "2.7 Hz"]
damping_ratio = 0.15
gravity = "9.81 m/s^2"

[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = "15 kg"
unbalance = "0.72 kg m"
inertia = "0.75 kg m^2"

[[machine.bodies]]
kind = "roller"
name = "b"
count = 14
about = "drum"
mass = "0.3 kg"
track_radius = "0.26 m"
radius = "21 mm"
shape_factor = 0.4
oil = { viscosity = "1 Pa s", gap = "1 mm" }
track = "ring"

[machine.drive]
on = "drum"
kind = "inverter"
set_speed = "1200 rpm"
gain = "3 N m s"
integral_time = "0.5 s"
torque_limit = "15 N m"
power_limit = "700 W"

[[machine.loads]]
on = "drum"
kind = "quadratic"
coefficient = "1.2e-4 N m s^2"

[[machine.schedules]]
parameter = "drive.set_speed"
points = [["0 s", "0 rpm"], ["15 s", "1200 rpm"]]

[study]
kind = "run-up"
"""

Command = Callable[..., Any]


def write_screen(folder: Path, torques: str) -> None:
    """torques: what its motors' data sheet says of them, entries of a nameplate."""
    exciters = "".join(
        EXCITER.replace("NAME", name).replace("PLACE", place).replace("SENSE", sense).replace("TORQUES", torques)
        for name, (place, sense) in PLACES.items()
    )
    (folder / "screen.toml").write_text(SCREEN.replace("EXCITERS", exciters), encoding="utf-8")


def numbers_in(workbook: Path) -> np.ndarray:
    """All numbers of a workbook, in whatever sheet."""
    openpyxl = pytest.importorskip("openpyxl")
    cells = (cell for sheet in openpyxl.load_workbook(workbook) for row in sheet.iter_rows(values_only=True) for cell in row)
    return np.array([cell for cell in cells if isinstance(cell, int | float)], float)


@pytest.mark.usefixtures("coarse_angles", "unpainted")
def test_a_screen_from_its_motors_to_report_and_workbook(wucht: Command, here: Path) -> None:
    write_screen(here, ", breakdown_torque_ratio = 2.8, starting_torque_ratio = 2.4")
    start = ("--set", "study.start.e1=-90 deg", "--set", "study.start.e2=-90 deg")
    run = wucht("run", "screen.toml", "-o", "out", *start, "--json")
    assert run.code == 0, run.err
    s, mass, speed = run.document["summary"], 1900 + 2 * 80, 1488 * RPM
    assert s["outcome"] == "synchronised" and round(s["final_speed"] / RPM) == 1488
    # Far above its natural frequency (153 rpm) the screen swings 1/(1 - (153/1488)^2) = 1.1 % more than a free one.
    by_hand = 2 * 9.0 / mass
    assert f"{1e3 * by_hand:.2f} {1e3 * s['stroke']:.2f}" == "8.74 8.80"
    assert s["stroke"] == pytest.approx(by_hand / (1 - (153 / 1488) ** 2), rel=5e-3)
    assert s["machine_number"] == pytest.approx(by_hand / 2 * speed**2 / 9.81, rel=5e-3)
    assert f"{s['machine_number']:.1f}" == "10.8"
    # The weights pull with U w^2 = 109.3 kN; the bearings have to carry the shaft's 80 kg along with the screen, too.
    assert 4.5 * speed**2 == pytest.approx(109.3e3, rel=1e-3)
    assert s["steady_bearing_forces"]["e1"] == pytest.approx(4.5 * speed**2 - 80 * s["acceleration"] / 2, rel=1e-2)
    for name, load in s["equivalent_bearing_loads"].items():
        hours = 1e6 / (60 * s["final_speed"] / RPM) * (600e3 / load) ** (10 / 3)
        assert s["bearing_life"][name] == pytest.approx(hours, rel=1e-3)
    assert pytest.approx(37_500, rel=1e-3) == 1e6 / (60 * 1488) * (600 / 52.57) ** (10 / 3)
    for name, moment in s["weight_moment"].items():
        assert moment == pytest.approx(4.5 * 9.81, rel=1e-6)
        assert s["starting_torque"][name] == pytest.approx(2.4 * 3000 / (1450 * RPM), rel=1e-6)

    assert wucht("report", "out", "-o", "report.html").code == 0
    page = (here / "report.html").read_text(encoding="utf-8")
    assert "SYNCHRONISED" in page and "8.803" in page and re.search(r"37,\d{3}|3\.7\d+e\+04", page)
    assert wucht("export", "out", "--xlsx", "-o", "sheets").code == 0
    stated = numbers_in(here / "sheets" / "run-up.xlsx")
    for value in (8.803, s["machine_number"], s["bearing_life"]["e1"]):
        assert np.abs(stated / value - 1).min() < 1e-3


@pytest.mark.parametrize(
    ("torques", "starting", "outcome"),
    [
        (", breakdown_torque_ratio = 2.8", 19.4, "not-started"),  # Kloss: 2 T_b s_b at standstill
        (", breakdown_torque_ratio = 2.8, starting_torque_ratio = 2.4", 2.4 * 19.757, "synchronised"),
    ],
)
@pytest.mark.usefixtures("coarse_angles", "unpainted")
def test_a_motor_lifts_the_hanging_weights_or_does_not(
    torques: str, starting: float, outcome: str, wucht: Command, here: Path
) -> None:
    """44.1 N m hold the weights; a motor whose torque at standstill is less than half of that swings them and no more."""
    write_screen(here, torques)
    start = ("--set", "study.start.e1=-90 deg", "--set", "study.start.e2=-90 deg")
    s = wucht("run", "screen.toml", *start, "--json").document["summary"]
    assert s["starting_torque"]["e1"] == pytest.approx(starting, rel=5e-3)
    assert s["outcome"] == outcome
    if outcome == "not-started":
        proposed = "drives.e1.nameplate.starting_torque_ratio=2.7"  # what is typical is asked for first, before a larger motor
        assert proposed in wucht("run", "screen.toml", *start).out.splitlines()[-1]


@pytest.mark.slow
@pytest.mark.usefixtures("unpainted")
def test_a_drum_from_its_balls_and_oil_to_report_and_workbook(wucht: Command, here: Path) -> None:
    (here / "drum.toml").write_text(DRUM, encoding="utf-8")
    run = wucht("run", "drum.toml", "-o", "out", "--json")
    assert run.code == 0, run.err
    s, half = run.document["summary"], math.asin(0.021 / 0.239)
    capacity = {n: 0.3 * 0.239 * math.sin(n * half) / math.sin(half) for n in (12, 14)}
    assert [round(c, 3) for c in capacity.values()] == [0.710, 0.770]
    assert s["outcome"] == "compensated" and s["final_residual_unbalance"] < 1e-4
    phases = np.array(list(s["final_phases"].values()))
    left = 0.72 + 0.3 * 0.239 * np.exp(1j * phases).sum()
    assert abs(left) / 0.72 < 1e-3
    few = wucht("run", "drum.toml", "-o", "few", "--set", "b.count=12", "--json").document["summary"]
    assert few["final_residual_unbalance"] == pytest.approx((0.72 - capacity[12]) / 0.72, abs=7e-3)
    assert wucht("report", "out", "few", "-o", "report.html").code == 0
    assert "COMPENSATED" in (here / "report.html").read_text(encoding="utf-8")
    assert wucht("export", "out", "--xlsx", "-o", "sheets").code == 0
    assert np.abs(numbers_in(here / "sheets" / "run-up.xlsx") / 1200 - 1).min() < 1e-3
