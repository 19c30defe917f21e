"""wucht: machines in which rotation and vibration act on each other.

A ``Machine`` from a file or from ``parts``, a question, an answer:

>>> import wucht
>>> machine = wucht.load_machine("drozdetskaya-2020/r1")
>>> result = wucht.run(wucht.RunUp(until=20.0, start={"p1": 0.3, "p2": -0.5}), machine)
>>> result.wucht.summary["outcome"]
'captured-modulated'

Questions: ``RunUp``, ``CoastDown``, ``StartStop``, ``DriveFailure``, ``Sweep``, ``Response``, ``TorqueBalance``,
``SpeedCurve``, ``SynchronousStates``, ``Entrainment``, ``Approximation``, ``PhasePortrait``, ``OrbitBranch``,
``StabilityMap``, ``Basin``, ``CaptureProbability``, ``OptimiseBalancer``, ``Activation``, ``LoadSpectrum`` (also of
``Records``), ``FailureDetection``, ``ExciterDesign``, ``VoltageDip``; of a ``CamDrive``: ``CamLaw``, ``CamContour``,
``CamCorrection``, ``CamPrediction``. Several side by side: ``compare`` (``Comparison``), ``grid``. Results: ``run``,
``run_file``, ``load``, ``draw`` (for a page, ``PRINT``, or a column, ``JOURNAL``; ``panel_names``), ``report``,
``write_report`` (one file to send), ``export``, and ``result.wucht``. In a notebook, a machine that moves: ``live``. Other
ordinary differential equations:
``UserSystem`` (``load_equations``), ``System``, ``compile_system``, ``integrate``, ``periodic_orbit``; any System averaged:
``averaged``, ``strongly_damped``, ``separated``. Errors: ``WuchtError``, which is ``InputError`` or ``RunError``.

The layers of the package, each of which knows only those before it: ``errors``, ``schema``, ``piecewise``, ``function_trace``,
``function_call``, ``system``, ``results``, ``numerics``, ``fatigue``, ``mechanics``, ``machines``, ``files``, ``analysis``,
``measurements``, ``cams``, ``dynamics``, ``plots``, ``studies``, ``reports``, ``web``, ``extending``, ``cli``.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import lazy_loader

from wucht.earlier_names import provide_earlier_names

__version__ = "0.2.0"

# SymPy and xarray take seconds to import: a name of __init__.pyi is loaded when it is first used.
_first_used, _, _names = lazy_loader.attach_stub(__name__, __file__)

__all__ = ["__version__", *_names]  # noqa: PLE0604


def __getattr__(name: str) -> Any:
    if name not in _names:
        raise AttributeError(f"module 'wucht' has no attribute {name!r}")
    if name == "parts":  # a package; lazy_loader knows names of modules alone
        return import_module("wucht.machines.parts")
    return _first_used(name)


provide_earlier_names(__name__)


def __dir__() -> list[str]:
    return [*__all__]
