"""The papers' printed equations against their derivation, one check each: what ``docs/errata.md`` is written from.

``python -m tests.validation.errata`` in the project's folder writes the page again.
"""

from __future__ import annotations

from . import (
    checks_balancer,
    checks_balls,
    checks_cams,
    checks_coast_down,
    checks_foundations,
    checks_rollers,
    checks_separation,
    checks_sommerfeld,
    checks_steady,
    checks_synchronous,
    checks_tables,
)
from .check import Check, is_zero
from .page import page

MODULES = (
    checks_foundations,
    checks_sommerfeld,
    checks_balancer,
    checks_steady,
    checks_tables,
    checks_rollers,
    checks_synchronous,
    checks_separation,
    checks_balls,
    checks_coast_down,
    checks_cams,
)
CHECKS: tuple[Check, ...] = tuple(value for module in MODULES for value in vars(module).values() if isinstance(value, Check))

__all__ = ["CHECKS", "Check", "is_zero", "page"]
