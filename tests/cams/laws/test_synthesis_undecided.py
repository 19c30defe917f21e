"""A motion law whose solver cannot decide whether there is one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from wucht.cams.laws import synthesis as module
from wucht.cams.laws.cone_programme import InfeasibleError
from wucht.errors import RunError


def undecided(patch: pytest.MonkeyPatch, widening: float) -> list[Any]:
    """Widened by so much there is a motion; as the restrictions are the solver gives up."""
    asked = list[Any]()

    def exchanged(count: int, restrictions: Any, weights: Any) -> Any:
        asked.append((count, restrictions, weights))
        if len(asked) == 1:
            raise RunError("undecided")
        return SimpleNamespace(widening=widening)

    patch.setattr(module, "_with_fewest_harmonics", lambda *_: None)
    patch.setattr(module, "_solve_by_exchange", exchanged)
    patch.setattr(module, "replace", lambda r, is_widened: SimpleNamespace(size=r.size, is_widened=is_widened))
    return asked


def restrictions(*widened: bool) -> Any:
    return [SimpleNamespace(size=float(k + 1), is_widened=w) for k, w in enumerate(widened)]


def test_what_has_a_motion_only_if_it_is_widened_is_contradictory(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = undecided(monkeypatch, 2.1 * module._VIOLATION)
    with pytest.raises(InfeasibleError):
        module.synthesise(5, restrictions(False, False, True))
    assert [(count, len(some), weights) for count, some, weights in asked] == [(5, 3, None), (5, 2, None)]
    assert all(r.is_widened for r in asked[1][1])


def test_what_hardly_needs_to_be_widened_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    undecided(monkeypatch, 1.9 * module._VIOLATION)
    with pytest.raises(RunError, match=r"^undecided$"):
        module.synthesise(5, restrictions(False, False, True))
    asked = undecided(monkeypatch, 1.0)
    with pytest.raises(RunError, match=r"^undecided$"):
        module.synthesise(5, restrictions(True))
    assert len(asked) == 1, "there is nothing to widen"
