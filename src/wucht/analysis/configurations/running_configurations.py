"""The synchronous configurations in which the rotors of a machine can run, as their drives turn them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wucht.analysis.averaged_equations import averaged_equations_of, keeps_inertia
from wucht.analysis.configurations.averaged_stability import AveragedStability, Stability
from wucht.analysis.configurations.configuration import Configuration, ConfigurationDescriber
from wucht.analysis.configurations.search import CancelCheck, StateSearch, all_states
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import MOST_BODIES, driven_speeds, machine_at_speed
from wucht.numerics.angles import wrap_to_pi

FULL_UNDECIDED = Stability.without_verdict("the full equations are not evaluated")


@dataclass(frozen=True)
class RunningConfigurations:
    """All configurations in which the torques on each body balance, the slowest first, with the search for them."""

    torques: SteadyTorques
    configurations: tuple[Configuration, ...]
    search: StateSearch

    @classmethod
    def of(
        cls, machine: Machine, speeds: tuple[float, float] | None = None, watch: CancelCheck = None
    ) -> RunningConfigurations:
        """The configurations of a machine with its schedules finished and all bodies released.

        Parameters
        ----------
        machine : Machine
        speeds : (float, float), optional
            Lowest and highest speed of the search, in the main rotor's sense; by default those that the drives reach.
        watch : callable, optional
            Called often; an exception from it ends the search.

        Raises
        ------
        InputError
            Where there are no averaged equations, too many bodies, or no drive.
        """
        steady = machine_at_speed(machine, None)
        if len(steady.bodies) > MOST_BODIES:
            requirement = f"there must be at most {MOST_BODIES}, the main rotor included"
            raise InputError("machine.bodies", len(steady.bodies), requirement)
        slow = averaged_equations_of(steady, keeps_inertia(steady, None))
        torques, (low, high) = SteadyTorques.from_averaged_equations(slow), speeds or driven_speeds(steady)[0]
        if torques.fixed_speed is None and not high > 0:
            raise InputError("machine.drive", None, "nothing drives the machine", code="no-drive")
        search = all_states(torques, low, high, watch, prove=False)
        describer = ConfigurationDescriber(AveragedStability(torques, slow))
        configurations = (describer.describe(state, FULL_UNDECIDED) for state in search.states)
        return cls(torques, tuple(sorted(configurations, key=lambda c: abs(c.speed))), search)

    @property
    def stable(self) -> tuple[Configuration, ...]:
        """Those that are stable in the averaged equations, and possible."""
        return tuple(c for c in self.configurations if c.slow.stable is True and not c.overlapping)

    def nearest(self, phases: Mapping[str, float]) -> Configuration:
        """The stable configuration whose phases are nearest to given ones (rad, by body, as in ``Configuration.phases``).

        Raises ``ValueError`` where none is stable.
        """

        def distance(c: Configuration) -> float:
            return max(abs(float(wrap_to_pi(c.phases[name] - phase))) for name, phase in phases.items())

        return min(self.stable, key=distance)
