"""Whether the page was built when the package was installed."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from wucht.errors import WuchtError
from wucht.web.live_page import built_file


def _reason_against() -> str:
    """Why there is no page; empty where there is one."""
    try:
        built_file("live.js")
    except WuchtError as error:
        return str(error)
    return ""


REASON = _reason_against()
needs_fastapi = pytest.mark.skipif(find_spec("fastapi") is None, reason="fastapi, of the extra web, is not installed")
needs_page = pytest.mark.skipif(bool(REASON), reason=REASON)
