"""Documents as editors write them; files that are none, or too large to be read."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests import refusals

from wucht.errors import InputError
from wucht.files.catalogue import load_equations, load_machine
from wucht.files.documents import (
    DEEPEST,
    LARGEST,
    changed_title,
    contents_digest,
    flatten,
    read_text,
    read_toml,
    refuse_bare_frequencies,
    settings_in,
)
from wucht.studies.registry import studies
from wucht.studies.study_file import read_study

Refused = Callable[..., str]
Study = Callable[..., Path]


def test_a_byte_order_mark_is_no_part_of_a_file(tmp_path):
    """Windows editors put one before UTF-8 text."""
    path = tmp_path / "machine.toml"
    path.write_bytes(b'\xef\xbb\xbftitle = "\xc3\x9cbung"\r\n[machine]\r\nuse = "drozdetskaya-2020/table-5.1"\r\n')
    assert read_toml(path)["title"] == "\u00dcbung"
    assert load_machine(str(path)).values["u"] == load_machine("drozdetskaya-2020/table-5.1").values["u"]


@pytest.mark.parametrize("encoding", ["utf-16", "latin-1"])
def test_another_encoding_is_refused_with_a_remedy(tmp_path, encoding):
    path = tmp_path / "machine.toml"
    path.write_text('title = "\u00dcbung"', encoding=encoding)
    with refusals.refused("", "UTF", code="unreadable", file="machine.toml"):
        read_toml(path)


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


def test_a_frequency_that_is_set_has_a_unit_too(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(SHAKEN.format('"20 Hz"', "50"))
    assert load_machine(str(path), {"carrier.motion.frequency": "3 rad/s"}).values["carrier.motion.frequency"] == 3.0
    with refusals.refused("machine.carrier.motion.frequency", "3 Hz", "3 rad/s", given=3):
        load_machine(str(path), {"carrier.motion.frequency": 3})
    with refusals.refused("machine.carrier.motion.frequency", "0 rad/s", code="limits"):
        load_machine(str(path), {"carrier.motion.frequency": 0})


def test_a_frequency_of_a_cam_drive_has_a_unit(tmp_path):
    path = tmp_path / "cam.toml"
    path.write_text(studies()["cam-prediction"].template.replace('"60 Hz"', "60"))
    with refusals.refused("shaft.elastic.output_frequency", "60 Hz", "60 rad/s", given=60):
        read_study(str(path))


@pytest.mark.parametrize(
    ("text", "title"),
    [
        ('title = "Mine"\n[machine]\nuse = "drozdetskaya-2020/table-5.1"', "Mine"),
        ('title = "Mine"\n[machine]\ntitle = "Drum"\nuse = "drozdetskaya-2020/table-5.1"', "Drum"),
        ('[machine]\nuse = "drozdetskaya-2020/table-5.1"', load_machine("drozdetskaya-2020/table-5.1").title),
        ('[machine]\nuse = "other.toml"', "Other"),
    ],
)
def test_a_title_beside_use_counts(tmp_path, text, title):
    (tmp_path / "other.toml").write_text('title = "Other"\n[machine]\nuse = "drozdetskaya-2020/table-5.1"\n')
    path = tmp_path / "mine.toml"
    path.write_text(text)
    assert load_machine(str(path)).title == title


def test_a_device_is_not_read(refused: Refused, study: Study) -> None:
    """It would be read until the memory is full."""
    linear = 'kind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"'
    file = study(linear, 'kind = "table"\nfile = "/dev/zero"')
    refused("run", file, says=("study.toml: machine.drive.file: given '/dev/zero'; this is not a file",))
    assert contents_digest(Path("/dev/zero")) == ""


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


@pytest.mark.parametrize(
    ("name", "settings", "title"),
    [
        ("drozdetskaya-2020/figure-5.14", {}, "Figure 5.14: u = 2.5"),
        ("drozdetskaya-2020/figure-5.14", {"u": 5.0}, "Figure 5.14: u = 5 (changed from 2.5)"),
        ("drozdetskaya-2020/figure-5.14", {"u": 2.5}, "Figure 5.14: u = 2.5"),
        ("drozdetskaya-2020/figure-5.14", {"mu": 0.2}, "Figure 5.14: u = 2.5 (changed: mu = 0.2)"),
        ("drozdetskaya-2020/r1-u80", {"drive": {"slope": "0.02 N m s"}}, "R1, u = 80 (changed: drive.slope = 0.02 N m s)"),
    ],
)
def test_a_catalogue_machine_with_other_values(name: str, settings: dict[str, Any], title: str) -> None:
    assert load_machine(name, settings).title == title


def test_own_equations() -> None:
    assert (
        load_equations("drozdetskaya-2020/figure-2.13", {"mu": 1.2}).title == "Infinite-period bifurcation (changed: mu = 1.2)"
    )


def test_what_a_file_sets_is_known_to_its_own_title_and_to_no_other(here: Path) -> None:
    del here
    used = '[machine]\nuse = "drozdetskaya-2020/figure-5.14"\nset = { u = 5 }\n'
    Path("untitled.toml").write_text(used, encoding="utf-8")
    Path("titled.toml").write_text(f'title = "With u = 5"\n{used}', encoding="utf-8")
    assert load_machine("untitled.toml").title == "Figure 5.14: u = 5 (changed from 2.5)"
    assert load_machine("titled.toml").title == "With u = 5"
    assert load_machine("titled.toml", {"u": 6.0}).title == "With u = 6 (changed from 5)"
    assert load_machine("untitled.toml", {"u": 6.0}).title == "Figure 5.14: u = 6 (changed from 2.5)"


def test_a_name_within_another_is_left_alone() -> None:
    assert changed_title("At mu = 0.1, u = 2e-3", {"u": 1.0}) == "At mu = 0.1, u = 1 (changed from 2e-3)"
    assert changed_title("At drive.u = 3 and u1 = 4", {"u": 1.0}) == "At drive.u = 3 and u1 = 4 (changed: u = 1)"


def test_many_values_and_long_ones() -> None:
    changed = {"a": 1, "b": [1, 2], "c": "3 m", "d": 4.0, "e": 5}
    assert changed_title("T", changed) == "T (changed: a = 1, b = ..., c = 3 m and 2 more)"


def test_the_frequency_of_the_mains_is_bare_in_one_drive_and_in_each_of_several():
    refuse_bare_frequencies({"machine": {"drive": {"frequency": 50}, "drives": [{"frequency": 50}, {"frequency": 60.0}]}})
    with refusals.refused("machine.mounts[1].frequency", given=3):
        refuse_bare_frequencies({"machine": {"mounts": [{"frequency": "3 Hz"}, {"frequency": 3}]}})


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


@pytest.mark.parametrize(
    "text", ["a" * 10**6, '"' * (10**6 + 1), "." * 10**6, "'a" * 10**6, 'x = """' + '\\"""' * 10**5], ids=range(5)
)
def test_no_text_makes_that_count_slow(tmp_path: Path, text: str) -> None:
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    begin = time.process_time()
    with pytest.raises(InputError, match="not valid TOML"):
        read_toml(tmp_path / "study.toml")
    assert time.process_time() - begin < 3.0


@pytest.mark.parametrize(("text", "line"), [("a = 1\n\nb = {}\n", "3"), ("b = {}\n", "1"), ("\nb = -{}", "2")])
def test_a_number_of_thousands_of_digits_is_located(tmp_path: Path, text: str, line: str) -> None:
    (tmp_path / "study.toml").write_text(text.format("7" * 5000))
    with refusals.refused("", f"line {line}", given=None, file="study.toml"):
        read_toml(tmp_path / "study.toml")


def test_settings_are_flattened_and_taken_out() -> None:
    description: dict[str, Any] = {"set": {"drive": {"slope": 1, "gear": {"ratio": 2}}, "a.b": 3, "c": {}}, "title": "T"}
    assert settings_in(description) == {"drive.slope": 1, "drive.gear.ratio": 2, "a.b": 3, "c": {}}
    assert description == {"title": "T"}
    assert settings_in(description) == {}
    assert flatten({"slope": 1}, "drive.") == {"drive.slope": 1}
    with refusals.refused("system.set", given=[1]):
        settings_in({"set": [1]}, "system")


def test_a_value_in_the_title_is_replaced_with_its_sign_and_others_are_added() -> None:
    assert changed_title("Fan, u = -2.5e-3 and w = 1", {"u": 0.75}) == "Fan, u = 0.75 (changed from -2.5e-3) and w = 1"
    assert changed_title("Fan, u = 2", {"w": 1, "u": 3}) == "Fan, u = 3 (changed from 2) (changed: w = 1)"
    assert changed_title("Fan", dict.fromkeys("abc", 1)) == "Fan (changed: a = 1, b = 1, c = 1)"
    assert changed_title("Fan", dict.fromkeys("abcd", 1)) == "Fan (changed: a = 1, b = 1, c = 1 and 1 more)"
    assert changed_title("Fan", {"a": [1, 2]}) == "Fan (changed: a = ...)"
    assert changed_title("Fan", {}) == "Fan"
