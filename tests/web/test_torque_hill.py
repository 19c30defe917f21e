"""The torque hill as it is drawn: what the legend calls a curve is that curve, by formulas of a rotor on one spring."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.web.page_answers import answer, page_text

MASS, MOMENT, STIFFNESS, DAMPING = 10.0, 0.02, 1e5, 200.0  # kg, kg m, N/m, N s/m: of all that moves up and down
SLOPE, NO_LOAD, LOAD = 0.02, 190.0, 1e-4  # N m s, rad/s, N m s^2
ROTOR = f"""
[machine.carrier]
directions = "y"
stiffness = {STIFFNESS}
damping = {DAMPING}
[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = {MASS}
unbalance = {MOMENT}
inertia = 0.05
[machine.drive]
kind = "linear"
slope = {SLOPE}
no_load_speed = {NO_LOAD}
"""
FAN = f"""
[machine.load]
kind = "quadratic"
coefficient = {LOAD}
"""
INSIDE = 6.0  # N m: below it nothing is cut off at the top of the panel
NEAR, MANY = 10.0, 50  # px from a line of the legend to its words; more points than that are a curve
Torque = Callable[[np.ndarray], np.ndarray]


def motor(speed: np.ndarray) -> np.ndarray:
    return SLOPE * (NO_LOAD - speed)


def load(speed: np.ndarray) -> np.ndarray:
    return LOAD * speed**2


def vibration(speed: np.ndarray) -> np.ndarray:
    """The damper takes b (A Omega)^2/2; A is the amplitude of the forced vibration."""
    amplitude = MOMENT * speed**2 / np.abs(STIFFNESS - MASS * speed**2 + 1j * DAMPING * speed)
    return DAMPING * amplitude**2 * speed / 2


def scale_of(ticks: list[tuple[float, float]]) -> np.ndarray:
    """Slope and offset of the values over pixels, from the first and the last tick."""
    (low, first), (high, last) = ticks[0], ticks[-1]
    return np.array([(last - first) / (high - low), first - (last - first) / (high - low) * low])


def drawn_curves(drawn: Any) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Speeds in rad/s and torques in N m of the curve that has colour and dashes of a line in the legend, by its words.

    A line of the legend ends beside its words, at their height; ticks are on the left of the panel and below it.
    """
    words = [(entry["words"], entry["point"]) for entry in drawn["words"]]
    assert {"speed in rpm", "torque in N·m"} <= {text for text, _ in words}
    numbers = [(place, float(text.replace("−", "-"))) for text, place in words if text[-1:].isdigit()]
    left = min(x for (x, _), _ in numbers)
    speeds = scale_of([(x, value) for (x, _), value in numbers if x > left]) * np.pi / 30
    torques = scale_of([(y, value) for (x, y), value in numbers if x == left])
    lines = [((s["colour"], s["dashes"]), np.array(s["points"])) for s in drawn["strokes"] if s["points"]]
    curves = {}
    for text, (x, y) in words:
        for style, line in lines:
            if len(line) == 2 and line[1, 1] == y and 0 < x - line[1, 0] < NEAR:
                like = [points.T for other, points in lines if other == style and len(points) > MANY]
                assert len(like) == 1, f"there must be one curve like the line beside {text!r}"
                curves[text] = np.polyval(speeds, like[0][0]), np.polyval(torques, like[0][1])
    return curves


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (ROTOR, {"motor": motor, "vibration": vibration}),
        (ROTOR + FAN, {"motor": motor, "load": load, "load and vibration": lambda speed: load(speed) + vibration(speed)}),
    ],
    ids=["without a load", "fan"],
)
def test_the_legend_calls_each_curve_by_its_name(tmp_path: Path, text: str, expected: dict[str, Torque]) -> None:
    file = tmp_path / "rotor.toml"
    file.write_text(text, encoding="utf-8")
    curves = drawn_curves(answer(tmp_path, page_text(str(file)), "hill"))
    assert curves.keys() == expected.keys()
    for name, torque in expected.items():
        speeds, torques = curves[name]
        is_inside = torque(speeds) < INSIDE
        assert is_inside.sum() > MANY
        assert torques[is_inside] == pytest.approx(torque(speeds)[is_inside], abs=1e-6)
