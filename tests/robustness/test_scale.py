"""What is very large, or has no end: long schedules, runs and texts, and links to devices and pipes in the place of files."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.refusals import refused
from tests.robustness import children

import wucht as package
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.schema.checking import LONGEST_TEXT

R1 = "drozdetskaya-2020/r1"
USE = '[machine]\nuse = "thing.toml"\n'
TABLE = """
[machine.carrier]
mass = "1 kg"
directions = "x"
stiffness = "1e4 N/m"
[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = "10 kg"
eccentricity = "1 mm"
[machine.drive]
on = "drum"
kind = "table"
file = "thing.csv"
"""
RECORD = '[study]\nkind = "load-spectrum"\nsignal = { file = "thing.csv", column = "force" }\n'
RUN = ("run", "study.toml", "-o", "out")
ROLES: dict[str, tuple[str, str, tuple[str, ...]]] = {  # where the thing is, the study file, and the command
    "study": ("study.toml", "", RUN),
    "use": ("thing.toml", USE, RUN),
    "table": ("thing.csv", TABLE, RUN),
    "record": ("thing.csv", RECORD, RUN),
    "equations": ("study.toml", "", ("equations", "study.toml")),
    "plot": ("thing.nc", "", ("plot", "thing.nc")),
    "report": ("thing.nc", "", ("report", "thing.nc")),
    "resumed": ("out/result.nc", "", ("run", R1, "-o", "out", "--resume")),
    "resumed part": ("out/result.partial.nc", "", ("run", R1, "-o", "out", "--resume")),
    "folder": ("out", "", ("run", R1, "-o", "out")),
}
THINGS = ("/dev/zero", "/dev/random", "/proc/self/mem", "pipe", "circle")
BEGINS = {("resumed", "circle"), ("resumed part", "circle")}  # a link to nothing is replaced


def with_schedule(points: int, spoilt: int | None = None) -> package.Machine:
    """A rotor whose no-load speed follows a straight line through so many points. spoilt: the number of a wrong one."""
    times = np.linspace(0.0, 10.0, points).tolist()
    line = [[t, 200.0 + 2.0 * t] for t in times]
    if spoilt is not None:
        line[spoilt][1] = -1.0
    rotor = {"kind": "rotor", "name": "drum", "mass": 10.0, "eccentricity": 1e-3, "inertia": 0.1}
    parameter = "drive.no_load_speed" if spoilt is None else "carrier.stiffness"
    return machine_from(
        {
            "carrier": {"directions": "x", "stiffness": 1e4, "damping": 20.0},
            "bodies": [rotor],
            "drive": {"on": "drum", "kind": "linear", "slope": 0.1, "no_load_speed": 200.0},
            "schedules": [{"parameter": parameter, "points": line}],
        }
    )


@pytest.mark.slow
def test_points_of_a_schedule_cost_no_more_where_they_are_many() -> None:
    """Of 40,000 each takes some 30 us of processor time; where each looks at all the others, it is 400 us."""
    with_schedule(100)
    begun = time.process_time()
    with_schedule(40_000)
    assert time.process_time() - begun < 6.0


@pytest.mark.slow
@pytest.mark.parametrize("points", [101, 10_001])
def test_a_wrong_point_is_named_among_many(points: int) -> None:
    with refused("machine.schedules[0].points (t = 5)", "carrier.stiffness", given=-1.0):
        with_schedule(points, spoilt=points // 2)


def test_a_line_through_many_points_is_that_line() -> None:
    """More points than those at which the speeds of the machine are looked up."""
    coarse, fine = (package.run(package.RunUp(until=10.0), with_schedule(points)) for points in (2, 2001))
    assert fine.sizes["time"] == coarse.sizes["time"]
    assert fine.wucht.summary["final_speed"] == pytest.approx(coarse.wucht.summary["final_speed"], rel=1e-6)
    assert fine.wucht.summary["energy_residual"] < 1e-8


@pytest.mark.parametrize("key", ["title", "notes"])
def test_a_long_text_is_refused(tmp_path: Path, key: str) -> None:
    file = tmp_path / "s.toml"
    for letters, allowed in ((LONGEST_TEXT, True), (LONGEST_TEXT + 1, False), (2_000_000, False)):
        file.write_text(f'{key} = "{"x" * letters}"\n[machine]\nuse = "{R1}"\n', encoding="utf-8")
        if allowed:
            load_machine(str(file))
        else:
            with refused(key, str(LONGEST_TEXT), given="x" * letters, file=file.name, code="too-long"):
                load_machine(str(file))


@pytest.mark.slow
@pytest.mark.parametrize(("megabytes", "reason"), [(50, "the file has 50 MB; at most 40 MB"), (4, "title: given 'xxxx")])
def test_a_title_of_megabytes(tmp_path: Path, megabytes: int, reason: str) -> None:
    """Refused by the size of its file before that is read, or by its own."""
    children.load_everything()
    (tmp_path / "study.toml").write_text(f'title = "{"x" * megabytes * 10**6}"\n[machine]\nuse = "{R1}"\n', encoding="utf-8")
    ended = children.call(children.wucht(*RUN), tmp_path, 15.0)
    assert ended.code == 2 and len(ended.sentence) < 300 and reason in ended.sentence, ended.err


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="devices of POSIX")
@pytest.mark.parametrize("role", ROLES)
def test_links_to_what_has_no_end(tmp_path: Path, role: str) -> None:
    """A sentence, at once; none of them is read, and none is waited for."""
    children.load_everything()
    name, text, words = ROLES[role]
    for thing in THINGS:
        place = tmp_path / thing.replace("/", "-")
        file = place / name
        file.parent.mkdir(parents=True)
        if text:
            (place / "study.toml").write_text(text, encoding="utf-8")
        if thing == "pipe":
            os.mkfifo(file)
        else:
            file.symlink_to(file.name if thing == "circle" else thing)
        if (role, thing) in BEGINS:
            continue
        ended = children.call(children.wucht(*words), place, 5.0)
        assert (ended.code, ended.err.count("wucht: ")) == (2, 1), (thing, ended.err)
        assert "Traceback" not in ended.err


@pytest.mark.slow
@pytest.mark.parametrize("name", ["result.nc", "summary.json", "summary.partial.json", "run-up.png"])
def test_a_run_replaces_a_pipe_in_its_folder_and_does_not_wait(tmp_path: Path, name: str) -> None:
    children.load_everything()
    (tmp_path / "out").mkdir()
    os.mkfifo(tmp_path / "out" / name)
    ended = children.call(children.wucht("run", R1, "--set", "study.until=0.2", "-o", "out"), tmp_path, 15.0)
    assert ended.code == 0, ended.err
    assert package.load(tmp_path / "out").wucht.finished


def r1_radius(until: float) -> np.ndarray:
    """Radius of the axis of R1 over time, in m: its equations written down by hand, evaluated densely."""
    mass, unbalance, pendulum = 10.0, 9.75 * 1e-3, 0.125 * 0.104
    inertias, stiffness, damping = (9.75e-4, 1.69e-3, 1.69e-3), 1e5, 200.0

    def rates(_time: float, z: np.ndarray) -> np.ndarray:
        angles, (vx, vy, *speeds) = z[2:5], z[5:]
        moments = np.array([unbalance, pendulum, pendulum])
        sine, cosine, w = moments * np.sin(angles), moments * np.cos(angles), np.array(speeds)
        matrix = np.diag([mass, mass, *inertias])
        matrix[0, 2:] = matrix[2:, 0] = -sine
        matrix[1, 2:] = matrix[2:, 1] = cosine
        drag = 0.169 * (w[1:] - w[0])
        torques = [0.0195 * (200.0 - w[0]) + drag.sum(), *-drag]
        forces = [cosine @ w**2 - stiffness * z[0] - damping * vx, sine @ w**2 - stiffness * z[1] - damping * vy]
        return np.concatenate([z[5:], np.linalg.solve(matrix, [*forces, *torques])])

    start = [0.0, 0.0, 0.0, 0.3, -0.5, 0.0, 0.0, 0.0, 0.0, 0.0]
    dense = solve_ivp(rates, (0.0, until), start, "DOP853", rtol=1e-11, atol=1e-13, dense_output=True).sol
    return np.hypot(*dense(np.linspace(0.0, until, 200_000))[:2])


@pytest.mark.slow
def test_a_hundred_thousand_turns(tmp_path: Path) -> None:
    """A file of less than 50 MB; the largest amplitude, of the first seconds, is in what is stored of its limits."""
    result = package.run_file(R1, {"study.turns": 100_000.0}, folder=tmp_path)
    assert (tmp_path / "result.nc").stat().st_size < 50e6
    peak, largest = r1_radius(6.0).max(), float(result.greatest_radius.max())
    assert result.wucht.summary["peak_amplitude"] == pytest.approx(peak, rel=1e-6)
    assert largest == pytest.approx(peak, rel=1e-6)
    assert "samples a turn are stored" in result.wucht.warnings[-1]
