"""Studies of other packages: one that cannot be loaded is a line, and stands in no other's way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from wucht.errors import WuchtError
from wucht.studies import registry
from wucht.studies.registry import Study, studies


def test_a_study_that_cannot_be_loaded_is_a_line(wucht: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    broken = Study("broken", "no_such_package.study")
    known = studies() | {"broken": broken}
    monkeypatch.setattr(registry, "_installed", lambda: known)
    listed = wucht("list")
    assert listed.code == 0
    (line,) = [one for one in listed.out.splitlines() if "no_such_package" in one]
    assert line.split()[0] == "broken" and "cannot be loaded: No module named 'no_such_package'" in line
    assert "run-up" in listed.out and "catalogue:" in listed.out
    with pytest.raises(WuchtError, match="cannot be loaded"):
        _ = broken.spec
