# The names of the package: for type checkers, and for lazy_loader.
from .compiled_system import DEFAULT_TOLERANCE as DEFAULT_TOLERANCE
from .compiled_system import CompiledSystem as CompiledSystem
from .compiled_system import System as System
from .compiled_system import compile_system as compile_system
from .events import Event as Event
from .events import Hit as Hit
from .integration import integrate as integrate
from .program import TIME as TIME
from .program import Evaluator as Evaluator
from .trajectory import Trajectory as Trajectory

__all__: list[str]
