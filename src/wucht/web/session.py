"""The secrets of one start of a server: by them it knows the browser of its user from all other programs of the computer."""

from __future__ import annotations

import secrets
from collections.abc import Iterable
from hmac import compare_digest

TOKEN_HEADER = "x-wucht-token"  # as in `session.ts`
_MOST_KEYS = 32  # that no page was opened with: so many pages may be on their way


class Session:
    """A first key, which is good once, and the two secrets that the browser gets for it; new ones at each start.

    The cookie is sent by the browser alone, but to every port of this computer, and so to servers of other accounts. The token
    is kept by the pages of this port, which no page of another port can read, and sent as a header. A header cannot be sent
    with a visit of a page: there, a key takes its place, which is given for cookie and token and is good once.

    Not safe to use from several threads: the event loop of the server has it alone.

    Parameters
    ----------
    port : int
        At which the server listens. It is part of the cookie's name: cookies do not belong to ports.
    """

    def __init__(self, port: int) -> None:
        self.first_key, self.token, self._cookie = (secrets.token_urlsafe(32) for _ in range(3))
        self._cookie_name = f"wucht-{port}"
        self._first_keys, self._keys = [self.first_key], list[str]()

    @property
    def set_cookie(self) -> str:
        """The header that gives the browser the cookie, until it is closed."""
        return f"{self._cookie_name}={self._cookie}; Path=/; HttpOnly; SameSite=Strict"

    def begins_with(self, key: str) -> bool:
        """Whether this is the first key; once."""
        return _is_taken_from(self._first_keys, key)

    def new_key(self) -> str:
        """Return a key for the visit of one page."""
        self._keys = [*self._keys, secrets.token_urlsafe(32)][-_MOST_KEYS:]
        return self._keys[-1]

    def opens_with(self, key: str) -> bool:
        """Whether this is a key for the visit of a page; once."""
        return _is_taken_from(self._keys, key)

    def has_cookie(self, headers: Iterable[str]) -> bool:
        """Whether the cookie is in one of these headers.

        A server at another port can give the browser a cookie of this name, too: any one of them may be the right one.
        """
        pairs = (pair.strip().partition("=") for header in headers for pair in header.split(";"))
        return any(name == self._cookie_name and _is_equal(value, self._cookie) for name, _, value in pairs)

    def has_token(self, headers: Iterable[str]) -> bool:
        """Whether these headers are the token."""
        return any(_is_equal(header, self.token) for header in headers)


def _is_taken_from(keys: list[str], key: str) -> bool:
    """Whether a key is one of these, which it then is no longer."""
    matches = [_is_equal(key, one) for one in keys]
    if True not in matches:
        return False
    del keys[matches.index(True)]
    return True


def _is_equal(text: str, secret: str) -> bool:
    """Whether texts are equal, compared in a time that does not depend on where they differ."""
    return compare_digest(text.encode(), secret.encode())
