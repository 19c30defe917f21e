"""From a slow motion back to the full one: the near-identity transformation 002 (3.2), 001 (14), (21).

theta_i = theta + alpha_i + Re[P_i exp(2 i theta)], q = Re[z exp(i theta)]: the fast parts 001 (26), (41), (54), (61).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.averaged import SlowMachine
from wucht.analysis.static import static_position
from wucht.machines.tree import Tree
from wucht.numerics.flow.program import Evaluator

_STEP = 1e-4  # rad: small against what a slow motion needs to change, large against rounding


@dataclass(frozen=True)
class FullMotion:
    """The full motion that belongs to states of the slow equations."""

    slow: SlowMachine

    @cached_property
    def _outputs(self) -> Evaluator:
        s = self.slow.system
        return Evaluator.of_outputs(s)

    @cached_property
    def _fluctuation(self) -> Evaluator:
        s = self.slow.fast
        return Evaluator.of_outputs(s)

    @cached_property
    def _rates(self) -> Evaluator:
        s = self.slow.system
        return Evaluator.of_rates(s)

    def __call__(self, time: np.ndarray, states: np.ndarray, rotor_angle: np.ndarray, speed: float | None = None) -> np.ndarray:
        """States (N_full, N) of ``machine.system`` for slow states (n, N) at times (N,).

        rotor_angle: (N,), the integral of the main rotor's speed in its own sense. speed: where it is held.
        """
        slow, machine = self.slow, self.slow.machine
        parameters = slow.values(speed)
        found = self._outputs(time, states, parameters) | self._fluctuation(time, states, parameters)
        theta = self._reference(time, states, rotor_angle)
        turning = np.exp(1j * theta)
        frequency = machine.shaking_frequency
        w = found[f"speed[{slow.equations.bodies.names[0]}]"] if frequency is None else frequency + 0 * theta
        values = dict[str, np.ndarray]()
        for b in machine.bodies:
            sense, (once, twice) = slow.senses[b.name], (self._complex(found, x, b.name) for x in ("gravity", "ripple"))
            fluctuation, rate = once * turning + twice * turning**2, 1j * w * (once * turning + 2 * twice * turning**2)
            values[b.coordinate.position.name] = sense * (theta + self._phase(states, b.name) + fluctuation.real)
            values[b.coordinate.velocity.name] = sense * (found[f"speed[{b.name}]"] + rate.real)
        z = np.array([self._complex(found, "amplitude", d) for d in machine.labels])
        changing = self._changing(time, states, parameters, w)
        for c, rest, amplitude, rate in zip(machine.carrier, static_position(machine), z, changing, strict=True):
            values[c.position.name] = rest + (amplitude * turning).real
            values[c.velocity.name] = ((1j * w * amplitude + rate) * turning).real
        return np.array([values[name] for name in machine.state_names])

    def _reference(self, time: np.ndarray, states: np.ndarray, rotor_angle: np.ndarray) -> np.ndarray:
        """theta: of the prescribed motion, else of the main rotor."""
        frequency = self.slow.machine.shaking_frequency
        return np.asarray(rotor_angle, float) if frequency is None else frequency * time

    def _phase(self, states: np.ndarray, name: str) -> np.ndarray:
        """alpha of a body to the reference (N,)."""
        found, s = np.zeros(states.shape[1]), self.slow
        for body in Tree(s.references).path(name):
            if f"{body}.phase" in s.system.state_names:
                found = found + states[s.system.state_names.index(f"{body}.phase")]
        return found

    def _changing(self, time: np.ndarray, states: np.ndarray, parameters: tuple[float, ...], w: np.ndarray) -> np.ndarray:
        """z' (m, N) along the slow motion, by central differences over a small part of a turn."""
        fastest = float(np.abs(w).max(initial=0.0))
        if not fastest:
            return np.zeros((len(self.slow.machine.labels), len(time)), complex)
        flow, step = self._rates(time, states, parameters), _STEP / fastest
        rate = np.array([flow[name] for name in self.slow.system.state_names])
        sides = []
        for sign in (1, -1):
            o = self._outputs(time + sign * step, states + sign * step * rate, parameters)
            sides.append(np.array([self._complex(o, "amplitude", d) for d in self.slow.machine.labels]))
        found: np.ndarray = (sides[0] - sides[1]) / (2 * step)
        return found

    def _complex(self, outputs: Mapping[str, np.ndarray], what: str, name: str) -> np.ndarray:
        found: np.ndarray = outputs[f"{what}.re[{name}]"] + 1j * outputs[f"{what}.im[{name}]"]
        resting = outputs[f"speed[{self.slow.equations.bodies.names[0]}]"] == 0  # nothing is fast then, and 0/0 not a number
        return np.where(resting, 0.0, found)
