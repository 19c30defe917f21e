"""The answer of a prediction: its numbers, the verdict, and what is to be warned of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from wucht.cams.prediction import unresolved
from wucht.results.quantities import Quantity
from wucht.studies.cam_prediction.computation import Findings, Plan, Turning
from wucht.studies.cam_prediction.confirmation import Confirmation
from wucht.studies.cam_prediction.elasticity import FOR_RIGID_SHAFT, FOR_TWIST, Twists

_CLEAN = 1e-6  # of order 1, beside what the law itself has: below what a workshop can mill
_SLOW, _DIVERGING = 0.5, 1.0  # inertia ratios
_KEPT = 1e-12  # of the mean speed: orders that a cam is made for
_FLOOR = 1e-9  # residuals below are rounding
_TOO_MUCH = 1e-3  # of order 1: what an elastic shaft leaves
_UNRESOLVED = 1e-6  # of the mean speed: orders beyond which more must be
_DOUBTFUL = 1e-5  # of the mean speed: prediction and simulation differ


def summary(plan: Plan, f: Findings) -> dict[str, Any]:
    """The numbers of ``summary.json``: how the shaft turns with the original cam, which moves its output by the law over the
    cam angle, and under ``corrected`` how with the corrected one; inertia_ratio, and the limit up to which there is a corrected
    cam without a drive; power; cut_residuals; simulation."""
    both = {"original": f.original, "corrected": f.corrected}
    constant = _power(f.constant)
    powers = {name: _power(one.drive * one.shaft.speed(f.tau)) for name, one in both.items()}
    found: dict[str, Any] = {
        "unit": plan.motion.unit,
        "harmonics": plan.motion.count,
        "inertia_ratio": plan.shaft.inertia_ratio(plan.motion.law),
        "inertia_ratio_limit": plan.shaft.most_inertia_ratio(plan.motion.law),
        "driven": "eigenmotion" if plan.driving is None else "enforced" if plan.enforced else "drive",
        **_turning(f.original, powers["original"]),
        "corrected": {**_turning(f.corrected, powers["corrected"]), "speed": _coefficients(f.corrected)},
        "above": {"orders": plan.count, "law": f.clean, **{name: one.above for name, one in both.items()}},
        "left_after_a_turn": {name: _number(one.left) for name, one in both.items()},
        "power": {"constant_speed": constant, **powers},
        "power_saved": {key: constant[key] - powers["corrected"][key] for key in ("peak", "mean_positive")},
        "cut_residuals": f.cuts.tolist(),
        "contraction": _contraction(f.cuts, f.clean),
        "simulation": None,
        "output": None,
        "shaft": None,
    }
    if f.confirmed:
        found["simulation"] = {"turns": plan.turns, **{n: _confirmed(plan, c) for n, c in zip(both, f.confirmed, strict=True)}}
    if f.vibrations is not None and plan.output is not None:
        o, excited = plan.output, [asdict(e) for e in f.vibrations.excited]
        found["output"] = {"natural_frequency": o.natural_frequency, "damping_ratio": o.damping_ratio, "excited": excited}
    if f.twists is not None:
        found["shaft"] = [asdict(c) for c in f.twists.cams]
    return found


_STATED = {  # what each number of the summary is, its unit, and what its parts are
    "unit": ("unit of the output", "", ""),
    "harmonics": ("number N of harmonics of the law", "", ""),
    "inertia_ratio": ("largest inertia of the output over that of the shaft", "", ""),
    "inertia_ratio_limit": ("largest inertia ratio with a corrected cam without a drive", "", ""),
    "driven": ("what drives the shaft", "", ""),
    "mean_speed": ("mean speed of the shaft, original cam", "rad/s", ""),
    "fluctuation": ("fluctuation of the speed as a share of its mean, original cam", "", ""),
    "speed_orders": ("amplitudes of the speed, original cam", "rad/s", ""),
    "mean_power": ("mean power of the drive, original cam", "W", ""),
    "eigenmotion": ("motion at this mean speed without drive and loads", "", "turning"),
    "corrected": ("the same with the corrected cam", "", "turning"),
    "above": ("largest order of the output's acceleration above N over order 1", "", ""),
    "left_after_a_turn": ("share of a disturbance of the energy that is left after a turn", "", ""),
    "power": ("power of the drive", "W", ""),
    "power_saved": ("power that the corrected cam saves against constant speed", "W", ""),
    "cut_residuals": ("what is left above N where cams are cut by measurement, one after another", "", ""),
    "contraction": ("share of it that each further cam leaves", "", ""),
    "simulation": ("turns simulated, and how far the speed departs from the prediction", "", ""),
    "output": ("elastic output", "", "output"),
    "shaft": ("elastic shaft, each cam", "", "shaft"),
}  # fmt: skip
_PARTS: dict[str, dict[str, tuple[str, str]]] = {
    "turning": {
        "mean_speed": ("mean speed of the shaft", "rad/s"),
        "fluctuation": ("fluctuation of the speed as a share of its mean", ""),
        "speed_orders": ("amplitudes of the speed", "rad/s"),
        "mean_power": ("mean power of the drive", "W"),
        "period": ("period of a turn", "s"),
        "energy": ("energy of the motion", "J"),
        "speed": ("coefficients of the speed", "rad/s"),
    },
    "output": {
        "natural_frequency": ("natural frequency", "rad/s"),
        "damping_ratio": ("damping ratio", ""),
        "excited": ("what each motion of the lever leaves in the dwell", ""),
    },
    "shaft": {
        "above": ("largest order above N over order 1", ""),
        "torque": ("largest torque in the shaft", "N m"),
        "twist": ("largest twist", "rad"),
    },
}


def stated(numbers: Mapping[str, Any]) -> list[Quantity]:
    """The numbers of the summary as quantities."""
    first = ("fluctuation", "mean_power")
    return [
        Quantity(name, value, what, unit, parts=_PARTS.get(parts, {}), headline=name in first)
        for name, value in numbers.items()
        for what, unit, parts in [_STATED[name]]
    ]


def _turning(one: Turning, power: dict[str, float]) -> dict[str, Any]:
    return {
        "mean_speed": one.shaft.mean,
        "fluctuation": one.shaft.fluctuation,
        "speed_orders": one.shaft.speed.without_rounding(_KEPT).amplitudes.tolist(),
        "mean_power": power["mean"],
        "eigenmotion": None if one.eigenmotion is None else asdict(one.eigenmotion),
    }


def _coefficients(one: Turning) -> dict[str, Any]:
    """The speed with the corrected cam as the table [speed] of cam-correction and cam-contour takes it."""
    kept = one.shaft.speed.without_rounding(_KEPT)
    return {"mean": kept.mean, "cosine": kept.cosine.tolist(), "sine": kept.sine.tolist()}


def _power(power: np.ndarray) -> dict[str, float]:
    """Peak, mean, and mean of the positive part, over a turn of evenly spaced points whose last one is the first again."""
    each = power[:-1]
    return {"peak": float(each.max()), "mean": float(each.mean()), "mean_positive": float(np.maximum(each, 0.0).mean())}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _contraction(cuts: np.ndarray, clean: float) -> float | None:
    """By how much each further cam is cleaner than the one before: the last such share that is not rounding."""
    above = cuts[cuts > _FLOOR + 2 * clean]
    return float(above[-1] / above[-2]) if len(above) > 1 else None


def _confirmed(plan: Plan, one: Confirmation) -> dict[str, float | str | None]:
    amplitudes = one.acceleration.amplitudes
    above = amplitudes[plan.count :].max(initial=0.0) / amplitudes[0] if len(amplitudes) else math.nan
    return {"deviation": _number(one.deviation), "above": _number(float(above)), "failure": one.failure}


def verdict(plan: Plan, s: dict[str, Any]) -> tuple[str, str]:
    """The label, in lower case, and the whole sentence."""
    twists = _too_much_twist(s)
    if plan.enforced:
        peak = s["power"]["corrected"]["peak"]
        held = f"the drive holds the shaft at its speed whatever that takes, up to {_watts(peak)}: the law itself is the cam"
        return ("not clean", f"NOT CLEAN on the shaft that twists: {twists}; {held}") if twists else ("enforced", held)
    above, fluctuates = s["above"], f"fluctuates by {_percent(s['corrected']['fluctuation'])}"
    label, found = _on_rigid_shaft(s)
    shaft = f"on a shaft that {fluctuates}"
    if label == "clean" and twists:
        label, found, shaft = "not clean", twists, f"on the shaft that twists and {fluctuates}"
    before = f"the original one leaves {_percent(above['original'])} of order 1"
    return label, f"{label.upper()} {shaft}: {found}" + (f", {before}" if label == "clean" else "")


def _on_rigid_shaft(s: dict[str, Any]) -> tuple[str, str]:
    """The label of the corrected cam, and what it leaves."""
    above, orders = s["above"], f"orders above {s['above']['orders']}"
    clean, own = above["law"] + _CLEAN, _percent(above["law"])
    if not above["corrected"] <= clean:
        return "not clean", f"{orders} are {_percent(above['corrected'])} of order 1 with the corrected cam"
    left = f"nothing in {orders}" if above["law"] <= _CLEAN else f"{own} of order 1 in {orders} as the law itself"
    grows, simulated = s["left_after_a_turn"]["corrected"], s["simulation"] and s["simulation"]["corrected"]["above"]
    if grows is not None and grows > 1:
        unstable = f"but this motion is not stable, a disturbance grows {grows:.4g}-fold in a turn"
        return "not clean", f"the corrected cam would leave {left}, {unstable}"
    if simulated is not None and simulated > clean:
        return "not confirmed", f"by prediction the corrected cam leaves {left}, by simulation {_percent(simulated)} of order 1"
    return "clean", f"the corrected cam leaves {left}"


def _too_much_twist(s: dict[str, Any]) -> str:
    """What the corrected cam leaves behind a shaft that twists, empty where that does not matter."""
    if s["shaft"] is None:
        return ""
    twisted = {one["name"]: one["above"] for one in s["shaft"]}
    left = twisted.get(FOR_RIGID_SHAFT, math.inf)
    if left <= s["above"]["law"] + _TOO_MUCH:
        return ""
    found = f"the cam corrected for a rigid shaft leaves {_percent(left)} of order 1 in orders above {s['above']['orders']}"
    if FOR_RIGID_SHAFT not in twisted:
        found = "no periodic motion was found with the cam corrected for a rigid shaft"
    if FOR_TWIST not in twisted:
        return found
    rest = "nothing" if twisted[FOR_TWIST] <= _CLEAN else _percent(twisted[FOR_TWIST])
    return f"{found}, corrected for the twist too it leaves {rest}"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _watts(power: float) -> str:
    return f"{power / 1e3:.3g} kW" if abs(power) >= 1e3 else f"{power:.3g} W"


def warnings(plan: Plan, f: Findings, s: dict[str, Any]) -> list[str]:
    """What is to be warned of."""
    said = []
    ratio, contraction = s["inertia_ratio"], s["contraction"]
    shown = f"the inertia ratio J1 max psi'^2/J0 is {ratio:.3g}"
    if plan.enforced:
        pass
    elif ratio > _DIVERGING:
        diverging = "above about 1 cutting a cam and measuring again may diverge; take the predicted cam, or a larger flywheel"
        said.append(f"{shown}: {diverging}")
    elif ratio > _SLOW:
        each = "" if contraction is None else f", each cam leaves {_percent(contraction)} of what the one before left"
        said.append(f"{shown}: cutting a cam and measuring again converges slowly{each}; take the predicted cam")
    if f.failure:
        said.append(f.failure)
    elif contraction is not None and contraction >= 1:
        said.append("cutting a cam and measuring again diverges: the last cam is worse than the one before")
    for name, turning in (("original", f.original), ("corrected", f.corrected)):
        if (share := unresolved(turning.shaft)) > _UNRESOLVED:
            more = f"with the {name} cam the highest orders of the speed are {share:.1e} of its mean, and more are left out"
            said.append(f"{more}: the shaft nearly stands still within a turn, or the law's acceleration jumps")
    said += [_unstable(name, one) for name, one in (("original", f.original), ("corrected", f.corrected)) if one.left > 1]
    for name, one, turning in zip(("original", "corrected"), f.confirmed, (f.original, f.corrected), strict=False):
        if not one.deviation <= _DOUBTFUL:
            said.append(f"the simulation with the {name} cam {one.failure or _departs(one, turning)}")
    said += [] if f.vibrations is None else f.vibrations.notes
    return said + ([] if f.twists is None else _twisted(plan, f.clean, f.twists))


def _departs(one: Confirmation, turning: Turning) -> str:
    """By how much a simulation differs, and why, where that is known."""
    why = ""
    if turning.left > 1:
        why = ": this motion is not stable"
    elif unresolved(turning.shaft) > _UNRESOLVED:
        why = ", by the orders that the prediction leaves out"
    elif turning.left == 1:
        why = ": without a drive nothing brings the shaft back, and the errors of the simulation add up from turn to turn"
    return f"departs from the prediction by {_percent(one.deviation)} of the speed{why}"


def _twisted(plan: Plan, law: float, twists: Twists) -> list[str]:
    """law: what the law itself has above N, over order 1."""
    left = [one.above for one in twists.cams if one.name == FOR_RIGID_SHAFT and one.above > law + _TOO_MUCH]
    rigid = f"of orders above {plan.count} the cam for the rigid shaft, that of this result, leaves"
    return [*(f"the shaft twists: {rigid} {_percent(share)} of order 1" for share in left), *twists.notes]


def _unstable(name: str, one: Turning) -> str:
    grows = f"with the {name} cam this motion is not stable, a disturbance grows {one.left:.4g}-fold in a turn"
    return f"{grows}: drive less loads rise with the speed; give another mean_speed, or another drive or load"
