"""``--import``: files, folders and installed modules, and what cannot be imported."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests import refusals

from wucht.cli.options import parse_lists, parse_settings
from wucht.cli.surroundings import check_environment

Refused = Callable[..., str]


@pytest.fixture(autouse=True)
def _forgotten() -> Iterator[None]:
    """What these tests import is not kept for others."""
    before, path = set(sys.modules), list(sys.path)
    yield
    sys.path[:] = path
    for name in set(sys.modules) - before:
        if name.startswith("own_"):
            del sys.modules[name]


def write(path: str, text: str = "") -> Path:
    place = Path(path)
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(text, encoding="utf-8")
    return place


def test_a_file_is_imported_once(wucht: Any, here: Path) -> None:
    write("own_a.py", "from pathlib import Path\nwith Path('count').open('a') as f:\n    f.write('x')\n")
    for _ in range(2):
        assert wucht("run", "--import", "own_a.py", "nothing.toml").code == 2
    assert Path("count").read_text() == "x" and Path("own_a.py").stem in sys.modules


def test_a_folder_is_a_package_with_its_spec(wucht: Any, here: Path) -> None:
    write("own_b/__init__.py", "from own_b.inner import value\n")
    write("own_b/inner.py", "value = 3\n")
    write("own_b/spec.py", "value = 4\n")
    write("own_c/__init__.py")
    assert wucht("run", "--import", "own_b", "--import", "own_c", "nothing.toml").code == 2
    assert sys.modules["own_b"].value == 3 and sys.modules["own_b.spec"].value == 4
    assert "own_c" in sys.modules and "own_c.spec" not in sys.modules


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("own_missing.py", "there is no such file or folder"),
        ("own_missing", "it cannot be imported: ModuleNotFoundError: No module named 'own_missing'"),
        ("own_empty", "must be a module: a .py file, or a folder with __init__.py"),
        ("own_wrong.py", "it cannot be imported: ZeroDivisionError: division by zero"),
    ],
)
def test_what_cannot_be_imported_is_refused(refused: Refused, here: Path, given: str, says: str) -> None:
    Path("own_empty").mkdir()
    write("own_text.txt", "value = 3")
    write("own_wrong.py", "1 / 0")
    write("own_ending.py", "import sys\nassert 'own_ending' in sys.modules\nraise ValueError('own')")
    for _ in range(2):
        said = refused("run", "--import", given, "nothing.toml")
        assert f"--import: given '{given}'; {says}" in said
        assert Path(given).stem not in sys.modules, "what was not imported is not kept"


def test_a_refusal_of_the_module_is_told_as_it_is(refused: Refused, here: Path) -> None:
    write("own_refusal.py", "from wucht.errors import InputError\nraise InputError('key', 3, 'must be 4')")
    assert refused("run", "--import", "own_refusal.py", "nothing.toml") == "wucht: key: given 3; must be 4\n"


@pytest.mark.parametrize(
    ("written", "values"),
    [
        ([" drive.slope = 0.02 N m s "], {"drive.slope": "0.02 N m s"}),
        (["a=b=c"], {"a": "b=c"}),
        (["a=true", "b=false", "c=True"], {"a": True, "b": False, "c": "True"}),
        (['a="1"', "b=[1, 2.5]", "c={x = 1}", 'd={"x": 1}'], {"a": "1", "b": [1, 2.5], "c": {"x": 1}, "d": {"x": 1}}),
        (["a=[1, oops"], {"a": "[1, oops"}),
    ],
)
def test_settings_are_numbers_tables_or_texts(written: list[str], values: dict[str, Any]) -> None:
    settings = parse_settings(written)
    assert settings == values
    assert [type(v) for v in settings.values()] == [type(v) for v in values.values()]


@pytest.mark.parametrize("written", ["u", "u=", "=1"])
def test_a_setting_is_a_key_and_a_value(written: str) -> None:
    with refusals.refused("--set", given=written):
        parse_settings(["a=1", written])


@pytest.mark.parametrize(
    ("written", "values"),
    [("a=1, 2 ,3", [1.0, 2.0, 3.0]), ("a=[1,2],[3,4]", [[1, 2], [3, 4]]), ("a=x,true", ["x", True]), ("a=1],2", ["1]", 2.0])],
)
def test_values_of_a_list_are_split_outside_brackets(written: str, values: list[Any]) -> None:
    assert parse_lists([written]) == {"a": values}


@pytest.mark.parametrize("written", ["a=1,,2", "a", "=1,2"])
def test_a_list_without_one_of_its_values_is_refused(written: str) -> None:
    with refusals.refused("--vary", given=written):
        parse_lists([written])


@pytest.mark.parametrize(
    ("seconds", "taken"),
    [("0", True), ("253402300799", True), ("253402300800", False), ("abc", False), (" 1", False), ("٣", False)],
)
def test_the_date_of_files_is_within_the_calendar(monkeypatch: pytest.MonkeyPatch, seconds: str, taken: bool) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", seconds)
    if taken:
        check_environment()
    else:
        with refusals.refused("SOURCE_DATE_EPOCH", given=seconds):
            check_environment()
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    check_environment()


def test_an_installed_module_is_imported_by_its_name(wucht: Any, here: Path) -> None:
    write("place/own_d.py", "value = 5\n")
    sys.path.insert(0, str(here / "place"))
    assert wucht("run", "--import", "own_d", "nothing.toml").code == 2
    assert sys.modules["own_d"].value == 5
