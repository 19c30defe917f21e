"""The variables of the Dataset of a branch of orbits."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wucht.dynamics.branches.orbit_branches import PeriodicBranch
from wucht.dynamics.branches.orbit_diagram import OrbitFindings
from wucht.numerics.periodic.branch_ends import BranchEnd
from wucht.results.quantities import Quantity
from wucht.studies.motion_variables import join_arrays, steady_branch_quantities
from wucht.studies.orbit_branch.computation import Plan

_ANGLE = "angle of the main rotor"


def ordinate_name(plan: Plan) -> str:
    """Return the name of what is drawn: the main rotor's speed, or a state of user equations."""
    return plan.problem.labels.state or "speed"


def orbit_quantities(plan: Plan, branches: Sequence[PeriodicBranch]) -> list[Quantity]:
    """Return all orbits of all branches."""
    s, n = plan.problem.labels, len(plan.problem.system.states)
    values, periods, mean, low, high, least, largest = (
        join_arrays([b.whole_array(name) for b in branches])
        for name in ("values", "periods", "mean", "low", "high", "least", "largest")
    )
    logarithms = join_arrays([b.whole_array("logarithms") for b in branches], n - 1)
    is_trusted = join_arrays([b.whole_array("is_trusted") for b in branches]) > 0
    unstable, stable = (join_arrays([b.whole_array(name) for b in branches]) for name in ("unstable", "stable"))
    special = join_arrays([np.array([bool(kind) for kind in b.kinds]) for b in branches])
    numbers = np.repeat(np.arange(len(branches)), [len(b.kinds) for b in branches])
    rates = np.where(is_trusted, logarithms, complex(math.nan, math.nan)) / periods
    of_machine = [
        Quantity("period_phi", periods * np.abs(mean), f"period in the {_ANGLE}", "", "point"),
        Quantity("min_amplitude", least, "least amplitude of the axis", s.length, "point"),
        Quantity("max_amplitude", largest, "largest amplitude of the axis", s.length, "point"),
    ]
    return [
        Quantity("value", values, plan.along.full_name, plan.along.unit, "point"),
        Quantity("period", periods, "period", s.time, "point"),
        Quantity(f"min_{ordinate_name(plan)}", low, f"least {s.ordinate}", s.unit, "point"),
        Quantity(f"max_{ordinate_name(plan)}", high, f"largest {s.ordinate}", s.unit, "point"),
        Quantity(f"mean_{ordinate_name(plan)}", mean, f"mean {s.ordinate}", s.unit, "point"),
        *(of_machine if not s.of_equations else []),
        Quantity("unstable", unstable.astype(int), "number of growing disturbances", "", "point"),
        Quantity("stable", stable.astype(np.int8), "stable", "", "point"),
        Quantity("at_special", special.astype(np.int8), "a special point", "", "point"),
        Quantity("branch", numbers.astype(int), "branch", "", "point"),
        Quantity("exponent_re", rates.real, "real part of an exponent, by collocation", s.rate, "exponent point"),
        Quantity("exponent_im", rates.imag, "imaginary part of an exponent, by collocation", s.rate, "exponent point"),
    ]


def reported_quantities(plan: Plan, findings: OrbitFindings) -> list[Quantity]:
    """Return the reported orbits, with their course over a period."""
    s, n = plan.problem.labels, len(plan.problem.system.states)
    orbits = [one for _, one in findings.orbits]
    exponents, rate = join_arrays([o.exponents[:, None] for o in orbits], n - 1), s.rate
    shape = (len(orbits), len(orbits[0].ordinate) if orbits else 0)
    times = [o.shares * o.period for o in orbits]
    table = {name: np.array(rows, float).reshape(shape) for name, rows in (
        ("time", times), ("turned", [o.rotor_angle for o in orbits]), ("shown", [o.ordinate for o in orbits]),
        ("amplitude", [o.amplitude for o in orbits]),
    )}  # fmt: skip
    name = ordinate_name(plan)
    of_equations = [
        Quantity("state", plan.problem.system.state_names, "state", "", "state"),
        Quantity("turning", plan.problem.turning.astype(np.int8), "whether it is an angle", "", "state"),
        Quantity(
            "orbit_states", np.array([o.states for o in orbits], float).reshape(shape[0], n, shape[1]), "states", "",
            "orbit state place",
        ),
    ]  # fmt: skip
    of_machine = [
        Quantity("orbit_period_phi", [o.period_phi for o in orbits], f"period in the {_ANGLE}", "", "orbit"),
        Quantity("orbit_turned", table["turned"], _ANGLE, "rad" if s.time else "", "orbit place"),
        Quantity("orbit_amplitude", table["amplitude"], "amplitude of the axis", s.length, "orbit place"),
    ]
    return [
        Quantity("orbit_value", [o.value for o in orbits], plan.along.full_name, plan.along.unit, "orbit"),
        Quantity("orbit_period", [o.period for o in orbits], "period", s.time, "orbit"),
        Quantity(f"orbit_min_{name}", [o.low for o in orbits], f"least {s.ordinate}", s.unit, "orbit"),
        Quantity(f"orbit_max_{name}", [o.high for o in orbits], f"largest {s.ordinate}", s.unit, "orbit"),
        Quantity("orbit_branch", np.array([k for k, _ in findings.orbits], int), "branch", "", "orbit"),
        Quantity("orbit_kind", np.array([o.kind for o in orbits], "U16"), "kind of the special orbit", "", "orbit"),
        Quantity("orbit_exponent_re", np.asarray(exponents.real), "real part of an exponent", rate, "exponent orbit"),
        Quantity("orbit_exponent_im", np.asarray(exponents.imag), "imaginary part of an exponent", rate, "exponent orbit"),
        Quantity("orbit_time", table["time"], "time", s.time, "orbit place", coordinate=True),
        Quantity("orbit_state" if s.of_equations else "orbit_speed", table["shown"], s.ordinate, s.unit, "orbit place"),
        *(of_equations if s.of_equations else of_machine),
    ]  # fmt: skip


def end_quantities(plan: Plan, ends: Sequence[tuple[int, BranchEnd]]) -> list[Quantity]:
    """Return the ends of the branches."""
    s = plan.problem.labels
    laws = [(e.saddle_node, e.connection) for _, e in ends]
    residuals = [[math.nan if law is None else law.residual for law in pair] for pair in laws]
    observables = [
        plan.problem.observables(e.equilibrium[:, None], e.parameter)[:, 0] if len(e.equilibrium) else np.full(2, math.nan)
        for _, e in ends
    ]
    ordinates, residual = (np.array(rows, float).reshape(len(ends), 2) for rows in (observables, residuals))
    name = "end_state" if s.of_equations else "end_speed"
    amplitude = Quantity("end_amplitude", ordinates[:, 1], "amplitude of the equilibrium there", s.length, "end")
    return [
        Quantity("end_value", [e.parameter for _, e in ends], plan.along.full_name, plan.along.unit, "end"),
        Quantity("end_error", [e.error for _, e in ends], f"error of {plan.along.full_name}", plan.along.unit, "end"),
        Quantity("end_kind", np.array([e.kind for _, e in ends], "U24"), "kind of the end", "", "end"),
        Quantity("end_branch", np.array([k for k, _ in ends], int), "branch", "", "end"),
        Quantity(name, ordinates[:, 0], f"{s.ordinate} of the equilibrium there", s.unit, "end"),
        *([] if s.of_equations else [amplitude]),
        Quantity("end_residual", residual, "residual of a law of the period, relative", "", "end law"),
    ]  # fmt: skip


def steady_quantities(plan: Plan, findings: OrbitFindings) -> list[Quantity]:
    """Return the branches of steady states beside those of orbits."""
    s, steady = plan.problem.labels, findings.steady
    ordinates = [] if plan.case.steady is None else [plan.case.steady.steady_states.ordinates(b.unknowns) for b in steady]
    state = Quantity("steady_state", join_arrays([o.speed for o in ordinates]), s.ordinate, s.unit, "steady")
    return [
        *steady_branch_quantities("steady", "steady_", steady, ordinates, plan.along, s), *([state] if s.of_equations else []),
    ]  # fmt: skip
