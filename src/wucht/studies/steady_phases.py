"""A machine at a steady speed: its schedules done, its bodies in steady phases, its carrier in forced vibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.analysis.forced import Forced
from wucht.machines.machine import Machine
from wucht.machines.tracks import arranged
from wucht.studies.initial_state import angles_in, initial_state


@dataclass(frozen=True)
class SteadyPhases:
    """machine: with its schedules done. angles: absolute, of its bodies (n,), in rad. forced: the vibration they cause."""

    machine: Machine
    angles: np.ndarray
    forced: Forced

    @classmethod
    def of(cls, machine: Machine, start: Mapping[str, Any]) -> SteadyPhases:
        """The bodies at their start, as in ``initial_state``; its speeds and the carrier's start do not matter.

        Raises ``InputError`` where the start does not fit the machine, where bodies of a track overlap, and where the carrier
        is not linear.
        """
        steady = machine.at(machine.breakpoints[-1])
        by_name = angles_in(steady, initial_state(steady, start))
        arranged(steady, by_name)
        angles = np.array(list(by_name.values()))
        return cls(steady, angles, Forced.of(steady, angles))

    @property
    def warnings(self) -> list[str]:
        """What the steady vibration of a linear carrier leaves out, in sentences."""
        prescribed = "the prescribed motion of the carrier is left out: only what the unbalance causes is computed"
        sliders = "sliders are taken where their springs are free of force: their unbalance does not grow with the speed"
        switchable = "switchable pendulums are taken closed, at any speed: study.kind = 'activation' shows them open"
        inside = [x.name == x.about for x in self.machine.sliders]
        left_out = {prescribed: self.machine.shaken is not None, sliders: not all(inside), switchable: any(inside)}
        return [sentence for sentence, applies in left_out.items() if applies]
