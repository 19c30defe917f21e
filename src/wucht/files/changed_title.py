"""A title that speaks of the values that were set: what it says of others would be read as what was computed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

_MOST = 3  # values named one by one


def changed_title(title: str, changed: Mapping[str, Any]) -> str:
    """The title of what is described, with values changed by path.

    A value that the title itself gives, as ``u = 2.5``, is replaced, and it is said from which; others are added in brackets.
    """
    added: list[str] = []
    for path, value in changed.items():
        written = re.compile(rf"(?<![\w.]){re.escape(path)} = ([-+]?\d[\w.+-]*)")
        if written.search(title):
            title = written.sub(lambda found, value=value: f"{path} = {_in_words(value)} (changed from {found[1]})", title)
        else:
            added.append(f"{path} = {_in_words(value)}")
    more = f" and {len(added) - _MOST} more" if len(added) > _MOST else ""
    return f"{title} (changed: {', '.join(added[:_MOST])}{more})" if added else title


def _in_words(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return str(value) if isinstance(value, str | int) else "..."
