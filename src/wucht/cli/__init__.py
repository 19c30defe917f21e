"""The command line: one file per command."""

from __future__ import annotations

import gc
import os
import sys
import warnings
from contextlib import suppress
from typing import NoReturn, TextIO

_OBJECTS = 500_000  # new ones between two collections: more than libraries and formulas create on loading, which stay anyway


def main() -> None:
    """Entry point of ``wucht``."""
    from wucht.cli.surroundings import open_streams, without_figure_settings

    open_streams()
    gc.set_threshold(_OBJECTS)
    warnings.formatwarning = lambda message, *_, **__: f"warning: {message}\n"  # as other warnings of the command line
    without_figure_settings()
    from wucht.cli.app import run_app

    _leave(run_app())


def _leave(code: int) -> NoReturn:
    """End the process without freeing all objects, which would raise a short run from 3.4 s of processor time to 4.2 s."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError, AttributeError):  # the reader is gone, the stream is closed, or there is none
            _redirect_to_null(stream)
    gc.freeze()
    sys.exit(code)


def _redirect_to_null(stream: TextIO) -> None:
    """Send the rest of a stream to the null device: otherwise Python reports at exit that it could not be written."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
