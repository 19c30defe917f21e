"""What a page of a live machine may load: nothing. Where a server judges its runs, it may ask that one."""

from __future__ import annotations

# The page computes in a worker, whose script is part of the page.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:"


def page_policy(asks_server: bool) -> str:
    """Return the Content-Security-Policy of a page. asks_server: whether it may send requests to where it comes from."""
    return f"{_POLICY}; connect-src 'self'" if asks_server else _POLICY
