"""Going on with an interrupted study: only the result of the same question is taken up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.results.store import to_json
from wucht.studies.attributes import structure

if TYPE_CHECKING:
    import xarray as xr


def fingerprint(machine: Machine, asked: Sequence[Any]) -> str:
    """What a result depends on: the machine, its values, and what was asked."""
    return to_json([structure(machine), machine.values, list(asked)], indent=None)


def whole_fingerprint(machine: Machine, question: Any) -> str:
    """The same where all of the question counts."""
    return fingerprint(machine, [asdict(question)])


def check_same(earlier: xr.Dataset, asked: str, what: str) -> None:
    """Raises ``InputError`` where an earlier result has another fingerprint. what: in which it may differ, in words."""
    if earlier.attrs.get("asked") != asked:
        raise InputError("--resume", None, f"the result in the output folder is of another {what}")
