"""The first page of ``wucht app``, which every visitor gets: it holds nothing of the user's."""

from __future__ import annotations

from functools import cache

from wucht.reports.markup import html_text
from wucht.web.live_page import built_file
from wucht.web.page_policy import page_policy

STRANGER = "This page belongs to the user who started wucht app: open the address that it printed."


def first_page(token: str = "") -> str:
    """Return the page that asks for a key to the page at its address.

    Parameters
    ----------
    token : str, optional
        Which the browser is to keep; by default it has it already, or it is that of a stranger.

    Returns
    -------
    str

    Raises
    ------
    WuchtError
        Where the page was not built when this package was installed.
    """
    head = '<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
    body = f"<noscript>{STRANGER} The page needs JavaScript.</noscript><script>{_script()}</script>"
    return (
        f'<!doctype html><html lang="en" data-token="{html_text(token)}"><head>{head}'
        f'<meta name="color-scheme" content="light dark"><title>wucht</title></head><body>{body}</body></html>'
    )


@cache
def first_page_policy() -> str:
    """Return its Content-Security-Policy: its own script, and requests to where it comes from."""
    return page_policy([_script()], asks_server=True)


@cache
def _script() -> str:
    return built_file("first_page.js")
