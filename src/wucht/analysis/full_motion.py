"""From a slow motion back to the full one: the near-identity transformation 002 (3.2), 001 (14), (21).

theta_i = theta + alpha_i + Re[P_i exp(2 i theta)], q = Re[z exp(i theta)]: the fast parts 001 (26), (41), (54), (61).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.averaged import AveragedMachine
from wucht.analysis.static import static_position
from wucht.machines.operation import natural_frequencies
from wucht.machines.tree import Tree
from wucht.numerics.flow.program import Evaluator

_STEP = 1e-4  # rad of the fastest free vibration: small against what a slow motion needs to change, large against rounding


@dataclass(frozen=True)
class FullMotion:
    """The full motion that belongs to states of the averaged equations."""

    slow: AveragedMachine

    def __call__(self, time: np.ndarray, states: np.ndarray, rotor_angle: np.ndarray, speed: float | None = None) -> np.ndarray:
        """States (N_full, N) of ``machine.system`` for slow states (n, N) at times (N,).

        rotor_angle: (N,), the integral of the main rotor's speed in its own sense. speed: where it is held.
        """
        slow, machine = self.slow, self.slow.machine
        parameters, frequency = slow.values(speed), machine.shaking_frequency
        outputs = self._steady(time, states, parameters)
        fluctuations = Evaluator.of_outputs(slow.fast)(time, states, parameters)
        # theta is the angle of the prescribed motion, else of the main rotor.
        theta = np.asarray(rotor_angle, float) if frequency is None else frequency * time
        turning, main = np.exp(1j * theta), outputs[f"speed[{slow.equations.bodies.names[0]}]"]
        w = main if frequency is None else frequency + 0 * theta
        values = dict[str, np.ndarray]()
        for b in machine.bodies:
            sense, (once, twice) = slow.senses[b.name], (_complex(fluctuations, x, b.name, main) for x in ("gravity", "ripple"))
            fluctuation, rate = once * turning + twice * turning**2, 1j * w * (once * turning + 2 * twice * turning**2)
            values[b.coordinate.position.name] = sense * (theta + self._phase(states, b.name) + fluctuation.real)
            values[b.coordinate.velocity.name] = sense * (outputs[f"speed[{b.name}]"] + rate.real)
        z, changing = self._amplitudes(outputs), self._changing(time, states, parameters, w)
        for c, rest, amplitude, rate in zip(machine.carrier, static_position(machine), z, changing, strict=True):
            values[c.position.name] = rest + (amplitude * turning).real
            values[c.velocity.name] = ((1j * w * amplitude + rate) * turning).real
        return np.array([values[name] for name in machine.state_names])

    @cached_property
    def _steady(self) -> Evaluator:
        """Speeds and amplitudes: nothing else of the averaged equations is needed."""
        system, bodies = self.slow.system, self.slow.equations.bodies.names
        names = [f"speed[{n}]" for n in bodies]
        names += [f"amplitude.{part}[{d}]" for d in self.slow.machine.labels for part in ("re", "im")]
        return Evaluator.of(system, [system.output(n).expression for n in names], names)

    def _phase(self, states: np.ndarray, name: str) -> np.ndarray:
        """alpha of a body to the reference (N,)."""
        names = self.slow.system.state_names
        phases = [f"{body}.phase" for body in Tree(self.slow.references).path(name)]
        return np.asarray(sum((states[names.index(p)] for p in phases if p in names), np.zeros(states.shape[1])))

    def _changing(self, time: np.ndarray, states: np.ndarray, parameters: tuple[float, ...], w: np.ndarray) -> np.ndarray:
        """z' (m, N) along the slow motion, by central differences over a small part of a turn."""
        # One step for all samples: what comes of one does not depend on the others.
        natural, system = natural_frequencies(self.slow.machine).values(), self.slow.system
        fastest = max((f for f in natural if f > 0), default=0.0) or float(np.abs(w).max(initial=0.0)) or 1.0
        rate, step = Evaluator.of_rates(system).array(time, states, parameters), _STEP / fastest
        after, before = (self._amplitudes(self._steady(time + h, states + h * rate, parameters)) for h in (step, -step))
        return np.where(w == 0, 0.0, (after - before) / (2 * step))

    def _amplitudes(self, outputs: Mapping[str, np.ndarray]) -> np.ndarray:
        """z (m, N)."""
        main = outputs[f"speed[{self.slow.equations.bodies.names[0]}]"]
        return np.array([_complex(outputs, "amplitude", d, main) for d in self.slow.machine.labels])


def _complex(outputs: Mapping[str, np.ndarray], what: str, name: str, main: np.ndarray) -> np.ndarray:
    """A complex output (N,). main: the main rotor's speed: at rest nothing is fast, and 0/0 not a number."""
    return np.where(main == 0, 0.0, outputs[f"{what}.re[{name}]"] + 1j * outputs[f"{what}.im[{name}]"])
