"""The command line: one file a command."""

from __future__ import annotations

import gc
import os
import sys
import warnings
from contextlib import suppress

_OBJECTS = 200_000  # more between two collections: what libraries and formulas make when they are loaded stays anyway


def main() -> None:
    """Entry point of ``wucht``."""
    from wucht.cli.surroundings import open_streams, without_settings_of_figures

    open_streams()
    if sys.argv[1:2] == ["complete-words"]:  # a shell asks, as the scripts of ``completion`` do
        from wucht.cli.completing import words

        sys.stdout.write("".join(f"{word}\n" for word in words(" ".join(sys.argv[2:]))))
        _leave(0)
    gc.set_threshold(_OBJECTS)
    warnings.formatwarning = lambda message, *_, **__: f"warning: {message}\n"  # as other warnings of the command line
    without_settings_of_figures()
    from wucht.cli.app import run_app

    _leave(run_app())


def _leave(code: int) -> None:
    """End the process at once: taking formulas and compiled code apart would be a tenth of a short run."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # the reader is gone, the stream is closed, or there is none
            stream.flush()
    os._exit(code)
