"""What a page of a live machine may load: nothing. Where a server judges its runs, it may ask that one."""

from __future__ import annotations

import hashlib
from base64 import b64encode
from collections.abc import Sequence

# The page computes in a worker, whose script is part of the page.
_POLICY = "style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:"
_META = '<meta http-equiv="Content-Security-Policy" content="'


def page_policy(scripts: Sequence[str] = (), *, asks_server: bool = False) -> str:
    """Return the Content-Security-Policy of a page.

    Parameters
    ----------
    scripts : sequence of str, optional
        The texts of its scripts: no others are run, nor code in attributes.
    asks_server : bool, optional
        Whether it may send requests to where it comes from.

    Returns
    -------
    str
    """
    hashes = " ".join(f"'sha256-{b64encode(hashlib.sha256(text.encode()).digest()).decode()}'" for text in scripts)
    return "; ".join(
        ["default-src 'none'", *([f"script-src {hashes}"] if hashes else []), _POLICY, *(["connect-src 'self'"] * asks_server)]
    )


def policy_tag(policy: str) -> str:
    """Return the tag by which a page states its policy: the first one that has a text of the user's behind it."""
    return f'{_META}{policy}">'


def stated_policy(page: str) -> str:
    """Return the policy that a page states by its tag."""
    return page.partition(_META)[2].partition('"')[0]
