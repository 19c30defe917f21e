"""The two kinds of errors: the input is wrong (exit code 2), or a run fails (exit code 1)."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import date, time
from difflib import get_close_matches
from functools import partial

_LONGEST = 80  # characters of a value
_LONGEST_LOCATION = 2000  # likewise of a location, as of a column whose heading is a whole file
_MOST_KNOWN = 200  # names that are listed; all of the catalogue


class WuchtError(Exception):
    """A sentence for the user. Base class of all errors that wucht raises on purpose.

    code: the fault in a word or two that stay when the sentence changes; empty where class and location suffice.
    """

    def __init__(self, sentence: str, *, code: str = "") -> None:
        super().__init__(sentence)
        self.code = code


class InputError(WuchtError):
    """The input is wrong: which key of which file, the given value, what is allowed.

    location: all that is known of it, as printed; in the sentence a very long one is shortened. file, key: its parts; empty
    where it is not in a file, or where the file itself is wrong. value_text: the given value, shortened.
    """

    def __init__(
        self, location: str, value: object, explanation: str, file: str = "", key: str | None = None, code: str = ""
    ) -> None:
        self.location, self.value, self.explanation = location, value, explanation
        self.file, self.key = file, location if key is None else key
        self.value_text = "" if value is None else short_text(value)
        place = (
            location if len(location) <= _LONGEST_LOCATION else f"{location[: _LONGEST_LOCATION - 110]} ... {location[-100:]}"
        )
        super().__init__(f"{place}:{f' given {self.value_text};' if self.value_text else ''} {explanation}", code=code)

    @classmethod
    def file_error(cls, path: object, explanation: str, code: str = "") -> InputError:
        """An error of a file as a whole, or of a missing file."""
        return cls(str(path), None, explanation, str(path), "", code)

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str, str, str, str]]:
        """Support pickling, to pass the error between processes."""
        return InputError, (self.location, self.value, self.explanation, self.file, self.key, self.code)

    def with_prefix(self, prefix: str, separator: str = ".") -> InputError:
        """The same error, located from one level further out."""
        location, key = (f"{prefix}{separator}{inner}" if inner else prefix for inner in (self.location, self.key))
        return InputError(location, self.value, self.explanation, self.file, key, self.code)

    def with_file(self, path: object) -> InputError:
        """The same error, located with its file; an error that knows its file keeps it."""
        location = f"{path}: {self.location}" if self.location else str(path)
        return InputError(location, self.value, self.explanation, self.file or str(path), self.key, self.code)


def short_text(value: object) -> str:
    """A given value as text on one line of limited length."""
    if isinstance(value, str) and len(value) > 3 * _LONGEST:
        value = f"{value[:_LONGEST]}{value[-_LONGEST:]}"  # what is shown of it: its whole may take seconds
    try:
        text = str(value) if isinstance(value, date | time) else repr(value)
    except ValueError:  # Python refuses to print integers of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 20]} ... {text[-10:]}"


class FieldError(ValueError):
    """A value that a field does not admit: a sentence, or key and sentence; an ``InputError`` when its location is known."""

    def __init__(self, *sentence: str, code: str) -> None:
        super().__init__(*sentence)
        self.code = code

    def __reduce__(self) -> tuple[partial[FieldError], tuple[str, ...]]:
        """Support pickling, to pass the error between processes."""
        return partial(FieldError, code=self.code), self.args


def code_of(error: ValueError) -> str:
    """The code of a ``FieldError``, empty for other errors."""
    return error.code if isinstance(error, FieldError) else ""


class RunError(WuchtError):
    """A run failed. The sentence gives time, state and a remedy."""


def nearest(name: str, known_names: Iterable[str]) -> str:
    """The clause that helps with an unknown name: the nearest known one, and the list.

    Parameters are the given name and the known ones. Returns e.g.
    ``did you mean 'stiffness'? known: damping, mass, stiffness``.
    """
    names = sorted(known_names)
    name = name[:_LONGEST]
    close = get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"did you mean {close[0]!r}? " if close else ""
    listing = ", ".join(n[:_LONGEST] for n in names[:_MOST_KNOWN]) or "none"
    more = f" and {len(names) - _MOST_KNOWN} more" if len(names) > _MOST_KNOWN else ""
    return f"{hint}known: {listing}{more}"
