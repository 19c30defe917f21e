"""Documents as editors write them; files that are none, or too large to be read."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path

import pytest
from tests import refusals

from wucht.errors import InputError
from wucht.files.catalogue import load_machine
from wucht.files.documents import DEEPEST, LARGEST, contents_digest, read_text, read_toml
from wucht.studies.registry import studies
from wucht.studies.study_file import read_study


def test_a_byte_order_mark_is_no_part_of_a_file(tmp_path):
    """Windows editors put one before UTF-8 text."""
    path = tmp_path / "machine.toml"
    path.write_bytes(b'\xef\xbb\xbftitle = "\xc3\x9cbung"\r\n[machine]\r\nuse = "drozdetskaya-2020/table-5.1"\r\n')
    assert read_toml(path)["title"] == "\u00dcbung"
    assert load_machine(str(path)).values["u"] == load_machine("drozdetskaya-2020/table-5.1").values["u"]


SHAKEN = """
[machine.carrier]
directions = "x"
motion = {{ direction = "x", amplitude = "1 mm", frequency = {} }}
[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = "1 kg"
eccentricity = "1 mm"
inertia = "1e-3 kg m^2"
[machine.drive]
kind = "induction"
voltage = "230 V"
frequency = {}
pole_pairs = 2
stator_resistance = "0.5 ohm"
rotor_resistance = "0.5 ohm"
stator_reactance = "1 ohm"
rotor_reactance = "1 ohm"
"""


def test_a_frequency_has_one_meaning(tmp_path):
    """A carrier's frequency is asked for with a unit; where a bare number is allowed, of the mains, it is in Hz."""
    path = tmp_path / "machine.toml"
    for written in ("20", "20.0", '"20"'):
        path.write_text(SHAKEN.format(written, "50"))
        sentence = r"machine\.carrier\.motion\.frequency: given '?20.*turns or radians; write '20(\.0)? Hz' or '20(\.0)? rad/s'"
        with pytest.raises(InputError, match=sentence):
            load_machine(str(path))
    for written, value in (('"20 Hz"', 40 * math.pi), ('"20 rad/s"', 20.0), ('"1200 rpm"', 40 * math.pi)):
        path.write_text(SHAKEN.format(written, "50"))
        machine = load_machine(str(path))
        assert machine.values["carrier.motion.frequency"] == pytest.approx(value, rel=1e-14)
        assert machine.values["drive.frequency"] == 50.0


def test_a_frequency_of_a_cam_drive_has_a_unit(tmp_path):
    path = tmp_path / "cam.toml"
    path.write_text(studies()["cam-prediction"].template.replace('"60 Hz"', "60"))
    with refusals.refused("shaft.elastic.output_frequency", "60 Hz", "60 rad/s", given=60):
        read_study(str(path))


def test_nor_is_what_waits_for_a_writer(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with refusals.refused("", given=None, file="pipe"):
        read_text(tmp_path / "pipe")
    assert contents_digest(tmp_path / "pipe") == ""


def test_a_file_larger_than_what_is_read(tmp_path: Path) -> None:
    large = tmp_path / "large"
    with large.open("wb") as file:
        file.truncate(LARGEST + 1)  # a hole: it takes no room
    with refusals.refused("", "1 GB", given=None, file="large"):
        read_text(large)
    with large.open("wb") as file:
        file.truncate(5 * LARGEST // 2)
    with refusals.refused("", "2.5 GB", "1 GB", given=None, file="large"):
        read_text(large)
    with large.open("wb") as file:
        file.write(b"1,2\n")
    assert read_text(large) == "1,2\n"
    assert len(contents_digest(large)) == 64


@pytest.mark.parametrize(("opening", "closing"), [("[", "]"), ("{a = ", "}")])
def test_tables_and_lists_may_be_nested_as_deep_as_is_said(tmp_path: Path, opening: str, closing: str) -> None:
    """The document itself is the outermost table."""
    file, deepest = tmp_path / "study.toml", DEEPEST - 1
    file.write_text(f"b = 1\nx = {opening * deepest}1{closing * deepest}\n")
    assert read_toml(file)["b"] == 1
    file.write_text(f"b = 1\nx = {opening * (deepest + 1)}1{closing * (deepest + 1)}\n")
    with refusals.refused("x", str(DEEPEST), given=None, file="study.toml"):
        read_toml(file)


@pytest.mark.parametrize("part", ["a", '"a.b"', "'a'", "a-1"])
def test_keys_have_as_many_parts_as_tables_may_be_nested(tmp_path: Path, part: str) -> None:
    """Counted before they are read, in keys alone: texts and comments may have as many points as they like."""
    file, points = tmp_path / "study.toml", "a." * 100
    harmless = (
        f"""t = "{points}"\n# {points}\nu = '''\n{points} = 1''''\nv = ["\\"{points}", 1.5]\nw = \"\"\"\n{points}\"\"\"\"\n"""
    )
    allowed, refused = (" . ".join([part] * number) for number in (DEEPEST, DEEPEST + 1))
    file.write_text(f"{harmless}{allowed} = 1\n", encoding="utf-8")
    assert read_toml(file)["t"] == points
    for text in (f"{harmless}{refused} = 1\n", f"{harmless}x = {{ {refused} = 1 }}\n", f"{harmless}[{refused}]\n"):
        file.write_text(text, encoding="utf-8")
        with refusals.refused(part, str(DEEPEST), f"line {len(harmless.splitlines()) + 1}", given=None, file="study.toml"):
            read_toml(file)
    file.write_text(f"{part}{f' . {part}' * 20_000} = 1\n", encoding="utf-8")
    begin = time.process_time()
    with refusals.refused(part, str(DEEPEST), given=None, file="study.toml"):
        read_toml(file)
    assert time.process_time() - begin < 0.3, "tomllib takes 10 s"


def test_a_value_in_the_title_is_replaced_and_others_are_added() -> None:
    name = "drozdetskaya-2020/figure-5.14"
    assert load_machine(name, {"u": 5.0}).title == "Figure 5.14: u = 5 (changed from 2.5)"
    assert load_machine(name, {"mu": 0.2}).title == "Figure 5.14: u = 2.5 (changed: mu = 0.2)"
