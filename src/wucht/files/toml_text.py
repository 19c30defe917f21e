"""A document as the text of a TOML file, which reads back as the same document."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from wucht.files.documents import Document

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(document: Mapping[str, Any]) -> str:
    """Write a document as TOML. Keys without a value (None) are left out.

    Examples
    --------
    >>> print(toml_text({"title": "A drum", "study": {"range": [0, 9], "start": {"b1": 0.3}}}))
    title = "A drum"
    <BLANKLINE>
    [study]
    range = [0, 9]
    <BLANKLINE>
    [study.start]
    b1 = 0.3
    <BLANKLINE>
    """
    return "\n".join(_lines(document, "")).lstrip("\n") + "\n"


def _lines(table: Mapping[str, Any], path: str) -> Iterator[str]:
    """The lines of a table: its values before the tables inside, which would otherwise take them."""
    inside = {key: value for key, value in table.items() if _is_table(value) or _is_list_of_tables(value)}
    for key, value in table.items():
        if value is not None and key not in inside:
            yield f"{_key(key)} = {_value(value)}"
    for key, value in inside.items():
        name = path + _key(key)
        for one in [value] if _is_table(value) else value:
            yield f"\n[{name}]" if _is_table(value) else f"\n[[{name}]]"
            yield from _lines(one, f"{name}.")


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping)


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list | tuple) and len(value) > 0 and all(map(_is_table, value))


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _string(key)


def _value(value: Any) -> str:
    if _is_table(value):
        return f"{{ {', '.join(f'{_key(k)} = {_value(v)}' for k, v in value.items() if v is not None)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(one) for one in value if one is not None)}]"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, int | float) else _string(str(value))


def _string(text: str) -> str:
    """A basic string: as in JSON, but for one control character that JSON leaves as it is."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def abridge(value: Any, longest: int, most: int) -> Any:
    """A document for printing: texts of at most this many characters, lists of at most this many items, the rest counted."""
    if isinstance(value, str) and len(value) > longest:
        return f"{value[:longest]}… ({len(value) - longest:,} more characters)"
    if isinstance(value, Mapping):
        return Document({abridge(key, longest, most): abridge(one, longest, most) for key, one in value.items()})
    if isinstance(value, list | tuple):
        head = [abridge(one, longest, most) for one in value[:most]]
        return head if len(value) <= most else [*head, _remainder(value, most)]
    return value


def _remainder(value: list[Any] | tuple[Any, ...], most: int) -> Any:
    count = f"… {len(value) - most:,} more"
    return {"abridged": count} if all(map(_is_table, value)) else count
