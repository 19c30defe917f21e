"""What is refused, or fails, as tests expect it: by the fields of the error, so that its sentence may be worded anew.

``with refused("study.range[1]", given=3.0):``; cases of a table may be such refusals, ``with refusal:``.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import pytest

from wucht import InputError, RunError, WuchtError, run_file

_ANYTHING = object()


class Refusal:
    """An error that is expected in a ``with``: its class, its code, and what its sentence names, whatever the words."""

    def __init__(self, error: type[WuchtError], code: str, naming: tuple[str, ...]) -> None:
        self.error, self.code, self.naming = error, code, naming

    def __enter__(self) -> pytest.ExceptionInfo[WuchtError]:
        self._expected = pytest.raises(self.error)
        return self._expected.__enter__()

    def __exit__(self, error: type[BaseException] | None, value: BaseException | None, where: TracebackType | None) -> bool:
        caught = self._expected.__exit__(error, value, where)
        if caught:
            self.check(value)
        return caught

    def check(self, error: BaseException | None) -> None:
        """The error is of the class that was expected; where that is ``WuchtError``, neither bad input nor a failed run."""
        assert isinstance(error, self.error), repr(error)
        assert self.error is not WuchtError or not isinstance(error, InputError | RunError), repr(error)
        assert error.code == self.code, f"{error.code!r}: {error}"
        for name in self.naming:
            assert re.search(rf"(?<![\w.]){re.escape(name)}(?!\w)", str(error)), f"{name!r} is not named: {error}"


class _InputRefusal(Refusal):
    def __init__(self, key: str, given: object, code: str, file: str | None, naming: tuple[str, ...]) -> None:
        super().__init__(InputError, code, naming)
        self.key, self.given, self.file = key, given, file

    def check(self, error: BaseException | None) -> None:
        """Besides: the key, what was given, the name of the file; and the sentence states them."""
        super().check(error)
        assert isinstance(error, InputError)
        assert _without_folders(error.key) == self.key, f"{error.key!r}: {error}"
        assert self.given is _ANYTHING or repr(error.value) == repr(self.given), f"{error.value!r}: {error}"
        assert self.file is None or _without_folders(error.file) == self.file, f"{error.file!r}: {error}"
        assert str(error).startswith(error.location)
        assert error.key in error.location
        assert error.value_text in str(error)


def _without_folders(place: str) -> str:
    return re.sub(r"(?<!\S)(?:[A-Z]:)?[/\\]\S*[/\\]", "", place)


def refused(key: str, *naming: str, given: object = _ANYTHING, code: str = "", file: str | None = None) -> Refusal:
    """An ``InputError`` at this key, with this code; ``naming``: names and numbers that help, such as the nearest known name.

    given: as a value. file: its name without the folder, as are keys that begin with the path of a file.
    """
    return _InputRefusal(key, given, code, file, naming)


def failed(code: str, *naming: str) -> Refusal:
    """A ``RunError`` of this code."""
    return Refusal(RunError, code, naming)


def rejected(code: str, *naming: str) -> Refusal:
    """A ``WuchtError`` of this code: equations or calls that make no sense."""
    return Refusal(WuchtError, code, naming)


# --- sentences, each stated once ---

SENTENCES = Path(__file__).with_name("stated") / "refusals.json"
_SHOWN, _MOST = 100, 2000  # characters of a long text that name a case; of a sentence


def check_refusal(case: str, ask: Callable[[], object]) -> InputError:
    """What is asked is refused with the key, the code and the sentence that ``tests/stated/refusals.json`` has for the case.

    A change that is meant is stated anew with ``WUCHT_STATE=1 python -m pytest -n 0 FILES`` and read in the difference.
    """
    with pytest.raises(InputError) as raised:
        ask()
    error = raised.value
    said = [_without_folders(error.key), error.code, _without_folders(str(error))]
    stated = json.loads(SENTENCES.read_text(encoding="utf-8"))
    if os.environ.get("WUCHT_STATE"):
        stated[case] = said
        lines = (
            f" {json.dumps(name, ensure_ascii=False)}: {json.dumps(stated[name], ensure_ascii=False)}"
            for name in sorted(stated)
        )
        SENTENCES.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    assert said == stated.get(case), f"{case}: {said}, stated {stated.get(case)}"
    return error


def check_file(name: str, text: str, changes: Mapping[str, str], settings: Mapping[str, Any] | None = None) -> InputError:
    """A study file, written here as ``study.toml`` with some of its text changed, is refused as is stated; nothing is written.

    name: of the file, with which the cases begin.
    """
    for old, new in changes.items():
        assert old in text, f"{old!r} is not in the file"
        text = text.replace(old, new, 1)
    Path("study.toml").write_text(text, encoding="utf-8")
    words = [_short(f"{old} -> {new}") for old, new in changes.items()]
    words += [_short(f"{key} = {value!r}") for key, value in (settings or {}).items()]
    error = check_refusal(f"{name}: {', '.join(words)}", lambda: run_file("study.toml", settings, folder="out"))
    assert len(str(error)) < _MOST and "\n" not in str(error)
    assert not Path("out").exists(), "a refused study leaves no folder behind"
    return error


def cases_of(changes: Mapping[str, Iterable[str]]) -> list[Any]:
    """Parameters (old, new) of a test, from the texts that take the place of each."""
    return [pytest.param(old, new, id=_short(f"{old} -> {new}")) for old, texts in changes.items() for new in texts]


def _short(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN // 2]}...{text[-_SHOWN // 4 :]} ({len(text)})"
