"""The balancer to be recommended among several, and whether it or the motor sets the settling time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.analysis.time_constants import run_up_time
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, OUTCOMES, Outcome
from wucht.machines.changes import last_change
from wucht.machines.machine import Machine

BALANCED_SHARE = 0.5  # of the runs: a candidate balances if more of them end compensated, as then the median run does
MOTOR_SHARE = 0.8  # of the median settling time: a motor that needs at least as long without vibration sets it
_COMPENSATED_INDEX, _OPEN_INDICES = OUTCOMES.index(Outcome.COMPENSATED), [OUTCOMES.index(o) for o in OPEN_OUTCOMES]


@dataclass(frozen=True)
class BalancerMerit:
    """What counts for a recommendation: number of bodies, median settling time (nan if unknown), the shares of the runs that
    do not end compensated for certain and at most, whether the candidate is confirmed by a check, and the standard error of
    the settling time."""

    bodies: int
    settling_time: float
    failing_share: float
    most_failing: float
    is_confirmed: bool
    error: float = 0.0

    @classmethod
    def of(
        cls, bodies: int, settling_time: float, outcomes: np.ndarray, is_confirmed: bool, error: float = 0.0
    ) -> BalancerMerit:
        """Return the merit of a candidate. outcomes: the share of its runs with each of ``OUTCOMES`` (o,)."""
        most = 1 - float(outcomes[_COMPENSATED_INDEX])
        certain = max(most - float(outcomes[_OPEN_INDICES].sum()), 0.0)
        return cls(bodies, settling_time, certain, most, is_confirmed, error)

    @property
    def balances(self) -> bool:
        """True if more than half of the runs end compensated."""
        return 1 - self.most_failing > BALANCED_SHARE

    @property
    def order(self) -> tuple[bool, float, float, int]:
        """Confirmed ones first, then those with the fewest failing runs, the shortest settling time, the fewest bodies."""
        return not self.is_confirmed, self.most_failing, self.settling_time, self.bodies

    def is_better_than(self, merit: BalancerMerit) -> bool:
        """True if fewer runs fail or, where as many do, the settling time is shorter by more than a standard error."""
        if not (self.balances and np.isfinite(self.settling_time)):
            return False
        if self.most_failing != merit.most_failing:
            return self.most_failing < merit.most_failing
        return bool(merit.settling_time - self.settling_time > np.hypot(self.error, merit.error))


def recommended_index(merits: Sequence[BalancerMerit]) -> int | None:
    """Return the index of the candidate to be recommended, None where none of them balances."""
    balancing = [k for k, merit in enumerate(merits) if merit.balances and np.isfinite(merit.settling_time)]
    return min(balancing, key=lambda k: merits[k].order, default=None)


def motor_time(machine: Machine, start: Mapping[str, Any]) -> float:
    """Return the time that the main rotor takes from a start to within 0.5 % of its free speed, without vibration.

    It is at least that of the last change by a schedule; 0 where the speed is prescribed from the beginning.
    """
    changes, rotor = last_change(machine), machine.rotor
    if rotor.coordinate.prescribed_velocity is not None:
        return changes
    speed = float(initial_state(machine, start)[machine.row(rotor.coordinate.velocity)])
    return max(changes, run_up_time(machine.at(changes), speed))


def motor_sets(time: float, settling_time: float | None) -> bool:
    """True if a motor that takes this time sets a settling time."""
    return settling_time is not None and bool(time > 0) and time >= MOTOR_SHARE * settling_time
