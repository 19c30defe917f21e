"""What a study is asked of, as a System with values."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht import InputError, load_equations, load_machine
from wucht.files.catalogue import FOLDER, names
from wucht.machines.structure import DIMENSIONLESS
from wucht.machines.subject import Subject
from wucht.numerics.flow.program import Evaluator
from wucht.studies.memory import question_of, without_titles
from wucht.studies.study_file import read_study
from wucht.studies.subjects import MACHINE, MACHINE_OR_SYSTEM, MachineOrSystemSubject, subject_of

NUMBER = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
BARE = re.compile(rf"(?<=[\s\[,=]){NUMBER}(?=[\s\],}}]|$)")  # a TOML number
WITH_UNIT = re.compile(rf'(?<="){NUMBER}(?=\s[^"]*")')  # "50 Hz"
SILENT = re.compile(r"^\s*(title|source|notes|use|of|name|#|\[\[?[\w.]+\]\]?\s*(#|$))")
TEXT = re.compile(r'"""(?:.|\n)*?"""')
FAST = (
    "drozdetskaya-2020/r1", "practice/fan-on-belt", "practice/screen-loaded", "practice/laundry-drum-friction",
    "kaltofen-cam/dwell-and-return", "sperling-vibration/figure-4",
)  # fmt: skip


def changed(number: str) -> str:
    """A number with another last digit, or the next one where that is below the resolution of floating point."""
    mantissa, e, exponent = number.partition("e")
    last = mantissa[-1]
    other = f"{mantissa[:-1]}{int(last) + (1 if last < '9' else -1)}{e}{exponent}"
    return other if float(other) != float(number) else repr(math.nextafter(float(number), math.inf))


def with_one_number_changed(text: str) -> Iterator[tuple[str, str]]:
    """The same text with each of its numbers changed in turn, and what was changed."""
    begin, spoken = 0, TEXT.sub(lambda found: re.sub(r"[^\n]", "#", found.group()), text)
    for line in spoken.splitlines(keepends=True):
        code = line.split(" #")[0]
        if not SILENT.match(line):
            for found in (*BARE.finditer(code), *WITH_UNIT.finditer(code)):
                a, b = begin + found.start(), begin + found.end()
                yield f"{text[:a]}{changed(found.group())}{text[b:]}", f"{line.strip()}: {found.group()}"
        begin += len(line)


def asked(path: Path) -> Any:
    study = read_study(str(path))
    return without_titles(question_of(study.spec, study.subject, subject_of(study.spec).describe(study.subject)))


def unnoticed(name: str, folder: Path) -> tuple[list[str], int]:
    """The changes of one number that leave the question the same, and how many could be tried."""
    shutil.copytree((FOLDER / name).parent, folder, dirs_exist_ok=True)
    path = folder / f"{Path(name).name}.toml"
    text = path.read_text(encoding="utf-8")
    before, same, tried = asked(path), list[str](), 0
    for other, what in with_one_number_changed(text):
        path.write_text(other, encoding="utf-8")
        try:
            now = asked(path)
        except InputError:  # a number that cannot be another
            continue
        tried += 1
        if now == before:
            same.append(what)
    return same, tried


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in FAST else pytest.mark.slow) for n in names()])
def test_every_number_of_a_file_is_part_of_the_question(name: str, tmp_path: Path) -> None:
    same, tried = unnoticed(name, tmp_path)
    assert not same
    if name in FAST:
        assert tried > 3


def test_neither_titles_nor_comments_nor_how_a_number_is_written_are(tmp_path: Path) -> None:
    text = """title = "{title}"
[machine]
use = "practice/fan-on-belt"
[machine.set]
"carrier.mass" = {mass}
[study]
kind = "run-up"
until = {until}
"""
    path = tmp_path / "a.toml"
    questions = []
    for title, mass, until in (("A", "112", '"40 s"'), ("B", "112.0  # kg", "40"), ("B", '"112000 g"', "4e1")):
        path.write_text(text.format(title=title, mass=mass, until=until), encoding="utf-8")
        questions.append(asked(path))
    assert questions[0] == questions[1] == questions[2]


def test_machines_and_own_equations_are_systems_with_values() -> None:
    own, machine = load_equations("drozdetskaya-2020/figure-2.10"), load_machine("drozdetskaya-2020/table-5.1")
    subjects: tuple[Subject, ...] = own, machine
    for each in subjects:
        numbers = each.system.values(each.values)
        rates = Evaluator.of_rates(each.system)(np.zeros(1), np.full((len(each.system.states), 1), 0.3), numbers)
        assert np.isfinite(list(rates.values())).all()
        described = MACHINE_OR_SYSTEM.describe(each)
        assert described.facts["parameters"] == dict(each.values) and described.dimensionless
        assert each.units == DIMENSIONLESS and not each.schedules
        path = next(iter(each.values))
        assert each.with_values({path: 0.25}).values == {**each.values, path: 0.25}


def test_subjects_are_machines_or_equations(tmp_path: Path) -> None:
    with refused("machine", "must be a machine", given="drum"):
        MACHINE.describe("drum")
    either = MachineOrSystemSubject()
    with refused("machine", given=None):
        either.from_document({"study": {}}, tmp_path, "a", {})
    with refused("system", given=None):
        either.from_document({"study": {}, "system": {}, "machine": {}}, tmp_path, "a", {})
