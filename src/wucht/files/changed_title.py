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
        now = f"{path} = {_in_words(value)}"
        written = re.search(rf"(?<![\w.]){re.escape(path)} = ([-+]?\d[\w.+-]*)", title)
        if written:
            title = f"{title[: written.start()]}{now} (changed from {written[1]}){title[written.end() :]}"
        else:
            added.append(now)
    more = f" and {len(added) - _MOST} more" if len(added) > _MOST else ""
    return f"{title} (changed: {', '.join(added[:_MOST])}{more})" if added else title


def _in_words(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return str(value) if isinstance(value, str | int) else "..."
