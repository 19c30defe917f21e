"""The portrait of two equations: their origin and window; fixed points, separatrices with their ends, closed curves."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.averaged_equations import averaged_equations_of, keeps_inertia
from wucht.analysis.sections import Axis, Section, section_of
from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import has_damped_balancers, machine_at_speed
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.phase_plane.closed_curves import ClosedCurve
from wucht.numerics.phase_plane.fixed_points import DEGENERATE, SADDLE, FixedPoints, fixed_points, window_around
from wucht.numerics.phase_plane.manifolds import Manifold, manifold
from wucht.numerics.phase_plane.phase_curves import CLOSED_CURVE, FIXED_POINT, PhaseCurve, Portrait
from wucht.numerics.phase_plane.plane import TURN, Plane
from wucht.system import Output, System

_DRAWN_TURNS = 2  # of an angle, by default
_SAMPLE_STRIDE = 3  # of the samples of a curve: a figure needs no more
_GOLDEN = 1.32471795724474602596  # x^3 = x + 1: M. Roberts' evenly spread sequence in the plane
_ROTOR_ANGLE = "turned"
_LEAST = 4  # curves that are followed both ways, drawn or not, to detect closed curves


@dataclass(frozen=True, eq=False)
class PlanarPortrait:
    """A portrait. transverse: of each fixed point of a machine, the eigenvalues out of the section. trajectories: forwards and
    backwards from each start. curve_count: number of followed curves, drawn or not. rotor_angles: angle of the main rotor in
    a period of each closed curve."""

    fixed_points: FixedPoints
    transverse: tuple[np.ndarray, ...]
    separatrices: tuple[Manifold, ...]
    trajectories: tuple[tuple[PhaseCurve, PhaseCurve], ...]
    closed_curves: tuple[ClosedCurve, ...]
    curve_count: int
    rotor_angles: tuple[float, ...]

    @classmethod
    def of(
        cls,
        plane: Plane,
        section: Section | None,
        starts: np.ndarray,
        seed: int,
        length: float,
        report: Callable[[float, str], None],
    ) -> PlanarPortrait:
        """Compute a portrait.

        Parameters
        ----------
        plane : Plane
        section : Section, optional
            The origin of its equations.
        starts : array (2, k)
            Of trajectories. If they are few, further ones that ``seed`` gives are followed, but not drawn.
        seed : int
        length : float
            Of a curve, in windows, at which it is stopped.
        report : callable
            Takes the share that is done, and what is computed.
        """
        fixed_set = fixed_points(plane, partial(report, 0.0, "fixed points"))
        portrait = Portrait(plane, fixed_set.points, length, check=partial(report, 0.1, "separatrices"))
        separatrices: list[Manifold] = []
        for k, point in enumerate(fixed_set.points):
            for stable, side in ((False, 1), (False, -1), (True, 1), (True, -1)) if point.kind == SADDLE else ():
                separatrices.append(manifold(portrait, k, stable, side))
        trajectories: list[tuple[PhaseCurve, PhaseCurve]] = []
        drawn_count = starts.shape[1]
        if drawn_count < _LEAST:
            starts = np.concatenate([starts, spread_starts(plane, seed, _LEAST)[:, drawn_count:]], axis=1)
        for k, start in enumerate(starts.T):
            portrait.check = partial(report, 0.2 + 0.8 * k / starts.shape[1], "trajectories")
            pair = _thin_curve(portrait.follow(start, True)), _thin_curve(portrait.follow(start, False))
            trajectories += [pair] if k < drawn_count else []
        return cls(
            fixed_set,
            tuple(section.transverse(p.state) for p in fixed_set.points) if section is not None else (),
            tuple(replace(m, curve=_thin_curve(m.curve)) for m in separatrices),
            tuple(trajectories),
            tuple(portrait.closed_curves),
            len(separatrices) + 2 * starts.shape[1],
            tuple(_rotor_angle(section, c) for c in portrait.closed_curves) if section is not None else (),
        )

    @property
    def sentence(self) -> str:
        """The numbers of its fixed points and closed curves by their kinds."""
        kinds = Counter(p.kind for p in self.fixed_points.points)
        point_counts = ", ".join(f"{n} {kind if n == 1 or kind == DEGENERATE else _plural(kind)}" for kind, n in kinds.items())
        proof = "" if not self.fixed_points.complete else " (proved to be all)" if point_counts else " (proved)"
        sentence = f"{point_counts or 'no fixed point'}{proof}"
        if self.closed_curves:
            curve_counts = Counter(
                "closed curve of a family" if c.neutral else f"{c.kind} closed curve" for c in self.closed_curves
            )
            sentence += ", " + ", ".join(
                f"{n} {kind.replace('curve', 'curves') if n > 1 else kind}" for kind, n in curve_counts.items()
            )
        return sentence

    def end_label(self, curve: PhaseCurve) -> str:
        """Return the name of what a curve ends at, by its kind and number."""
        if curve.end == FIXED_POINT:
            return f"{self.fixed_points.points[curve.index].kind} {curve.index + 1}"
        return f"closed curve {curve.index + 1}" if curve.end == CLOSED_CURVE else curve.end


def _plural(kind: str) -> str:
    return kind.replace("focus", "foci") if "focus" in kind else f"{kind}s"


def spread_starts(plane: Plane, seed: int, count: int) -> np.ndarray:
    """Return evenly spread starts (2, k), the first by the seed."""
    first = np.random.default_rng(seed).uniform(size=2)
    steps = np.array([1 / _GOLDEN, 1 / _GOLDEN**2])
    share = np.remainder(first[:, None] + steps[:, None] * np.arange(count), 1.0)
    return np.asarray(plane.low[:, None] + share * plane.scale[:, None])


def _thin_curve(curve: PhaseCurve) -> PhaseCurve:
    keep = np.unique(np.concatenate([np.arange(0, curve.states.shape[1], _SAMPLE_STRIDE), [curve.states.shape[1] - 1]]))
    return replace(curve, states=curve.states[:, keep], time=curve.time[keep])


def _rotor_angle(section: Section, curve: ClosedCurve) -> float:
    """Return the angle by which the main rotor turns in a period."""
    if section.turning < 0:
        return abs(section.speed or 0.0) * curve.period
    system = replace(section.system, outputs=(), quadratures=(Output(_ROTOR_ANGLE, section.system.states[section.turning]),))
    ends = np.array([0.0, curve.period])
    run_ = integrate(
        compile_system(system), curve.states[:, 0], section.system.values(section.values), ends
    ).reraise_interrupt()
    if run_.failure is not None:
        raise WuchtError(run_.failure)
    return abs(float(run_.quadratures[_ROTOR_ANGLE][-1]))


def planar_section(
    machine: Machine,
    together: bool | tuple[str, ...] | None = None,
    speed: float | None = None,
    inertia: bool | None = None,
    order: int = 1,
    kind: str | None = None,
) -> Section:
    """Return the requested section. Raises ``InputError``: it has not two states, or curves do not stay in it.

    Where the inertia of balancing bodies would leave more than two states, it is left out by default, with a warning. kind: of
    the study, for the error.
    """
    steady = machine_at_speed(machine, None)

    def candidate(keeps: bool) -> Section:
        averaged_equations = averaged_equations_of(steady, keeps, order, has_fixed_speed=speed is not None)
        return section_of(averaged_equations, together, speed)

    section = candidate(keeps_inertia(steady, inertia))
    if inertia is None and section.inertia and len(section.axes) > 2 and has_damped_balancers(steady):
        section = candidate(False)
        bodies = ", ".join(b.name for b in steady.bodies if b.about is not None)
        advice = "study.kind = 'approximation' shows how far such equations are from the full ones"
        left_out = (
            f"the inertia of {bodies} is left out, as if their damping were strong: with it, there are more than two states"
        )
        section = replace(section, warnings=(*section.warnings, f"{left_out}; {advice}"))
    if len(section.axes) != 2:
        _refuse_section(section, together, speed, kind)
    return section


def _refuse_section(section: Section, together: bool | tuple[str, ...] | None, speed: float | None, kind: str | None) -> None:
    names = section.whole.state_names
    groups = [[n for n, x in zip(names, column, strict=True) if x] for column in section.embedding.T]
    listing = ", ".join(" = ".join(group) for group in groups)
    if len(groups) < 2 and together and speed is not None:
        advice = "leave out speed, so that the main rotor's speed is a state, or together"
        raise InputError("study.speed", speed, f"with together, only one of two states is left, {listing}: {advice}")
    if len(groups) < 2:
        raise InputError(
            "study.kind",
            kind,
            f"a phase portrait has two states, and this machine's averaged equations have {listing or 'none'}",
        )
    without = ", inertia = false leaves out the speeds of the bodies" if section.inertia else ""
    raise InputError(
        "study.together", together,
        f"a phase portrait has two states, and these averaged equations have {len(groups)}: {listing}; "
        f"together = true keeps the phases of the balancing bodies equal, speed holds the main rotor's speed{without}",
    )  # fmt: skip


def system_axes(system: System) -> tuple[Axis, Axis]:
    """Return the two states of a system. Raises ``InputError`` if it has another number of them."""
    if len(system.states) != 2:
        names = ", ".join(system.state_names)
        raise InputError("system.states", names, f"a phase portrait has two states, not {len(system.states)}")
    turning = list(system.is_angle)
    a, b = (
        Axis(s.name, s.name, "rad" if turns else "", *((0.0, TURN) if turns else (math.nan, math.nan)))
        for s, turns in zip(system.states, turning, strict=True)
    )
    return a, b


def common_window(
    systems: list[tuple[System, Mapping[str, float]]], axes: tuple[Axis, ...], ranges: Mapping[str, tuple[float, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the window of all portraits: as given, by default from the machine's speeds, else around all fixed points."""
    turning = [s in systems[0][0].angles for s in systems[0][0].states]
    ends = []
    for a, turns in zip(axes, turning, strict=True):
        low, high = (0.0, TURN) if turns else ranges.get(a.name, (a.low, a.high))
        ends.append((low, high))
    low, high = np.array(ends, float).T
    if np.isfinite(low).all():
        return low, high
    windows = [window_around(system, numbers, low, high) for system, numbers in systems]
    valid_windows = [f for f in windows if f is not None]
    if not valid_windows:
        missing = next(a.name for a, x in zip(axes, low, strict=True) if math.isnan(x))
        raise InputError("study.ranges", None, f"no fixed point was found from which to choose it: give a range of {missing}")
    return np.min([k[0] for k in valid_windows], axis=0), np.max([k[1] for k in valid_windows], axis=0)


def drawn_ranges(plane: Plane, axes: tuple[Axis, ...], ranges: Mapping[str, tuple[float, float]]) -> np.ndarray:
    """Return the ranges (2, 2) of the states in a figure: as given, by default the window, and two turns of a single angle."""
    several = (plane.turns > 0).all()
    default = [(lo, lo + (1 if several else _DRAWN_TURNS) * TURN) if t else (lo, hi) for lo, hi, t in _sides(plane)]
    return np.array([ranges.get(a.name, d) for a, d in zip(axes, default, strict=True)])


def _sides(plane: Plane) -> list[tuple[float, float, bool]]:
    return list(zip(plane.low.tolist(), plane.high.tolist(), (plane.turns > 0).tolist(), strict=True))
