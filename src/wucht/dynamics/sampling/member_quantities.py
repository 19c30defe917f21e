"""What is observed of many members: speed and unbalance of the main rotor, the bodies about it, the distance of its axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.operation import axis_at_rest
from wucht.numerics.flow.compiled_batch import Quantities
from wucht.system import System


@dataclass(frozen=True)
class MemberQuantities:
    """Equations of members, and the quantities that are observed of them.

    Attributes
    ----------
    system : System
        The integrated one, with further parameters: numbers of the machine that are no parameters of its equations.
    expressions : Quantities
        Sampled: the speed of the main rotor, the phases of the bodies about it, as they turn, the share of the rotor's
        unbalance that is left, then, if requested, the states that are not among these. Largest: the square of the distance of
        the rotor's axis from its rest position.
    parameter_values : ndarray, (V, p)
        Of the system, for each of the machines that differ.
    body_count : int
        b, of the bodies about the main rotor.
    state_columns : tuple of int
        Which of the sampled quantities are the states, where these are requested.
    """

    system: System
    expressions: Quantities
    parameter_values: np.ndarray
    body_count: int
    state_columns: tuple[int, ...] = ()

    @classmethod
    def of(
        cls,
        system: System,
        parameters: np.ndarray,
        motion: Quantities,
        weights: np.ndarray,
        extra_parameters: Sequence[tuple[sp.Symbol, np.ndarray]] = (),
        with_states: bool = False,
    ) -> MemberQuantities:
        """Observe a motion.

        Parameters
        ----------
        system : System
            The integrated one.
        parameters : ndarray, (V, p)
            Values of its parameters, for each variant.
        motion : Quantities
            Sampled: the speed of the main rotor, the phases of the bodies about it, as they turn. Largest: as above.
        weights : ndarray of complex, (V, 1 + b)
            Unbalances of the rotor and of the bodies about it, as shares of the rotor's.
        extra_parameters : sequence of (sympy.Symbol, ndarray (V,)), optional
            Symbols of the motion that are no parameters of the system, and their values.
        with_states : bool, optional
            True if states are sampled, too.
        """
        phases = motion.values[1:]
        residual, parts = _residual_unbalance(phases)
        additions = [
            *extra_parameters,
            *((symbol, column) for symbol, column in zip(parts, weights.view(float).T, strict=True)),
        ]
        states = system.states if with_states else ()
        rotor_quantities = (*motion.values, residual)
        values = (*rotor_quantities, *(state for state in states if state not in rotor_quantities))
        expressions, columns = Quantities(values, motion.peaks), tuple(map(values.index, states))
        whole_system = replace(system, parameters=(*system.parameters, *(symbol for symbol, _ in additions)))
        parameter_columns = [parameters, *(np.asarray(column, float)[:, None] for _, column in additions)]
        return cls(whole_system, expressions, np.concatenate(parameter_columns, axis=1), len(phases), columns)

    def speed(self, samples: np.ndarray) -> np.ndarray:
        """Return the speed (K, M) from samples (K, v, M) of quantities."""
        return samples[:, 0]

    def phases(self, samples: np.ndarray) -> np.ndarray:
        """Return the phases (b, K, M) from samples (K, v, M) of quantities."""
        return np.moveaxis(samples[:, 1 : 1 + self.body_count], 1, 0)

    def residual(self, samples: np.ndarray) -> np.ndarray:
        """Return the share of the unbalance that is left (K, M), from samples (K, v, M) of quantities."""
        return samples[:, 1 + self.body_count]

    def points(self, samples: np.ndarray) -> np.ndarray:
        """Return the states as points (K, M, d), with cosine and sine of each angle, from samples (K, v, M) of quantities."""
        states, columns = np.take(samples, self.state_columns, axis=1), list[np.ndarray]()
        for i, state in enumerate(self.system.states):
            columns += [np.cos(states[:, i]), np.sin(states[:, i])] if state in self.system.angles else [states[:, i]]
        return np.stack(columns, axis=-1)


def _residual_unbalance(phases: Sequence[sp.Expr]) -> tuple[sp.Expr, list[sp.Symbol]]:
    """Return the magnitude of the sum of unbalances, all but the first of which are at phases, and symbols of their parts."""
    parts = [sp.Symbol(f"unbalance.{part}{i}", real=True) for i in range(1 + len(phases)) for part in ("re", "im")]
    real, imaginary = parts[0], parts[1]
    for phase, re, im in zip(phases, parts[2::2], parts[3::2], strict=True):
        real += re * sp.cos(phase) - im * sp.sin(phase)
        imaginary += re * sp.sin(phase) + im * sp.cos(phase)
    return sp.sqrt(real**2 + imaginary**2), parts


def full_motion(
    machine: Machine, frame: dict[sp.Symbol, sp.Expr], machines: Sequence[Machine]
) -> tuple[Quantities, list[tuple[sp.Symbol, np.ndarray]]]:
    """Return the motion of a machine's full equations, and the symbols in it that are no parameters, with their values (V,).

    The motion is that of ``MemberQuantities.of``.
    frame: the symbols of the integrated equations by those of the machine's, where they differ. machines: those that differ.
    """
    rotor, extra_parameters = machine.rotor.coordinate, list[tuple[sp.Symbol, np.ndarray]]()
    speed = rotor.velocity
    if rotor.prescribed_velocity is not None and machine.schedules:
        speed = sp.sympify(rotor.prescribed_velocity).xreplace({s.symbol: s.expression for s in machine.schedules})
    elif rotor.prescribed_velocity is not None:
        speed = sp.Symbol("prescribed.speed", real=True)
        extra_parameters.append((speed, np.array([m.prescribed_speed(rotor, 0.0)[0] for m in machines])))
    rests, square = [axis_at_rest(m) for m in machines], sp.S.Zero
    for name in machine.orbit:
        rest = sp.Symbol(f"rest.{name}", real=True)
        extra_parameters.append((rest, np.array([at_rest[name] for at_rest in rests])))
        square += (machine.system.explicit(machine.system.output(f"orbit.{name}").expression) - rest) ** 2
    bodies = machine.group(machine.rotor)[1:]
    phases = tuple((b.coordinate.position - rotor.position).xreplace(frame) for b in bodies)
    return Quantities((speed.xreplace(frame), *phases), (square.xreplace(frame),)), extra_parameters
