"""What is refused, or fails, as tests expect it: by the fields of the error, so that its sentence may be worded anew.

``with refused("study.range[1]", given=3.0):``; cases of a table may be such refusals, ``with refusal:``.
"""

from __future__ import annotations

import re
from types import TracebackType

import pytest

from wucht.errors import InputError, RunError, WuchtError

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
