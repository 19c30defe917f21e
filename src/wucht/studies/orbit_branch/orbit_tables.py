"""The variables of the Dataset of a branch of orbits."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wucht.dynamics.branches.orbit_branches import PeriodicBranch
from wucht.dynamics.branches.orbit_diagram import OrbitFindings
from wucht.numerics.periodic.branch_ends import BranchEnd
from wucht.results.conventions import Variable, variable
from wucht.studies.branch_variables import joined, of_steady_branches
from wucht.studies.orbit_branch.prepare import Plan

_ANGLE = "angle of the main rotor"


def rate_unit(plan: Plan) -> str:
    """Of exponents."""
    return f"1/{plan.problem.time}" if plan.problem.time else ""


def phi_of(plan: Plan, periods: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Periods in the main rotor's angle (N,); not numbers of a system."""
    return np.asarray(periods * np.abs(mean) if plan.problem.rotor else np.full(len(periods), math.nan))


def of_orbits(plan: Plan, branches: Sequence[PeriodicBranch]) -> dict[str, Variable]:
    """All orbits of all branches."""
    s, n = plan.problem, len(plan.problem.system.states)
    values, periods, mean, low, high, least, largest = (
        joined([b.joined(name) for b in branches]) for name in ("values", "periods", "mean", "low", "high", "least", "largest")
    )
    logarithms = joined([b.joined("logarithms") for b in branches], n - 1)
    trusted = joined([b.joined("trusted") for b in branches]) > 0
    unstable, stable = (joined([b.joined(name) for b in branches]) for name in ("unstable", "stable"))
    special = joined([np.array([bool(kind) for kind in b.kinds]) for b in branches])
    numbers = np.repeat(np.arange(len(branches)), [len(b.kinds) for b in branches])
    rates = np.where(trusted, logarithms, complex(math.nan, math.nan)) / periods
    return {
        "value": variable("point", values, plan.along.words, plan.along.unit),
        "period": variable("point", periods, "period", s.time),
        "period_phi": variable("point", phi_of(plan, periods, mean), f"period in the {_ANGLE}"),
        "min_speed": variable("point", low, f"least {s.shown}", s.unit),
        "max_speed": variable("point", high, f"largest {s.shown}", s.unit),
        "mean_speed": variable("point", mean, f"mean {s.shown}", s.unit),
        "min_amplitude": variable("point", least, "least amplitude of the axis", s.length),
        "max_amplitude": variable("point", largest, "largest amplitude of the axis", s.length),
        "unstable": variable("point", unstable.astype(int), "how many disturbances grow"),
        "stable": variable("point", stable.astype(np.int8), "stable"),
        "at_special": variable("point", special.astype(np.int8), "a special point"),
        "branch": variable("point", numbers.astype(int), "branch"),
        "exponent_re": variable("exponent point", rates.real, "real part of an exponent, by collocation", rate_unit(plan)),
        "exponent_im": variable("exponent point", rates.imag, "imaginary part of an exponent, by collocation", rate_unit(plan)),
    }


def of_reported(plan: Plan, findings: OrbitFindings) -> dict[str, Variable]:
    """The orbits that are reported, and how they run."""
    s, n = plan.problem, len(plan.problem.system.states)
    orbits = [one for _, one in findings.reported]
    exponents, rate = joined([o.exponents[:, None] for o in orbits], n - 1), rate_unit(plan)
    shape = (len(orbits), len(orbits[0].shown) if orbits else 0)
    times = [np.linspace(0.0, o.period, shape[1]) for o in orbits]
    table = {name: np.array(rows, float).reshape(shape) for name, rows in (
        ("time", times), ("turned", [o.turned for o in orbits]), ("shown", [o.shown for o in orbits]),
        ("amplitude", [o.amplitude for o in orbits]),
    )}  # fmt: skip
    return {
        "orbit_value": variable("orbit", [o.value for o in orbits], plan.along.words, plan.along.unit),
        "orbit_period": variable("orbit", [o.period for o in orbits], "period", s.time),
        "orbit_period_phi": variable("orbit", [o.period_phi for o in orbits], f"period in the {_ANGLE}"),
        "orbit_min_speed": variable("orbit", [o.low for o in orbits], f"least {s.shown}", s.unit),
        "orbit_max_speed": variable("orbit", [o.high for o in orbits], f"largest {s.shown}", s.unit),
        "orbit_branch": variable("orbit", np.array([k for k, _ in findings.reported], int), "branch"),
        "orbit_kind": variable("orbit", np.array([o.kind for o in orbits], "U16"), "kind of the special orbit"),
        "orbit_exponent_re": variable("exponent orbit", np.asarray(exponents.real), "real part of an exponent", rate),
        "orbit_exponent_im": variable("exponent orbit", np.asarray(exponents.imag), "imaginary part of an exponent", rate),
        "orbit_time": variable("orbit place", table["time"], "time", s.time),
        "orbit_turned": variable("orbit place", table["turned"], _ANGLE, "rad" if s.time else ""),
        "orbit_speed": variable("orbit place", table["shown"], s.shown, s.unit),
        "orbit_amplitude": variable("orbit place", table["amplitude"], "amplitude of the axis", s.length),
    }  # fmt: skip


def of_ends(plan: Plan, ends: Sequence[tuple[int, BranchEnd]]) -> dict[str, Variable]:
    """How the branches end."""
    s = plan.problem
    laws = [(e.saddle_node, e.connection) for _, e in ends]
    residuals = [[math.nan if law is None else law.residual for law in pair] for pair in laws]
    seen = [
        s.observables(e.equilibrium[:, None], e.parameter)[:, 0] if len(e.equilibrium) else np.full(2, math.nan)
        for _, e in ends
    ]
    shown = np.array(seen).reshape(len(ends), 2)
    return {
        "end_value": variable("end", [e.parameter for _, e in ends], plan.along.words, plan.along.unit),
        "end_error": variable("end", [e.error for _, e in ends], f"error of {plan.along.words}", plan.along.unit),
        "end_kind": variable("end", np.array([e.kind for _, e in ends], "U24"), "kind of the end"),
        "end_branch": variable("end", np.array([k for k, _ in ends], int), "branch"),
        "end_speed": variable("end", shown[:, 0], f"{s.shown} of the equilibrium there", s.unit),
        "end_amplitude": variable("end", shown[:, 1], "amplitude of the equilibrium there", s.length),
        "end_residual": variable(
            "end law", np.array(residuals, float).reshape(len(ends), 2), "residual of a law of the period, relative"
        ),
    }


def of_steady(plan: Plan, findings: OrbitFindings) -> dict[str, Variable]:
    """The branches of steady states beside those of orbits."""
    s, steady = plan.problem, findings.steady
    seen = [] if plan.case.steady is None else [plan.case.steady.states.ordinates(b.u) for b in steady]
    return of_steady_branches("steady", "steady_", steady, seen, plan.along, (s.shown, s.unit, s.length))
