"""wucht: machines in which rotation and vibration act on each other.

A ``Machine`` from a file or from ``parts``, a question, an answer:

>>> import wucht
>>> machine = wucht.load_machine("drozdetskaya-2020/r1")
>>> result = wucht.run(wucht.RunUp(until=20.0, start={"p1": 0.3, "p2": -0.5}), machine)
>>> result.wucht.summary["outcome"]
'captured-modulated'

Questions: ``RunUp``, ``CoastDown``, ``Sweep``, ``Response``, ``TorqueBalance``, ``SpeedCurve``, ``SynchronousStates``,
``Entrainment``, ``Approximation``, ``PhasePortrait``, ``OrbitBranch``, ``StabilityMap``, ``Basin``,
``CaptureProbability``, ``OptimiseBalancer``, ``Activation``, ``LoadSpectrum`` (also of ``Records``), ``FailureDetection``,
``ExciterDesign``; of a ``CamDrive``: ``CamLaw``, ``CamContour``, ``CamCorrection``, ``CamPrediction``.
Several side by side: ``compare`` (``Comparison``). Results: ``run``, ``run_file``, ``load``, ``draw`` (for a page,
``PRINT``, or a column, ``JOURNAL``), ``report``, ``export``, and ``result.wucht``. Any other ordinary differential equation:
``OwnEquations`` (``load_equations``), ``System``, ``compile_system``, ``integrate``, ``periodic_orbit``; any System averaged:
``averaged``, ``strongly_damped``, ``separated``.

The floors of the house, each of which knows only those before it: ``errors``, ``quantities``, ``piecewise``, ``system``,
``checking``, ``fields``, ``keys``, ``results``, ``numerics``, ``fatigue``, ``mechanics``, ``machines``, ``files``,
``analysis``, ``measurements``, ``cams``, ``studies``, ``cli``.
"""

from __future__ import annotations

from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wucht.cams.drive import CamDrive as CamDrive
    from wucht.files.catalogue import load_equations as load_equations
    from wucht.files.catalogue import load_machine as load_machine
    from wucht.files.own_equations import OwnEquations as OwnEquations
    from wucht.machines import parts as parts
    from wucht.machines.machine import Machine as Machine
    from wucht.mechanics.averaging import averaged as averaged
    from wucht.mechanics.separation import separated as separated
    from wucht.mechanics.strong_damping import strongly_damped as strongly_damped
    from wucht.numerics.flow.compiled import compile_system as compile_system
    from wucht.numerics.flow.integrate import integrate as integrate
    from wucht.numerics.orbits import periodic_orbit as periodic_orbit
    from wucht.results.page import JOURNAL as JOURNAL
    from wucht.results.page import PRINT as PRINT
    from wucht.studies.activation.spec import Activation as Activation
    from wucht.studies.approximation.spec import Approximation as Approximation
    from wucht.studies.basin.spec import Basin as Basin
    from wucht.studies.cam_contour.spec import CamContour as CamContour
    from wucht.studies.cam_correction.spec import CamCorrection as CamCorrection
    from wucht.studies.cam_law.spec import CamLaw as CamLaw
    from wucht.studies.cam_prediction.spec import CamPrediction as CamPrediction
    from wucht.studies.capture_probability.spec import CaptureProbability as CaptureProbability
    from wucht.studies.coast_down.spec import CoastDown as CoastDown
    from wucht.studies.comparison.spec import Comparison as Comparison
    from wucht.studies.entrainment.spec import Entrainment as Entrainment
    from wucht.studies.exciter_design.spec import ExciterDesign as ExciterDesign
    from wucht.studies.failure_detection.spec import FailureDetection as FailureDetection
    from wucht.studies.load_spectrum.machine_or_records import Records as Records
    from wucht.studies.load_spectrum.spec import LoadSpectrum as LoadSpectrum
    from wucht.studies.optimise_balancer.spec import OptimiseBalancer as OptimiseBalancer
    from wucht.studies.orbit_branch.spec import OrbitBranch as OrbitBranch
    from wucht.studies.phase_portrait.spec import PhasePortrait as PhasePortrait
    from wucht.studies.response.spec import Response as Response
    from wucht.studies.run_up.spec import RunUp as RunUp
    from wucht.studies.runner import draw as draw
    from wucht.studies.runner import export as export
    from wucht.studies.runner import load as load
    from wucht.studies.runner import report as report
    from wucht.studies.runner import run as run
    from wucht.studies.speed_curve.spec import SpeedCurve as SpeedCurve
    from wucht.studies.stability_map.spec import StabilityMap as StabilityMap
    from wucht.studies.study_file import compare as compare
    from wucht.studies.study_file import run_file as run_file
    from wucht.studies.sweep.spec import Sweep as Sweep
    from wucht.studies.synchronous_states.spec import SynchronousStates as SynchronousStates
    from wucht.studies.torque_balance.spec import TorqueBalance as TorqueBalance
    from wucht.system import System as System

__version__ = "0.1.0"

# SymPy, heyoka and xarray take seconds to import: they are loaded when a name is first used, not with the package.
_LAZY = {
    "Activation": "wucht.studies.activation.spec:Activation",
    "Approximation": "wucht.studies.approximation.spec:Approximation",
    "Basin": "wucht.studies.basin.spec:Basin",
    "CamContour": "wucht.studies.cam_contour.spec:CamContour",
    "CamCorrection": "wucht.studies.cam_correction.spec:CamCorrection",
    "CamDrive": "wucht.cams.drive:CamDrive",
    "CamLaw": "wucht.studies.cam_law.spec:CamLaw",
    "CamPrediction": "wucht.studies.cam_prediction.spec:CamPrediction",
    "CaptureProbability": "wucht.studies.capture_probability.spec:CaptureProbability",
    "CoastDown": "wucht.studies.coast_down.spec:CoastDown",
    "Comparison": "wucht.studies.comparison.spec:Comparison",
    "Entrainment": "wucht.studies.entrainment.spec:Entrainment",
    "ExciterDesign": "wucht.studies.exciter_design.spec:ExciterDesign",
    "FailureDetection": "wucht.studies.failure_detection.spec:FailureDetection",
    "LoadSpectrum": "wucht.studies.load_spectrum.spec:LoadSpectrum",
    "Machine": "wucht.machines.machine:Machine",
    "PhasePortrait": "wucht.studies.phase_portrait.spec:PhasePortrait",
    "Response": "wucht.studies.response.spec:Response",
    "OptimiseBalancer": "wucht.studies.optimise_balancer.spec:OptimiseBalancer",
    "OrbitBranch": "wucht.studies.orbit_branch.spec:OrbitBranch",
    "OwnEquations": "wucht.files.own_equations:OwnEquations",
    "Records": "wucht.studies.load_spectrum.machine_or_records:Records",
    "RunUp": "wucht.studies.run_up.spec:RunUp",
    "Sweep": "wucht.studies.sweep.spec:Sweep",
    "SpeedCurve": "wucht.studies.speed_curve.spec:SpeedCurve",
    "StabilityMap": "wucht.studies.stability_map.spec:StabilityMap",
    "SynchronousStates": "wucht.studies.synchronous_states.spec:SynchronousStates",
    "System": "wucht.system:System",
    "TorqueBalance": "wucht.studies.torque_balance.spec:TorqueBalance",
    "averaged": "wucht.mechanics.averaging:averaged",
    "compile_system": "wucht.numerics.flow.compiled:compile_system",
    "draw": "wucht.studies.runner:draw",
    "JOURNAL": "wucht.results.page:JOURNAL",
    "PRINT": "wucht.results.page:PRINT",
    "export": "wucht.studies.runner:export",
    "integrate": "wucht.numerics.flow.integrate:integrate",
    "load": "wucht.studies.runner:load",
    "load_equations": "wucht.files.catalogue:load_equations",
    "load_machine": "wucht.files.catalogue:load_machine",
    "parts": "wucht.machines.parts",
    "periodic_orbit": "wucht.numerics.orbits:periodic_orbit",
    "report": "wucht.studies.runner:report",
    "run": "wucht.studies.runner:run",
    "separated": "wucht.mechanics.separation:separated",
    "strongly_damped": "wucht.mechanics.strong_damping:strongly_damped",
    "compare": "wucht.studies.study_file:compare",
    "run_file": "wucht.studies.study_file:run_file",
}

__all__ = ["__version__", *_LAZY]  # noqa: PLE0604


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'wucht' has no attribute {name!r}")
    return resolve_name(_LAZY[name])


def __dir__() -> list[str]:
    return [*__all__]
