"""wucht: machines in which rotation and vibration act on each other.

The floors of the house, from the ground up (each knows only those before it):

``quantities``, ``system``, ``results``, ``numerics``, ``mechanics``, ``machines``, ``studies``, ``plots``, ``cli``.

>>> import wucht
>>> machine = wucht.load_machine("drozdetskaya-2020/r1")
>>> result = wucht.run_up(machine, wucht.RunUp(until=20.0, start={"p1": 0.3, "p2": -0.5}))
>>> result.attrs["outcome"]
'captured-modulated'
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wucht.machines.catalogue import load_machine as load_machine
    from wucht.studies.run_up.study import RunUp as RunUp
    from wucht.studies.run_up.study import run_up as run_up

__version__ = "0.1.0"

# SymPy, heyoka and xarray take seconds to import: they are loaded when a name is first used, not with the package.
_LAZY = {
    "load_machine": "wucht.machines.catalogue",
    "RunUp": "wucht.studies.run_up",
    "run_up": "wucht.studies.run_up",
}

__all__ = ["RunUp", "__version__", "load_machine", "run_up"]


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'wucht' has no attribute {name!r}")
    return getattr(import_module(_LAZY[name]), name)
