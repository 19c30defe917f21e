"""Every key of a study, a part, a law: its unit, its default, what it may be, as stated in ``stated_keys.txt``.

Whoever leaves a key out relies on its default, and a file that is accepted today has to be accepted tomorrow. A change
that is meant is stated with ``python -m tests.schema.test_stated_keys``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from docs.site.reference_pages import parts

from wucht.schema import keys_of
from wucht.studies.registry import studies

STATED = Path(__file__).with_name("stated_keys.txt")


def stated_keys() -> Iterator[str]:
    """A line a key of what wucht itself has, not of parts that other packages or tests add."""
    tables = {f"studies/{kind}": study.study for kind, study in studies().items()}
    tables |= {place: cls for place, (_, cls, _) in parts()}
    for place, cls in sorted(tables.items()):
        if not cls.__module__.startswith("wucht."):
            continue
        for key in keys_of(cls):
            default = "needed" if key.needed else json.dumps(key.default)
            yield " | ".join([f"{place} {key.name}", key.unit or "-", default, key.type, key.allowed]).rstrip(" |")


def test_keys_are_those_that_are_stated() -> None:
    assert list(stated_keys()) == STATED.read_text(encoding="utf-8").splitlines()


if __name__ == "__main__":
    STATED.write_text("\n".join(stated_keys()) + "\n", encoding="utf-8")
