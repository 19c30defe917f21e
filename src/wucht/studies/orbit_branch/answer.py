"""The answer of a branch of orbits: its orbits, those that are reported, how the branches end, and the steady states."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wucht.dynamics.branches.first_orbits import LONGEST
from wucht.dynamics.branches.orbit_branches import PeriodicBranch
from wucht.dynamics.branches.orbit_diagram import MOST_BRANCHES, OrbitCase, OrbitFindings, ReportedOrbit
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.numerics.periodic.branch_ends import CLOSED_BRANCH, NOT_IDENTIFIED, PERIOD_LIMIT, BranchEnd, significant_value
from wucht.schema import Parameter
from wucht.studies.answer import Answer, Column
from wucht.studies.limit_set_variables import LIMIT_SET_NUMBERS
from wucht.studies.motion_variables import join_arrays, parameter_columns, state_steady_points

_PRODUCT = 0.1  # largest error of ln of the multipliers' product without a warning
_AT_A_LIMIT, _FARTHER = 1e-9, 10.0  # of the longest period: an end there; a longest period that is proposed
_MOST_LOST = 4  # sentences on branches that could not be followed
_MOST = 16  # orbits, and special points, named one by one
_PERIOD_PHI = "period in the angle of the main rotor"
_ENDS = {
    "saddle-node-on-orbit": "a saddle-node on the orbit", "saddle-connection": "a saddle connection", "hopf": "a Hopf point",
    "range": "the end of the range", "period-limit": "the longest period that is followed (study.longest)",
    "not-identified": "an end that is not identified",
}  # fmt: skip
_Ends = Sequence[tuple[int, BranchEnd]]  # with the numbers of their branches


def state_orbit_branches(a: Answer, along: Parameter, case: OrbitCase, findings: OrbitFindings) -> None:
    """State the answer, as far as orbits are found."""
    problem, labels, branches = case.problem, case.problem.labels, findings.branches
    ends = [(k, end) for k, branch in enumerate(branches) for end in branch.ends]
    a.sentence = _sentence(along, case, findings, ends)
    a.attribute(
        along=along.path, along_unit=along.unit, along_what=along.full_name, low=problem.bounds[0], high=problem.bounds[1],
        shown=labels.ordinate, rotor=int(problem.shows_rotor_speed), angles=int(problem.turning.any()),
        state=labels.state or "", **({"subject": "system"} if labels.of_equations else {}),
    )  # fmt: skip
    a.number("along", along.path, "parameter over which branches are followed")
    a.number("along_unit", along.unit, "its unit")
    a.number("range", list(problem.bounds), f"range of the {along.full_name}", along.unit)
    a.number("inertia", labels.inertia, "whether the averaged equations keep the inertia of the balancing bodies")
    a.number("section", problem.embedding is not None, "whether the phases of bodies are kept equal")
    _state_points(a, along, problem, branches)
    _state_branches(a, along, problem, branches, ends)
    _state_special_points(a, along, problem, branches)
    _state_orbits(a, along, problem, findings.orbits)
    _state_ends(a, along, case, branches, ends)
    _state_steady(a, along, case, findings)
    a.curve("law", ["saddle-node", "connection"], "law of the period")
    runs = parameter_columns((along, [t.value for t in findings.runs])) | {
        "found": ([t.sentence for t in findings.runs], "result of the run")
    }
    a.table_of("tried", "runs in search of a first orbit", runs)
    if problem.shows_rotor_speed and branches:
        disturbances = "all disturbances" if problem.embedding is None else "disturbances with equal phases of the bodies only"
        a.line("stability", f"in the averaged equations, of {disturbances}; exponents: per unit of time")
    _warn(a, along, case, findings)


def _state_points(a: Answer, along: Parameter, problem: OrbitProblem, branches: Sequence[PeriodicBranch]) -> None:
    """State all orbits of all branches."""
    s, n, ordinate = problem.labels, len(problem.system.states), problem.ordinate_name
    values, periods, mean, low, high, least, largest = (
        join_arrays([getattr(b, name) for b in branches])
        for name in ("values", "periods", "mean", "low", "high", "least", "largest")
    )
    logarithms = join_arrays([b.logarithms for b in branches], n - 1)
    is_trusted = join_arrays([b.is_trusted for b in branches]) > 0
    unstable, stable = (join_arrays([getattr(b, name) for b in branches]) for name in ("unstable", "stable"))
    special = join_arrays([np.array([bool(kind) for kind in b.kinds]) for b in branches])
    numbers = np.repeat(np.arange(len(branches)), [len(b.kinds) for b in branches])
    rates = np.where(is_trusted, logarithms, complex(math.nan, math.nan)) / periods
    a.curve("value", values, along.full_name, along.unit, "point")
    a.curve("period", periods, "period", s.time, "point")
    a.curve(f"min_{ordinate}", low, f"least {s.ordinate}", s.unit, "point")
    a.curve(f"max_{ordinate}", high, f"largest {s.ordinate}", s.unit, "point")
    a.curve(f"mean_{ordinate}", mean, f"mean {s.ordinate}", s.unit, "point")
    if not s.of_equations:
        a.curve("period_phi", periods * np.abs(mean), _PERIOD_PHI, "", "point")
        a.curve("min_amplitude", least, "least amplitude of the axis", s.length, "point")
        a.curve("max_amplitude", largest, "largest amplitude of the axis", s.length, "point")
    a.curve("unstable", unstable.astype(int), "number of growing disturbances", "", "point")
    a.curve("stable", stable.astype(np.int8), "stable", "", "point")
    a.curve("at_special", special.astype(np.int8), "a special point", "", "point")
    a.curve("branch", numbers.astype(int), "branch", "", "point")
    a.curve("exponent_re", rates.real, "real part of an exponent, by collocation", s.rate, "exponent point")
    a.curve("exponent_im", rates.imag, "imaginary part of an exponent, by collocation", s.rate, "exponent point")


def _state_branches(
    a: Answer, along: Parameter, problem: OrbitProblem, branches: Sequence[PeriodicBranch], ends: _Ends
) -> None:
    """State the extent of each branch, where it is stable, and how it ends."""
    extents = [problem.significant_range(v.min(), v.max()) for v in (b.values for b in branches)]
    stable = [[problem.significant_range(*stretch) for stretch in b.stable_ranges] for b in branches]
    turns = [problem.turns(b.seed.winding) for b in branches]
    a.table(
        "branches", "branches of orbits",
        begun=([b.seed.origin for b in branches], "origin of the branch"),
        range=(extents, along.full_name, along.unit),
        winding=(turns, "turns of the angles in a period"),
        stable=(stable, f"ranges of the {along.full_name} in which orbits are stable", along.unit),
    )  # fmt: skip
    for k, branch in enumerate(branches):
        stretches = ", ".join(_range_text(stretch, along.unit) for stretch in stable[k])
        stability = f"stable at {along.path} from {stretches}" if stretches else "nowhere stable"
        winding = ", ".join(f"{name} {count:+d}" for name, count in turns[k].items())
        rotation = f"; turns a period: {winding}" if winding else "; all angles return" if problem.turning.any() else ""
        extent = f"{along.path} from {_range_text(extents[k], along.unit)}"
        a.line(f"branch {k + 1}", f"from {branch.seed.origin}: {extent}, {stability}{rotation}")
        for i, (of, _) in enumerate(ends):
            if of == k:
                a.line("  end", "{sentence}", at=f"ends[{i}]")


def _state_special_points(a: Answer, along: Parameter, problem: OrbitProblem, branches: Sequence[PeriodicBranch]) -> None:
    points = [(k, i) for k, branch in enumerate(branches) for i in np.flatnonzero([bool(x) for x in branch.kinds]).tolist()]

    def column(name: str) -> list[float]:
        return [float(getattr(branches[k], name)[i]) for k, i in points]

    values = [significant_value(value, problem.bounds) for value in column("values")]
    periods, kinds, s = column("periods"), [branches[k].kinds[i] for k, i in points], problem.labels
    angles = [period * abs(speed) for period, speed in zip(periods, column("mean"), strict=True)]
    hidden = [branches[k].hidden_points[i] for k, i in points]
    of_machine: dict[str, Column] = {"period_phi": (angles, _PERIOD_PHI)} if problem.shows_rotor_speed else {}
    columns = parameter_columns((along, values))
    a.table_of("special_points", "special orbits", optional=("hidden", "between"), columns=columns | {
        "kind": (kinds, "kind of the special orbit"),
        "branch": ([k for k, _ in points], "branch"),
        "period": (periods, "period", s.time),
        **of_machine,
        f"min_{problem.ordinate_name}": (column("low"), f"least {s.ordinate}", s.unit),
        f"max_{problem.ordinate_name}": (column("high"), f"largest {s.ordinate}", s.unit),
        "hidden": ([None if h is None else h.kind for h in hidden], "kind of a point that was not located"),
        "between": ([None if h is None else list(h.interval) for h in hidden], along.full_name, along.unit),
    })  # fmt: skip
    for j, (kind, value, point) in enumerate(zip(kinds[:_MOST], values, hidden, strict=False)):
        place = f"{along.path} = {value:.8g} {along.unit}".rstrip()
        if point is not None:
            between = f"{point.interval[0]:.8g} to {point.interval[1]:.8g} {along.unit}".rstrip()
            place = f"{along.path} from {between}: a {point.kind} that was not located"
        a.line(f"{kind:12} ", f"{place}: {_period_text(problem, periods[j], angles[j])}")


def _state_orbits(
    a: Answer, along: Parameter, problem: OrbitProblem, numbered_orbits: Sequence[tuple[int, ReportedOrbit]]
) -> None:
    """State the reported orbits, with their course over a period."""
    s, n, ordinate = problem.labels, len(problem.system.states), problem.ordinate_name
    orbits = [one for _, one in numbered_orbits]
    low, high = f"min_{ordinate}", f"max_{ordinate}"
    multipliers = [np.exp(o.exponents * o.period) for o in orbits]
    stable = [bool(o.exponents.real.max(initial=-np.inf) < 0) if not o.kind else None for o in orbits]
    of_machine: dict[str, Column] = {
        "period_phi": ([o.period_phi for o in orbits], _PERIOD_PHI),
        "min_amplitude": ([o.least for o in orbits], "least amplitude of the axis", s.length),
        "max_amplitude": ([o.largest for o in orbits], "largest amplitude of the axis", s.length),
        "exponents_phi": (
            [_pairs(o.exponents * (o.period / o.period_phi)) for o in orbits], "exponents over the angle of the main rotor"
        ),
    }  # fmt: skip
    kinds = {"value": float, "period": float, low: float, high: float, "branch": int}
    columns = parameter_columns((along, [o.value for o in orbits]))
    a.table_of("orbits", "orbits", over="orbit", kinds=kinds, columns=columns | {
        "kind": ([o.kind or None for o in orbits], "kind of the special orbit"),
        "branch": ([k for k, _ in numbered_orbits], "branch"),
        "period": ([o.period for o in orbits], "period", s.time),
        low: ([o.low for o in orbits], f"least {s.ordinate}", s.unit),
        high: ([o.high for o in orbits], f"largest {s.ordinate}", s.unit),
        "exponents": ([_pairs(o.exponents) for o in orbits], "exponents", s.rate),
        "multipliers": ([_pairs(row) for row in multipliers], LIMIT_SET_NUMBERS["multipliers"][0]),
        **(of_machine if problem.shows_rotor_speed else {}),
        "stable": (stable, "whether it is stable"),
    })  # fmt: skip
    for i, one in enumerate(orbits[:_MOST]):
        if not one.kind:
            place = f"{along.path} = {one.value:.9g} {along.unit}".rstrip()
            period = _period_text(problem, one.period, one.period_phi)
            word = "stable" if stable[i] else "unstable"
            growth = f", largest exponent {one.exponents[0].real:.5g}, {word}" if len(one.exponents) else ""
            extent = f"{s.state} {one.low:.6g} to {one.high:.6g}" if s.state else f"{{{low}}} to {{{high}}}"
            a.line("orbit", f"{place}: {period}, {extent}{growth}", at=f"orbits[{i}]")
    if len(orbits) > _MOST:
        a.line(f"and {len(orbits) - _MOST} more orbits: see the Dataset", "")
    exponents = join_arrays([o.exponents[:, None] for o in orbits], n - 1)
    joined_multipliers = join_arrays([row[:, None] for row in multipliers], n - 1)
    shape = (len(orbits), len(orbits[0].ordinate) if orbits else 0)

    def courses(rows: Sequence[np.ndarray]) -> np.ndarray:
        return np.array(rows, float).reshape(shape)

    a.curve("orbit_kind", np.array([o.kind for o in orbits], "U16"), "kind of the special orbit", "", "orbit")
    a.curve("orbit_exponent_re", np.asarray(exponents.real), "real part of an exponent", s.rate, "exponent orbit")
    a.curve("orbit_exponent_im", np.asarray(exponents.imag), "imaginary part of an exponent", s.rate, "exponent orbit")
    a.curve("orbit_multiplier_re", np.asarray(joined_multipliers.real), "real part of a multiplier", "", "exponent orbit")
    a.curve("orbit_multiplier_im", np.asarray(joined_multipliers.imag), "imaginary part of a multiplier", "", "exponent orbit")
    a.curve("orbit_time", courses([o.shares * o.period for o in orbits]), "time", s.time, "orbit place", coordinate=True)
    name = "orbit_state" if s.of_equations else "orbit_speed"
    a.curve(name, courses([o.ordinate for o in orbits]), s.ordinate, s.unit, "orbit place")
    if s.of_equations:
        states = np.array([o.states for o in orbits], float).reshape(shape[0], n, shape[1])
        a.curve("state", problem.system.state_names, "state")
        a.curve("turning", problem.turning.astype(np.int8), "whether it is an angle", "", "state")
        a.curve("orbit_states", states, "states", "", "orbit state place")
    else:
        a.curve("orbit_period_phi", [o.period_phi for o in orbits], _PERIOD_PHI, "", "orbit")
        angles, amplitudes = courses([o.rotor_angle for o in orbits]), courses([o.amplitude for o in orbits])
        a.curve("orbit_turned", angles, "angle of the main rotor", "rad" if s.time else "", "orbit place")
        a.curve("orbit_amplitude", amplitudes, "amplitude of the axis", s.length, "orbit place")


def _state_ends(a: Answer, along: Parameter, case: OrbitCase, branches: Sequence[PeriodicBranch], numbered_ends: _Ends) -> None:
    s, names, ends = case.problem.labels, case.problem.system.state_names, [e for _, e in numbered_ends]
    sentences = [e.sentence + _advice(case, branches[k].seed.longest, e) for k, e in numbered_ends]
    states = [dict(zip(names, e.equilibrium.tolist(), strict=True)) if len(e.equilibrium) else None for e in ends]
    laws = [None if e.saddle_node is None or e.connection is None else {
        "saddle-node": {
            "critical": e.saddle_node.critical, "error": e.saddle_node.error, "factor": e.saddle_node.factor,
            "residual": e.saddle_node.residual,
        },
        "connection": {
            "critical": e.connection.critical, "error": e.connection.error, "rate": 1 / e.connection.factor,
            "residual": e.connection.residual,
        },
    } for e in ends]  # fmt: skip
    kinds = {"value": float, "error": float, "kind": str, "branch": int}
    columns = parameter_columns((along, [e.parameter for e in ends]))
    a.table_of("ends", "ends of the branches", over="end", kinds=kinds, columns=columns | {
        "kind": ([e.kind for e in ends], "kind of the end"),
        "branch": ([k for k, _ in numbered_ends], "branch"),
        "error": ([e.error for e in ends], f"error of {along.full_name}", along.unit),
        "period": ([e.period for e in ends], "period", s.time),
        "sentence": (sentences, "how the branch ends"),
        "state": (states, "states of the equilibrium there"),
        "eigenvalues": ([_pairs(e.eigenvalues) for e in ends], "eigenvalues of the equilibrium there", s.rate),
        "laws": (laws, "laws of the period"),
        "critical": ((), along.full_name, along.unit),
        "rate": ((), "rate of a connection's law", s.rate),
    })  # fmt: skip
    ordinates, residuals = (np.array(rows, float).reshape(len(ends), 2) for rows in (
        [
            case.problem.observables(e.equilibrium[:, None], e.parameter)[:, 0] if len(e.equilibrium) else np.full(2, math.nan)
            for e in ends
        ],
        [[math.nan if law is None else law.residual for law in (e.saddle_node, e.connection)] for e in ends],
    ))  # fmt: skip
    name = "end_state" if s.of_equations else "end_speed"
    a.curve(name, ordinates[:, 0], f"{s.ordinate} of the equilibrium there", s.unit, "end")
    if not s.of_equations:
        a.curve("end_amplitude", ordinates[:, 1], "amplitude of the equilibrium there", s.length, "end")
    a.curve("end_residual", residuals, "residual of a law of the period, relative", "", "end law")


def _advice(case: OrbitCase, longest: float, end: BranchEnd) -> str:
    """Return how to follow a branch farther that was left at the longest period; else nothing."""
    if end.kind not in (PERIOD_LIMIT, NOT_IDENTIFIED) or end.period < (1 - _AT_A_LIMIT) * longest:
        return ""
    default = "" if case.longest is not None else f" (by default it is {LONGEST:.0f} times the first period)"
    farther = float(f"{_FARTHER * longest:.1g}")
    return f"; study.longest = {farther:g} follows the branch farther{default}"


def _state_steady(a: Answer, along: Parameter, case: OrbitCase, findings: OrbitFindings) -> None:
    """State the branches of steady states beside those of orbits."""
    s, steady = case.problem.labels, findings.steady
    of_branches = [] if case.steady is None else [case.steady.steady_states] * len(steady)
    state_steady_points(a, "steady", "steady_", steady, of_branches, along, s)
    if s.of_equations:
        ordinates = [states.ordinate(b.unknowns) for states, b in zip(of_branches, steady, strict=True)]
        a.curve("steady_state", join_arrays(ordinates), s.ordinate, s.unit, "steady")


def _pairs(values: np.ndarray) -> list[list[float]]:
    return [[float(v.real), float(v.imag)] for v in values]


def _period_text(problem: OrbitProblem, period: float, angle: float) -> str:
    phi = f" ({angle:.8g} of the rotor's angle)" if problem.shows_rotor_speed else ""
    return f"period {period:.8g} {problem.labels.time}".rstrip() + phi


def _range_text(ends: Sequence[float], unit: str) -> str:
    return f"{ends[0]:.7g} to {ends[1]:.7g} {unit}".rstrip()


def _sentence(along: Parameter, case: OrbitCase, findings: OrbitFindings, ends: _Ends) -> str:
    problem = case.problem
    if not findings.branches:
        if not findings.complete:
            return "the study was interrupted before the first orbit"
        results = "; ".join(t.sentence for t in findings.runs)
        if any(t.is_family for t in findings.runs):
            return f"the motions are families, of which none attracts: there is no single orbit to follow: {results}"
        return f"no modulated motion was found: {results}" + (f"; {case.no_steady_reason}" if case.no_steady_reason else "")
    first, more_branches = findings.branches[0], len(findings.branches) - 1
    values, first_ends = first.values, sorted((e for k, e in ends if k == 0), key=lambda e: e.parameter)
    extent = problem.significant_range(min(values.min(), first_ends[0].parameter), max(values.max(), first_ends[-1].parameter))
    names = [_ENDS.get(e.kind, e.kind.replace("-", " ")) for e in first_ends]
    ending = f"both ends are {names[0]}" if len(set(names)) == 1 and len(names) > 1 else f"it ends at {' and at '.join(names)}"
    ending = "it is closed" if first_ends[0].kind == CLOSED_BRANCH else ending
    stable = ", ".join(_range_text(problem.significant_range(*stretch), along.unit) for stretch in first.stable_ranges)
    within = " within their section" if problem.embedding is not None else ""
    stability = f"stable{within} from {stable}" if stable else "nowhere stable"
    more = f"; {'one more branch' if more_branches == 1 else f'{more_branches} more branches'}" if more_branches else ""
    motions = "modulated motions" if problem.shows_rotor_speed else "periodic orbits"
    return f"{motions} at {along.sentence_name} from {_range_text(extent, along.unit)}, {stability}; {ending}{more}"


def _warn(a: Answer, along: Parameter, case: OrbitCase, findings: OrbitFindings) -> None:
    """Warn of omissions, doubts, and unfinished work."""
    branches = findings.branches
    a.warn(*case.problem.labels.warnings, *findings.omissions[:_MOST_LOST])
    if len(findings.omissions) > _MOST_LOST:
        a.warn(f"and {len(findings.omissions) - _MOST_LOST} more")
    if case.no_steady_reason and branches and not case.no_steady_reason.startswith("equilibria"):
        a.warn(case.no_steady_reason)
    errors = [b.product_error[b.is_trusted] for b in branches]
    if count := (np.concatenate([np.empty(0), *errors]) > _PRODUCT).sum():
        a.warn(
            f"of {count} orbits the fastest decays are unknown: the product of the multipliers differs from that which the "
            "divergence of the equations demands"
        )
    excess = np.concatenate([np.empty(0), *(b.excess_error for b in branches)])
    if excess.any():
        a.warn(
            f"{(excess > 0).sum()} orbits change too fast for the finest mesh: between its points their states are known to "
            f"{excess.max():.1g} of their range only"
        )
    if len(branches) >= MOST_BRANCHES:
        a.warn(f"more than {MOST_BRANCHES} branches: the others are left out")
    missing = [v for v in case.values or () if not any(one.value == v for _, one in findings.orbits)]
    if findings.complete and branches and missing:
        a.warn(f"there is no orbit of a known branch at {along.path} = {', '.join(f'{v:.6g}' for v in missing)}")
    if not findings.complete:
        a.warn("the search is not finished")
