"""wucht: machines in which rotation and vibration act on each other.

The floors of the house, from the ground up (each knows only those before it):

``quantities``, ``system``, ``results``, ``numerics``, ``mechanics``, ``machines``, ``files``, ``analysis``,
``studies``, ``plots``, ``cli``.

>>> import wucht
>>> machine = wucht.load_machine("drozdetskaya-2020/r1")
>>> result = wucht.run(wucht.RunUp(until=20.0, start={"p1": 0.3, "p2": -0.5}), machine)
>>> result.attrs["outcome"]
'captured-modulated'
"""

from __future__ import annotations

from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wucht.files.catalogue import load_machine as load_machine
    from wucht.machines import parts as parts
    from wucht.machines.machine import Machine as Machine
    from wucht.studies.run_up.spec import RunUp as RunUp
    from wucht.studies.runner import run as run

__version__ = "0.1.0"

# SymPy, heyoka and xarray take seconds to import: they are loaded when a name is first used, not with the package.
_LAZY = {
    "Machine": "wucht.machines.machine:Machine",
    "RunUp": "wucht.studies.run_up.spec:RunUp",
    "load_machine": "wucht.files.catalogue:load_machine",
    "parts": "wucht.machines.parts",
    "run": "wucht.studies.runner:run",
}

__all__ = ["Machine", "RunUp", "__version__", "load_machine", "parts", "run"]


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'wucht' has no attribute {name!r}")
    return resolve_name(_LAZY[name])


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY})
