"""An independent witness: mechanisms described by the absolute positions of their masses, integrated by SciPy with NumPy.

It shares nothing with wucht: velocities come from positions by the chain rule, the mass matrix is solved in numbers.
"""

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

TIME = sp.Symbol("time", real=True)


class Mechanism:
    """Coordinates by name; masses at positions, bodies that turn, springs, dampers and torques are added one by one."""

    def __init__(self, *names):
        self.q = sp.symbols(names, real=True)
        self.v = sp.symbols([f"d{n}" for n in names], real=True)
        self.kinetic = self.potential = self.lost = sp.S.Zero
        self.forces = [sp.S.Zero] * len(names)

    def rate(self, expression):
        """The velocity of what has a position."""
        moving = sum((sp.diff(expression, q) * v for q, v in zip(self.q, self.v, strict=True)), sp.S.Zero)
        return moving + sp.diff(expression, TIME)

    def mass(self, m, position, gravity=0.0):
        self.kinetic += m * sum(self.rate(p) ** 2 for p in position) / 2
        self.potential += m * gravity * position[-1]

    def turning(self, inertia, angle):
        self.kinetic += inertia * self.rate(angle) ** 2 / 2

    def spring(self, stiffness, stretch):
        self.potential += stiffness * stretch**2 / 2

    def damper(self, damping, stretch):
        self.lost += damping * self.rate(stretch) ** 2 / 2

    def force(self, force, place):
        """A force on a place, or a torque on an angle."""
        for i, v in enumerate(self.v):
            self.forces[i] += force * sp.diff(self.rate(place), v)

    def residuals(self, accelerations):
        """d/dt dT/dv - dT/dq + dV/dq + dR/dv - F of every coordinate."""
        actual = []
        for i, (q, v) in enumerate(zip(self.q, self.v, strict=True)):
            momentum = sp.diff(self.kinetic, v)
            changing = self.rate(momentum)
            changing += sum(sp.diff(momentum, w) * a for w, a in zip(self.v, accelerations, strict=True))
            actual.append(changing - sp.diff(self.kinetic - self.potential, q) + sp.diff(self.lost, v) - self.forces[i])
        return actual

    def motion(self, positions, velocities, time):
        """Positions and velocities (2 n, N) at the times given. A step is accurate to 1e-13."""
        a = sp.symbols(f"a:{len(self.q)}", real=True)
        residuals = sp.Matrix(self.residuals(a))
        zero = dict.fromkeys(a, 0)
        arguments = (TIME, *self.q, *self.v)
        function = sp.lambdify(arguments, [residuals.jacobian(a), -residuals.xreplace(zero)], cse=True)
        n = len(self.q)

        def derivative(t, state):
            matrix, right = function(t, *state)
            return np.concatenate([state[n:], np.linalg.solve(matrix, right.ravel())])

        start = np.concatenate([positions, velocities]).astype(float)
        return solve_ivp(derivative, (time[0], time[-1]), start, "DOP853", time, rtol=1e-13, atol=1e-14).y


def along(angle):
    """The unit vector in a direction."""
    return sp.Matrix([sp.cos(angle), sp.sin(angle)])


GRID = np.linspace(0.0, 1.0, 101)


def moved(document, start=None, grid=GRID):
    """Every state, output and work of wucht's own run, by name."""
    machine = machine_from(document)
    flow = compile_system(machine.system)
    run = integrate(flow, initial_state(machine, start or {}), machine.values, grid)
    assert run.failure is None
    rows = dict(zip(machine.system.state_names, run.states, strict=True)) | dict(run.quadratures)
    return rows | flow.outputs(run.time, run.states, run.final_parameter_values)


def energy_gap(rows):
    """What the energy balance leaves open, relative."""
    gap = rows["supplied_work"] - rows["dissipated_work"] - rows["stored_energy"] + rows["stored_energy"][0]
    return np.abs(gap).max() / max(np.abs(rows["supplied_work"]).max(), np.abs(rows["stored_energy"]).max())


def close(actual, other, tolerance=1e-9):
    """Whether two signals agree, measured by the largest value of the second."""
    return np.abs(actual - other).max() <= tolerance * np.abs(other).max()
