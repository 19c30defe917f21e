# The names of the package: for type checkers, and for lazy_loader.
from .cams.drive import CamDrive as CamDrive
from .errors import InputError as InputError
from .errors import RunError as RunError
from .errors import WuchtError as WuchtError
from .files.catalogue import load_equations as load_equations
from .files.catalogue import load_machine as load_machine
from .files.user_system import UserSystem as UserSystem
from .machines import parts as parts
from .machines.machine import Machine as Machine
from .mechanics.averaging import averaged as averaged
from .mechanics.separation import separated as separated
from .mechanics.strong_damping import strongly_damped as strongly_damped
from .numerics.flow.compiled_system import compile_system as compile_system
from .numerics.flow.integration import integrate as integrate
from .numerics.orbits import periodic_orbit as periodic_orbit
from .plots.page import JOURNAL as JOURNAL
from .plots.page import PRINT as PRINT
from .reports.html_report import write_report as write_report
from .studies.activation.study import Activation as Activation
from .studies.approximation.study import Approximation as Approximation
from .studies.basin.study import Basin as Basin
from .studies.cam_contour.study import CamContour as CamContour
from .studies.cam_correction.study import CamCorrection as CamCorrection
from .studies.cam_law import CamLaw as CamLaw
from .studies.cam_prediction.study import CamPrediction as CamPrediction
from .studies.capture_probability.study import CaptureProbability as CaptureProbability
from .studies.coast_down import CoastDown as CoastDown
from .studies.comparison.grid import grid as grid
from .studies.comparison.study import Comparison as Comparison
from .studies.drive_failure import DriveFailure as DriveFailure
from .studies.entrainment.study import Entrainment as Entrainment
from .studies.exciter_design.study import ExciterDesign as ExciterDesign
from .studies.failure_detection.study import FailureDetection as FailureDetection
from .studies.load_spectrum.load_records import Records as Records
from .studies.load_spectrum.study import LoadSpectrum as LoadSpectrum
from .studies.optimise_balancer.study import OptimiseBalancer as OptimiseBalancer
from .studies.orbit_branch.study import OrbitBranch as OrbitBranch
from .studies.phase_portrait.study import PhasePortrait as PhasePortrait
from .studies.response.study import Response as Response
from .studies.run_up.study import RunUp as RunUp
from .studies.runner import draw as draw
from .studies.runner import export as export
from .studies.runner import load as load
from .studies.runner import report as report
from .studies.runner import run as run
from .studies.speed_curve.study import SpeedCurve as SpeedCurve
from .studies.stability_map.study import StabilityMap as StabilityMap
from .studies.start_stop import StartStop as StartStop
from .studies.study_file import compare as compare
from .studies.study_file import run_file as run_file
from .studies.sweep.study import Sweep as Sweep
from .studies.synchronous_states.study import SynchronousStates as SynchronousStates
from .studies.torque_balance import TorqueBalance as TorqueBalance
from .studies.voltage_dip.study import VoltageDip as VoltageDip
from .system import System as System
from .web.live_widget import live as live

OwnEquations = UserSystem  # the earlier name, deprecated

__version__: str
__all__: list[str]
