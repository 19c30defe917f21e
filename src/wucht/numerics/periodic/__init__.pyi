# The names of the package: for type checkers, and for lazy_loader.
from .branch_ends import BranchEnd as BranchEnd
from .branch_ends import branch_end as branch_end
from .connection import Connection as Connection
from .connection_starts import connection_from_excursion as connection_from_excursion
from .cycle import Cycle as Cycle
from .cycle_curves import CurveCycle as CurveCycle
from .cycle_curves import CycleCurve as CycleCurve
from .cycle_starts import crossing_branch as crossing_branch
from .cycle_starts import cycle_at as cycle_at
from .cycle_starts import cycle_at_hopf as cycle_at_hopf
from .cycle_starts import cycle_near as cycle_near
from .cycle_starts import cycles_with as cycles_with
from .cycle_starts import doubled_branch as doubled_branch
from .cycles import BoundaryValueProblem as BoundaryValueProblem
from .cycles import Cycles as Cycles
from .cycles import Solutions as Solutions
from .cycles import System as System
from .cycles import end_value as end_value
from .cycles import start_value as start_value
from .periods import with_forcing_phase as with_forcing_phase
from .saddle_connections import Connections as Connections

__all__: list[str]
