"""The moving drawing: its data follow the parameters, what is drawn is where the state says, and grabbing is its inverse."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.typescript_jobs import run_jobs

from wucht import Machine, load_machine
from wucht.dynamics.live_drawing import live_drawing
from wucht.dynamics.live_machine import export_obstacles, machine_description, machine_script
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.files.catalogue import load_document, names
from wucht.machine_shape import machine_shape
from wucht.machines.operation import axis_at_rest
from wucht.studies.subjects import MACHINE

FAMILIES = [
    "drozdetskaya-2020/r1", "drozdetskaya-2020/figure-6.5", "drozdetskaya-2020/table-5.1", "practice/fan-on-belt",
    "practice/laundry-drum", "practice/laundry-drum-friction", "practice/screen-loaded", "sperling-vibration/figure-2a",
    "sperling-vibration/lock-limits", "sperling-rollers/table-1",
]  # fmt: skip
PLAIN = {"stroboscopic": False, "magnification": 10.0}
SEEN_TURNING = {"stroboscopic": True, "magnification": 10.0}


@cache
def machine_at_start(name: str) -> tuple[Machine, np.ndarray, dict[str, Any], str]:
    """A machine in its initial state, its description, and its script."""
    study = load_document(name)[0].get("study", {})
    machine = load_machine(name)
    state = initial_state(machine, study.get("start", {}) if study.get("kind") == "run-up" else {})
    machine = machine_in_state(machine, state)
    drawing = {"drawing": live_drawing(machine)[0]}
    return machine, state, machine_description(machine, state) | drawing, machine_script(machine, state)


def exportable_machines() -> list[str]:
    """Machines of the catalogue that can be exported."""
    return [n for n in names() if "machine" in load_document(n)[0] and not export_obstacles(load_machine(n))]


def shape_numbers(machine: Machine) -> list[float]:
    """The lengths of a machine's shape in numbers."""
    description = MACHINE.describe(machine)
    shape = machine_shape(
        description.facts["bodies"], machine.values, description.parts, dimensionless=description.dimensionless
    )
    rotors = [x for r in shape.rotors for x in (r.x, r.y, r.radius, *(y for b in r.bodies for y in (b.arm, b.size, b.track)))]
    return [*shape.box, *rotors, *(x for m in shape.mounts for x in (m.x, m.y))]


def drawn_numbers(drawing: Mapping[str, Any], lengths: list[float]) -> list[float]:
    """The same of the data of the moving drawing, with its lengths."""
    indices = list(drawing["box"])
    for k, rotor in enumerate(drawing["rotors"]):
        indices += [rotor["x"], rotor["y"], rotor["radius"]]
        indices += [
            b[key] for b in drawing["bodies"] if b["rotor"] == k and b["about"] is not None for key in ("arm", "size", "track")
        ]
    indices += [x for m in drawing["mounts"] for x in (m["x"], m["y"])]
    return [lengths[i] for i in indices]


def check_lengths(folder: Path, chosen: Sequence[str]) -> None:
    """Compare the lengths with those of the figure, at other values of all parameters."""
    generator, jobs, expected = np.random.default_rng(7), [], []
    for name in chosen:
        machine, _, description, script = machine_at_start(name)
        scheduled = {s.parameter for s in machine.schedules}
        changes = {p: v * generator.uniform(0.9, 1.1) for p, v in machine.values.items() if p not in scheduled}
        jobs.append((script, {"kind": "lengths", "parameters": changes}))
        expected.append((description["drawing"], shape_numbers(machine.with_unchecked_values(changes))))
    for (drawing, numbers), lengths in zip(expected, run_jobs(folder, jobs), strict=True):
        assert drawn_numbers(drawing, lengths) == pytest.approx(numbers, rel=1e-12, abs=1e-15)


@pytest.mark.slow
def test_lengths_are_those_of_the_figure_at_other_parameters_too(tmp_path: Path) -> None:
    check_lengths(tmp_path, FAMILIES[::2])


@pytest.mark.slow
def test_lengths_of_the_whole_catalogue_are_those_of_the_figure(tmp_path: Path) -> None:
    """But for a disc with masses in guides, which are no bodies that turn."""
    chosen = [name for name in exportable_machines() if name != "sperling-vibration/figure-7"]
    assert len(chosen) > 80
    check_lengths(tmp_path, chosen)


def test_the_rest_is_where_the_carrier_sags(tmp_path: Path) -> None:
    machine, _, description, script = machine_at_start("practice/laundry-drum")
    (lengths,) = run_jobs(tmp_path, [(script, {"kind": "lengths"})])
    rest = [lengths[d["rest"]] for d in description["drawing"]["carrier"]]
    assert rest == pytest.approx(list(axis_at_rest(machine).values()))
    assert rest[1] < 0


def circles(answer: Mapping[str, Any], radius: float) -> np.ndarray:
    """Centres of the circles of a radius in pixels."""
    return np.array([arc[:2] for arc in answer["arcs"] if arc[2] == pytest.approx(radius, rel=1e-9)])


def disc_radius(answer: Mapping[str, Any]) -> float:
    """The radius of the largest rotor in pixels: the arrow around it, of its sense of rotation, is the largest circle."""
    return float(max(arc[2] for arc in answer["arcs"]) - 7.0)


def with_entries(machine: Machine, state: np.ndarray, entries: Mapping[str, float]) -> list[float]:
    changed = state.copy()
    for name, value in entries.items():
        changed[machine.state_names.index(name)] = value
    return [float(x) for x in changed]


def test_balls_are_drawn_to_scale_at_their_angles(tmp_path: Path) -> None:
    """In a grinder whose carrier is displaced, and with larger balls."""
    machine, state, _, script = machine_at_start("practice/grinder-4-balls")
    angles = {f"b{k + 1}.angle": 0.3 + 1.4 * k for k in range(4)}
    rest = axis_at_rest(machine)
    moved = angles | {"carrier.x": rest["x"] + 1e-4, "carrier.y": rest["y"] - 2e-4}
    larger = {f"b{k}.radius": 0.005 for k in range(1, 5)}
    at_rest = angles | {"carrier.x": rest["x"], "carrier.y": rest["y"]}
    job = {"kind": "draw", "view": PLAIN}
    jobs = [
        (script, job | {"state": with_entries(machine, state, at_rest)}),
        (script, job | {"state": with_entries(machine, state, moved)}),
        (script, job | {"state": with_entries(machine, state, at_rest), "parameters": larger}),
    ]
    still, displaced, large = run_jobs(tmp_path, jobs)
    track = disc_radius(still) / 1.18
    scale = track / 0.029
    balls = circles(still, 0.004 * scale)
    axis = circles(still, track)[0]
    expected = [[0.025 * scale * math.cos(a), -0.025 * scale * math.sin(a)] for a in angles.values()]
    assert balls - axis == pytest.approx(np.array(expected), rel=1e-9)
    shift = np.array([10 * 1e-4 * scale, 10 * 2e-4 * scale])
    assert circles(displaced, track)[0] - axis == pytest.approx(shift)
    assert circles(displaced, 0.004 * scale) - balls == pytest.approx(np.tile(shift, (4, 1)))
    assert circles(large, 0.005 * scale) - axis == pytest.approx(np.array(expected) * 0.024 / 0.025, rel=1e-9)


def test_grabbing_the_carrier_moves_it_with_the_finger(tmp_path: Path) -> None:
    """Magnification undone; the speeds of the carrier zero, all else as it was."""
    machine, state, _, script = machine_at_start("practice/grinder-4-balls")
    entries = {"carrier.x": 1e-4, "carrier.vx": 0.3, "carrier.vy": -0.2}
    before = with_entries(machine, state, entries)
    job = {"kind": "draw", "view": PLAIN, "state": before, "grabs": [{"from": [0.0, 0.0], "to": [0.0, 0.0]}]}
    (answer,) = run_jobs(tmp_path, [(script, job)])
    disc = disc_radius(answer)
    scale = disc / (1.18 * 0.029)
    axis = circles(answer, disc)[0].tolist()
    corner = [axis[0] + 1.2 * disc, axis[1] + 1.2 * disc]
    assert answer["parts"][0]["part"] is None
    for start in (axis, corner):
        grab = {"from": start, "to": [start[0] + 24.0, start[1] - 36.0]}
        (again,) = run_jobs(tmp_path, [(script, job | {"grabs": [grab]})])
        assert again["parts"][0]["part"] == {"kind": "carrier", "index": 0}
        still = with_entries(machine, state, entries | {"carrier.vx": 0.0, "carrier.vy": 0.0})
        assert again["parts"][0]["same"] == pytest.approx(still, abs=1e-12)
        expected = {"carrier.x": 1e-4 + 24.0 / scale / 10, "carrier.y": before[1] + 36.0 / scale / 10}
        moved = with_entries(machine, np.array(still), expected)
        assert again["parts"][0]["moved"] == pytest.approx(moved, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("view", [PLAIN, SEEN_TURNING])
def test_a_ball_follows_the_finger_up_to_its_neighbour(tmp_path: Path, view: Mapping[str, Any]) -> None:
    """It goes on turning with its rotor; turns that it has made stay."""
    machine, state, description, script = machine_at_start("practice/laundry-drum")
    turns = 6 * 2 * math.pi
    rotor = machine.rotor.name
    entries = {f"{rotor}.angle": turns + 0.4, f"{rotor}.speed": 31.0}
    balls = [b.name for b in machine.bodies if b.about is not None]
    spread = {f"{name}.angle": turns + state[machine.state_names.index(f"{name}.angle")] for name in balls}
    before = with_entries(machine, state, entries | spread)
    gaps = [
        state[machine.state_names.index(f"{b}.angle")] - state[machine.state_names.index(f"{a}.angle")]
        + machine.values[f"tracks.ring.offset_{k + 1}"]
        for k, (a, b) in enumerate(c["bodies"] for c in description["contacts"])
    ]  # fmt: skip
    k = int(np.argmin(gaps))
    chosen, ahead = description["contacts"][k]["bodies"]
    index = [b.name for b in machine.bodies].index(chosen)
    job = {"kind": "draw", "view": view, "state": before}
    (answer,) = run_jobs(tmp_path, [(script, job)])
    disc = disc_radius(answer)
    axis = circles(answer, disc)[0]
    arm = (
        disc
        / (1.18 * machine.values[f"{chosen}.track_radius"])
        * (machine.values[f"{chosen}.track_radius"] - machine.values[f"{chosen}.radius"])
    )
    frame = 0.4 if view["stroboscopic"] else 0.0

    def pixel(angle: float) -> list[float]:
        return [axis[0] + arm * math.cos(angle - frame), axis[1] - arm * math.sin(angle - frame)]

    row, at = machine.state_names.index(f"{chosen}.angle"), before[machine.state_names.index(f"{chosen}.angle")]
    neighbour = before[machine.state_names.index(f"{ahead}.angle")]
    limit = neighbour + machine.values[f"tracks.ring.offset_{k + 1}"]
    back = at - 0.02
    grabs = [{"from": pixel(at), "to": pixel(back)}, {"from": pixel(at), "to": pixel(limit + 0.3)}]
    (answer,) = run_jobs(tmp_path, [(script, job | {"grabs": grabs})])
    free, blocked = answer["parts"]
    assert free["part"] == blocked["part"] == {"kind": "body", "index": index}
    speed = machine.state_names.index(f"{chosen}.speed")
    assert free["same"][row] == pytest.approx(at, abs=1e-9)
    assert free["moved"][row] == pytest.approx(back, abs=1e-9)
    assert free["moved"][speed] == 31.0
    assert blocked["moved"][row] == pytest.approx(limit, abs=1e-9)
    changed = {row, speed}
    assert [x for i, x in enumerate(free["moved"]) if i not in changed] == [x for i, x in enumerate(before) if i not in changed]


def test_a_roller_goes_on_with_a_rotor_whose_speed_is_prescribed(tmp_path: Path) -> None:
    """Outputs have that speed; while a part is held there are none."""
    machine, state, description, script = machine_at_start("sperling-rollers/table-1")
    speed = machine.values["drive.speed"]
    job = {"kind": "draw", "view": PLAIN, "state": state.tolist(), "outputs": [speed, 0.0, 0.0], "held": True}
    (answer,) = run_jobs(tmp_path, [(script, job)])
    index = 1
    ball = description["drawing"]["bodies"][index]
    arm = machine.values[f"{ball['name']}.track_radius"] - machine.values[f"{ball['name']}.radius"]
    scale = disc_radius(answer) / (1.18 * machine.values[f"{ball['name']}.track_radius"])
    axis, angle = circles(answer, disc_radius(answer))[0], state[ball["angle"]]
    start = [axis[0] + arm * scale * math.cos(angle), axis[1] - arm * scale * math.sin(angle)]
    (answer,) = run_jobs(tmp_path, [(script, job | {"grabs": [{"from": start, "to": [axis[0], axis[1] - 50.0]}]})])
    (part,) = answer["parts"]
    assert part["part"]["kind"] == "body"
    taken = description["drawing"]["bodies"][part["part"]["index"]]
    assert taken["about"] == 0
    assert part["moved"][taken["velocity"]] == speed
    assert math.sin(part["moved"][taken["angle"]]) == pytest.approx(1.0)


def check_drawings(folder: Path, chosen: Sequence[str]) -> None:
    """All numbers that reach the canvas are finite, in both views."""
    job = {"kind": "draw", "trace": [0.0, 0.0, 1e-4, 1e-4, 0.0, 1e-4]}
    jobs = [(name, view) for name in chosen for view in (PLAIN, SEEN_TURNING)]
    answers = run_jobs(folder, [(machine_at_start(name)[3], job | {"view": view}) for name, view in jobs])
    for (name, _), answer in zip(jobs, answers, strict=True):
        assert answer["arcs"], name
        assert np.isfinite(np.array(answer["arcs"], float)).all(), name
        assert answer["infinite"] == 0, name


def test_a_machine_of_each_family_is_drawn(tmp_path: Path) -> None:
    check_drawings(tmp_path, [*FAMILIES, "sperling-vibration/figure-7"])
