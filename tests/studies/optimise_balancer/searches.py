"""Searches of a few seconds that go each another way. Their words are in ``tests/stated``."""

from __future__ import annotations

from functools import cache
from typing import Any

import xarray as xr
from test_known_optima import Balancer

from wucht import Machine, OptimiseBalancer, load_machine, report, run

SMALL: dict[str, Any] = {"samples": 4, "population": 4, "evaluations": 8, "points": 3, "damping_curve": False}
HELD, R1 = Balancer(), load_machine("drozdetskaya-2020/r1")
DAMPINGS = [0.1 * HELD.scale, 5 * HELD.scale]
SEARCHES: dict[str, tuple[dict[str, Any], Machine]] = {
    "held": (
        {"vary": {"damping": DAMPINGS}, "objectives": ["settling-time", "residual"], "damping_curve": True},
        HELD.machine(DAMPINGS[0]),
    ),
    "by mass": ({"vary": {"mass": [0.03, 0.06]}, "damping_curve": True}, HELD.machine(DAMPINGS[0])),
    "kept": ({"vary": {"damping": [0.02, 0.5]}, "until": 6.0}, R1),
    "averaged": ({"vary": {"damping": [0.02, 0.5]}, "model": "slow"}, R1),
    "too short": ({"vary": {"damping": [0.02, 0.5]}, "objectives": ["settling-time"], "until": 0.5}, R1),
}


@cache
def searched(name: str) -> xr.Dataset:
    """The result of a search, which is not to be changed."""
    keys, machine = SEARCHES[name]
    return run(OptimiseBalancer(**SMALL | keys), machine)


def told(result: xr.Dataset) -> dict[str, str]:
    """The lines of the report by their headings; lines below one without a heading are joined to it."""
    lines = dict[str, str]()
    for line in report(result)[2:]:
        heading = line[2:15].strip()
        last = heading or list(lines)[-1]
        lines[last] = line[15:] if heading else f"{lines[last]}\n{line[15:]}"
    return lines
