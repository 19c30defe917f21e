# The names of the package: for type checkers, and for lazy_loader.
from .curve import Curve as Curve
from .curve import Steps as Steps
from .curve import Walk as Walk
from .deflation import disconnected_branches as disconnected_branches
from .deflation import equilibria_at as equilibria_at
from .deflation import random_starts as random_starts
from .equations import CurvePoint as CurvePoint
from .equations import EquilibriumEquations as EquilibriumEquations
from .equations import FunctionProblem as FunctionProblem
from .equations import System as System
from .equilibria import Branch as Branch
from .equilibria import Equilibrium as Equilibrium
from .equilibria import EquilibriumContinuation as EquilibriumContinuation
from .fold_curves import Fold as Fold
from .fold_curves import Folds as Folds
from .hopf_curves import HopfPoint as HopfPoint
from .hopf_curves import HopfPoints as HopfPoints
from .two_parameters import HopfForm as HopfForm
from .two_parameters import SpecialCurve as SpecialCurve
from .two_parameters import hopf_form as hopf_form

__all__: list[str]
