"""A result that was computed is never lost by what shows it: an error of a figure, table or report becomes a warning."""

from __future__ import annotations

import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from wucht.errors import WuchtError
from wucht.results.store import to_json

if TYPE_CHECKING:
    import xarray as xr

_BEGIN = "not written: "  # of the warnings


class Attempts:
    """Attempts to show a result, each on its own: one that fails leaves a sentence in ``warnings``."""

    def __init__(self) -> None:
        self.warnings: list[str] = []

    @contextmanager
    def attempt(self, what: str, passing: type[Exception] | tuple[type[Exception], ...] = ()) -> Iterator[None]:
        """Turn an error of the block into a warning that names what could not be written. Ctrl-C passes, and passing errors."""
        try:
            yield
        except passing:
            raise
        except Exception as error:  # also those of studies of other packages
            self.warnings.append(f"{_BEGIN}{what} ({reason_of(error)}); the result itself is complete")


def reason_of(error: Exception) -> str:
    """The sentence of an error; of one that nobody raised on purpose its kind, the first line and where it was raised."""
    if isinstance(error, WuchtError):
        return str(error)
    frames, text = traceback.extract_tb(error.__traceback__), str(error).partition("\n")[0]
    place = f" in {Path(frames[-1].filename).name}, line {frames[-1].lineno}" if frames else ""
    return f"{type(error).__name__}{place}{f': {text}' if text else ''}"


def is_attempt_warning(warning: str) -> bool:
    """True for a warning that something could not be written."""
    return warning.startswith(_BEGIN)


def with_attempt_warnings(result: xr.Dataset, warnings: Sequence[str]) -> xr.Dataset:
    """The result with these warnings in place of those of earlier attempts to show it; the same Dataset if nothing changes."""
    before: list[str] = result.wucht.warnings
    after = [*(warning for warning in before if not is_attempt_warning(warning)), *warnings]
    return result if after == before else result.assign_attrs(warnings=to_json(after, indent=None))
