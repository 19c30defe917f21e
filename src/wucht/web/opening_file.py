"""A file that opens the server's first page: the address holds a secret, and the arguments of a browser are public."""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path

from wucht.errors import RunError
from wucht.reports.markup import html_text


class OpeningFile:
    """A page that this account alone can read, and which leads the browser to an address.

    Parameters
    ----------
    address : str

    Raises
    ------
    RunError
        Where it cannot be written.
    """

    def __init__(self, address: str) -> None:
        link = html_text(address)
        page = (
            '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>wucht</title>'
            f'<meta http-equiv="refresh" content="0;url={link}"></head><body><a href="{link}">Open wucht</a></body></html>'
        )
        try:
            descriptor, path = tempfile.mkstemp(prefix="wucht-", suffix=".html")  # of mode 0600
            self.path = Path(path)
            with os.fdopen(descriptor, "w", encoding="utf-8") as file:
                file.write(page)
        except OSError as error:
            raise RunError(f"the file that opens the browser cannot be written: {error.strerror}") from None

    def remove(self) -> None:
        """Remove it, if it is still there."""
        with suppress(OSError):
            self.path.unlink()
