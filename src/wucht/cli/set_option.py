"""``--set KEY=VALUE``: from the command line to settings by path."""

from __future__ import annotations

import json
import re
import tomllib
from contextlib import suppress
from typing import Any

from wucht.errors import InputError

_COMMA = re.compile(r",(?![^\[{]*[\]}])")  # not one within brackets


def parse_settings(given: list[str]) -> dict[str, Any]:
    """``["u=1.5", "drive.slope=0.02 N m s"]`` as a dictionary. Raises ``InputError``."""
    settings: dict[str, Any] = {}
    for item in given:
        key, equals, value = item.partition("=")
        if not equals or not key.strip() or not value.strip():
            raise InputError("--set", item, "must be KEY=VALUE, such as drive.slope=0.02")
        settings[key.strip()] = _value(value.strip())
    return settings


def parse_lists(given: list[str]) -> dict[str, list[Any]]:
    """``["u=1,1.5", "drive.slope=0.02 N m s,0.03 N m s"]`` as a dictionary of lists. Raises ``InputError``."""
    lists: dict[str, list[Any]] = {}
    for item in given:
        key, equals, values = item.partition("=")
        texts = [text.strip() for text in _COMMA.split(values)]
        if not equals or not key.strip() or not all(texts):
            raise InputError("--vary", item, "must be KEY=VALUE,VALUE,..., such as drive.slope=0.02,0.03")
        if key.strip() in lists:
            raise InputError("--vary", item, f"{key.strip()} is varied already; give all of its values at once")
        lists[key.strip()] = [_value(text) for text in texts]
    return lists


def _value(text: str) -> Any:
    """Numbers, true, false, lists and tables as in TOML (or JSON); all else is text (a quantity with its unit)."""
    if text[:1] in '["{' or text in ("true", "false"):
        with suppress(tomllib.TOMLDecodeError):
            return tomllib.loads(f"value = {text}")["value"]
        with suppress(json.JSONDecodeError):
            return json.loads(text)
        return text
    try:
        return float(text)
    except ValueError:
        return text
