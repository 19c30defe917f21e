"""``--set KEY=VALUE``: from the command line to settings by path."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable
from contextlib import suppress
from itertools import accumulate
from typing import Any

from wucht.errors import InputError
from wucht.files.documents import DEEPEST

_OUTSIDE = re.compile(r"[^,\[\]{}]+|[,\[\]{}]")  # stretches without a comma or bracket, and those one by one


def parse_settings(given: list[str]) -> dict[str, Any]:
    """``["u=1.5", "drive.slope=0.02 N m s"]`` as a dictionary. Raises ``InputError``."""
    settings: dict[str, Any] = {}
    for item in given:
        key, equals, value = item.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise InputError("--set", item, "must be KEY=VALUE, such as drive.slope=0.02")
        path = _path("--set", key)
        settings[path] = _value(f"--set {path}", value.strip())
    return settings


def parse_lists(given: list[str]) -> dict[str, list[Any]]:
    """``["u=1,1.5", "drive.slope=0.02 N m s,0.03 N m s"]`` as a dictionary of lists. Raises ``InputError``."""
    lists: dict[str, list[Any]] = {}
    for item in given:
        key, equals, values = item.partition("=")
        texts = [text.strip() for text in _split(values)]
        if not equals or not key.strip() or not all(texts):
            raise InputError("--vary", item, "must be KEY=VALUE,VALUE,..., such as drive.slope=0.02,0.03")
        if (path := _path("--vary", key)) in lists:
            raise InputError("--vary", item, f"{path} is varied already; give all of its values at once", code="given-twice")
        lists[path] = [_value(f"--vary {path}", text) for text in texts]
    return lists


def _path(option: str, key: str) -> str:
    """A key without the blanks around it. Raises ``InputError`` for one of more parts than tables lie within each other."""
    if key.count(".") >= DEEPEST:
        raise InputError(option, key, f"must be a key of at most {DEEPEST} parts, such as drive.slope")
    return key.strip()


def _split(values: str) -> list[str]:
    """The values between commas, but for those within brackets."""
    parts, depth = [""], 0
    for stretch in _OUTSIDE.findall(values):
        depth += (stretch in "[{") - (stretch in "]}")
        if stretch == "," and depth <= 0:
            parts.append("")
        else:
            parts[-1] += stretch
    return parts


def _value(option: str, text: str) -> Any:
    """Numbers, true, false, lists and tables as in TOML (or JSON); all else is text (a quantity with its unit).

    Raises ``InputError`` for what is nested too deeply, and for numbers of thousands of digits.
    """
    if text[:1] in '["{' or text in ("true", "false"):
        if max(text.count("["), text.count("{")) > DEEPEST and _depth(text) > DEEPEST:
            raise InputError(option, text, f"must be a value in which at most {DEEPEST} brackets are nested")
        with suppress(tomllib.TOMLDecodeError):
            return _loaded(option, text, lambda: tomllib.loads(f"value = {text}")["value"])
        with suppress(json.JSONDecodeError):
            return _loaded(option, text, lambda: json.loads(text))
        return text
    try:
        return float(text)
    except ValueError:
        return text


def _depth(text: str) -> int:
    """How many brackets are open at once, at most."""
    return max(accumulate((letter in "[{") - (letter in "]}") for letter in text))


def _loaded(option: str, text: str, load: Callable[[], Any]) -> Any:
    """What a text holds. Raises ``InputError`` for numbers of thousands of digits, which Python refuses to read."""
    try:
        return load()
    except (tomllib.TOMLDecodeError, json.JSONDecodeError):
        raise
    except ValueError:
        raise InputError(option, text, "a number of thousands of digits cannot be read") from None
