"""The study file that a page shows is read without files and without code; its verdict is that of the whole study."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.conftest import STUDY

from wucht import load_machine, run_file
from wucht.errors import InputError
from wucht.files.toml_text import toml_text
from wucht.studies.study_file import read_study
from wucht.web.shown_study import shown_study, shown_verdict

MOTOR = '[machine.drive]\non = "drum"\nkind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"\n'


def _ignore(share: float, label: str) -> None:
    """No progress is shown."""


def written(name: str) -> str:
    """The study file of a page of the catalogue, with the machine as it is built."""
    study_file = read_study(name)
    return toml_text({"title": study_file.subject.title, **study_file.document})


@pytest.mark.parametrize(
    "name",
    ["drozdetskaya-2020/table-5.1", "practice/screen"],
)
def test_the_verdict_is_that_of_the_whole_study(name: str) -> None:
    """The same machine is built, and judged alike."""
    text = written(name)
    assert shown_study(text).subject.values == load_machine(name).values
    result = run_file(name)
    assert shown_verdict(text, _ignore) == (result.wucht.summary["outcome"], result.wucht.sentence)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (MOTOR, '[machine.drive]\non = "drum"\nkind = "table"\nfile = "/etc/passwd"\n', "machine.drive.file: .*unknown key"),
        (MOTOR, MOTOR + '[machine.set]\n"drive.file" = "/etc/passwd"\n', "drive.file"),
        ("[machine.carrier]", '[machine.carrier]\nmotion = { direction = "x", table = "/etc/passwd" }', "table: .*unknown key"),
        ("[machine.carrier]", '[machine]\nuse = "/etc/passwd"\n[machine.carrier]', "machine.use: .*no file is read"),
        ("[study]", "[system]\n[study]", "system: .*unknown key"),
        ('kind = "run-up"', 'kind = "basin"', "study.kind: given 'basin'; must be 'run-up'"),
        ('kind = "run-up"', 'kind = "load-spectrum"\nsignal = { file = "/etc/passwd", column = "x" }', "study.kind"),
        ("start = {", "starts = [{ p1 = 0.1 }, { p1 = 0.2 }]\nunused = {", "unused|starts"),
        ('until = "0.5 s"', 'until = "0.5 s"\nalong = "drive.slope"\nvalues = [1, 2]', "study.along: .*one run is judged"),
        ('slope = "0.04 N m s"', 'slope = "-1 N m s"', "slope of the torque-speed curve of at least 0"),
        ('until = "0.5 s"', 'until = "1e12 s"', "study.until: .*can be computed"),
        ("[study]", "[study", "not valid TOML"),
        ('mass = "9 kg"', f"mass = {'9' * 5000}", "thousands of digits"),
        ('mass = "1 kg"', f"mass = {'[' * 200}{']' * 200}", "nested"),
    ],
)
def test_what_a_page_does_not_write_is_refused(old: str, new: str, sentence: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert old in STUDY
    monkeypatch.setattr(Path, "read_text", lambda *_, **__: pytest.fail("a file is read"))
    monkeypatch.setattr(Path, "open", lambda *_, **__: pytest.fail("a file is opened"))
    with pytest.raises(InputError, match=sentence):
        shown_verdict(STUDY.replace(old, new, 1), _ignore)


@pytest.mark.parametrize("text", ["", "machine = 3", "[study]\nkind = 'run-up'"])
def test_texts_without_a_machine_are_refused(text: str) -> None:
    with pytest.raises(InputError):
        shown_verdict(text, _ignore)


def test_a_run_can_be_stopped() -> None:
    def stop(share: float, label: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        shown_verdict(STUDY, stop)
