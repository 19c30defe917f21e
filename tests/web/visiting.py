"""The user's browser, as a test client that has opened the first page."""

from __future__ import annotations

import re

import pytest
from starlette.testclient import TestClient
from tests.web.built_page import REASON

from wucht.web.local_requests import LocalRequests
from wucht.web.session import TOKEN_HEADER, Session


def opened(application: LocalRequests, session: Session, address: str = "http://127.0.0.1:8417") -> TestClient:
    """A client that has the cookie, and sends the token, as the pages do; it was opened with the session's first key."""
    if REASON:
        pytest.skip(REASON)
    client = TestClient(application, base_url=address)
    page = client.get("/", params={"key": session.first_key}).text
    client.headers[TOKEN_HEADER] = re.search('data-token="([^"]+)"', page)[1]  # type: ignore[index]
    return client
