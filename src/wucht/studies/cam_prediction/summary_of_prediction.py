"""The summary of a prediction: its numbers, the verdict, and warnings."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from wucht.cams.prediction import unresolved
from wucht.results.quantities import Quantity, group
from wucht.studies.cam_prediction.computation import Findings, Plan, Turning
from wucht.studies.cam_prediction.confirmation import Confirmation
from wucht.studies.cam_prediction.elasticity import FOR_RIGID_SHAFT, FOR_TWIST, Twists

_CLEAN = 1e-6  # of order 1, beyond the law itself: below the accuracy of a workshop
_SLOW, _DIVERGING = 0.5, 1.0  # inertia ratios
_KEPT = 1e-12  # of the mean speed: smaller orders are not corrected by a cam
_FLOOR = 1e-9  # residuals below are rounding
_TOO_MUCH = 1e-3  # of order 1: largest acceptable residual behind an elastic shaft
_UNRESOLVED = 1e-6  # of the mean speed: larger highest orders indicate that further ones are missing
_DOUBTFUL = 1e-5  # of the mean speed: prediction and simulation differ


def numbers(plan: Plan, f: Findings) -> list[Quantity]:
    """Return the numbers of ``summary.json``: the motion of the shaft with the original cam, which moves its output by the law
    over the cam angle, and under ``corrected`` that with the corrected one."""
    both = {"original": f.original, "corrected": f.corrected}
    constant, shaft, motion = _power(f.constant), plan.shaft, plan.motion
    powers = {name: _power(one.drive * one.shaft.speed(f.tau)) for name, one in both.items()}
    original, corrected = (_turning(one, powers[name]["mean"], f"{name} cam") for name, one in both.items())
    corrected.append(Quantity("speed", _coefficients(f.corrected), "coefficients of the speed, corrected cam", "rad/s"))
    driven = "eigenmotion" if plan.driving is None else "enforced" if plan.enforced else "drive"
    above = {"orders": plan.count, "law": f.clean, **{name: one.above for name, one in both.items()}}
    left = {name: _number(one.left) for name, one in both.items()}
    saved = {key: constant[key] - powers["corrected"][key] for key in ("peak", "mean_positive")}
    most = shaft.most_inertia_ratio(motion.law)
    return [
        Quantity("unit", motion.unit, "unit of the output"),
        Quantity("harmonics", motion.count, "number N of harmonics of the law"),
        Quantity("inertia_ratio", shaft.inertia_ratio(motion.law), "largest inertia of the output over that of the shaft"),
        Quantity("inertia_ratio_limit", most, "largest inertia ratio with a corrected cam without a drive"),
        Quantity("driven", driven, "kind of drive of the shaft"),
        *original,
        group("corrected", corrected, "the same with the corrected cam"),
        Quantity("above", above, "largest order of the output's acceleration above N over order 1"),
        Quantity("left_after_a_turn", left, "share of a disturbance of the energy that remains after a turn"),
        Quantity("power", {"constant_speed": constant, **powers}, "power of the drive", "W"),
        Quantity("power_saved", saved, "power that the corrected cam saves against constant speed", "W"),
        Quantity("cut_residuals", f.cuts.tolist(), "residual above N of cams cut by measurement, one after another"),
        Quantity("contraction", _contraction(f.cuts, f.clean), "ratio of the residual of each further cam to that before"),
        Quantity("simulation", _simulation(plan, f), "turns simulated, and the deviation of the speed from the prediction"),
        *_springs(plan, f),
    ]


def _turning(one: Turning, mean_power: float, cam: str) -> list[Quantity]:
    shaft = one.shaft
    orders = shaft.speed.without_rounding(_KEPT).amplitudes.tolist()
    eigenmotion = None if one.eigenmotion is None else asdict(one.eigenmotion)
    fluctuation, free = _EIGENMOTION["fluctuation"][0], "motion at this mean speed without drive and loads"
    return [
        Quantity("mean_speed", shaft.mean, f"mean speed of the shaft, {cam}", "rad/s"),
        Quantity("fluctuation", shaft.fluctuation, f"{fluctuation}, {cam}", headline=True),
        Quantity("speed_orders", orders, f"amplitudes of the speed, {cam}", "rad/s"),
        Quantity("mean_power", mean_power, f"mean power of the drive, {cam}", "W", headline=True),
        Quantity("eigenmotion", eigenmotion, free, parts=_EIGENMOTION),
    ]


_EIGENMOTION = {
    "mean_speed": ("mean speed of the shaft", "rad/s"),
    "fluctuation": ("fluctuation of the speed as a share of its mean", ""),
    "period": ("period of a turn", "s"),
    "energy": ("energy of the motion", "J"),
}


def _springs(plan: Plan, f: Findings) -> list[Quantity]:
    """Return the elastic output and shaft, each None where it is rigid."""
    output, twists, acceleration = Quantity("output", None, "elastic output"), None, f"{plan.motion.unit}/s^2"
    if f.vibrations is not None and plan.output is not None:
        excited = [asdict(e) for e in f.vibrations.excited]
        of_excited = {
            "deviation": ("deviation in the dwell", plan.motion.unit),
            "acceleration": ("acceleration in the dwell", acceleration),
            "peak": ("largest acceleration of the output", acceleration),
        }
        numbers_of_output = [
            Quantity("natural_frequency", plan.output.natural_frequency, "natural frequency", "rad/s"),
            Quantity("damping_ratio", plan.output.damping_ratio, "damping ratio"),
            Quantity("excited", excited, "residual vibration in the dwell by each motion of the lever", parts=of_excited),
        ]
        output = group("output", numbers_of_output, output.what)
    if f.twists is not None:
        twists = [asdict(c) for c in f.twists.cams]
    of_shaft = {
        "above": ("largest order above N over order 1", ""),
        "torque": ("largest torque in the shaft", "N m"),
        "twist": ("largest twist", "rad"),
    }
    return [output, Quantity("shaft", twists, "elastic shaft, each cam", parts=of_shaft)]


def _coefficients(one: Turning) -> dict[str, Any]:
    """Return the speed with the corrected cam in the form of the table [speed] of cam-correction and cam-contour."""
    kept = one.shaft.speed.without_rounding(_KEPT)
    return {"mean": kept.mean, "cosine": kept.cosine.tolist(), "sine": kept.sine.tolist()}


def _power(power: np.ndarray) -> dict[str, float]:
    """Return peak, mean, and mean of the positive part over a turn of evenly spaced points, the last equal to the first."""
    each = power[:-1]
    return {"peak": float(each.max()), "mean": float(each.mean()), "mean_positive": float(np.maximum(each, 0.0).mean())}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _contraction(cuts: np.ndarray, clean: float) -> float | None:
    """Return the ratio of the last two residuals of cams cut one after the other that exceed rounding."""
    above = cuts[cuts > _FLOOR + 2 * clean]
    return float(above[-1] / above[-2]) if len(above) > 1 else None


def _simulation(plan: Plan, f: Findings) -> dict[str, Any] | None:
    named = zip(("original", "corrected"), f.confirmed, strict=False)
    return {"turns": plan.turns, **{name: _confirmed(plan, one) for name, one in named}} if f.confirmed else None


def _confirmed(plan: Plan, one: Confirmation) -> dict[str, float | str | None]:
    amplitudes = one.acceleration.amplitudes
    above = amplitudes[plan.count :].max(initial=0.0) / amplitudes[0] if len(amplitudes) else math.nan
    return {"deviation": _number(one.deviation), "above": _number(float(above)), "failure": one.failure}


def verdict(plan: Plan, s: dict[str, Any]) -> tuple[str, str]:
    """Return the label, in lower case, and the whole sentence."""
    twists = _too_much_twist(s)
    if plan.enforced:
        peak = s["power"]["corrected"]["peak"]
        held = f"the drive holds the shaft's speed with up to {_watts(peak)}: the law itself is the cam"
        return ("not clean", f"NOT CLEAN on the elastic shaft: {twists}; {held}") if twists else ("enforced", held)
    above, fluctuates = s["above"], f"fluctuates by {_percent(s['corrected']['fluctuation'])}"
    label, found = _on_rigid_shaft(s)
    shaft = f"on a shaft that {fluctuates}"
    if label == "clean" and twists:
        label, found, shaft = "not clean", twists, f"on the elastic shaft that {fluctuates}"
    before = f"the original one leaves {_percent(above['original'])} of order 1"
    return label, f"{label.upper()} {shaft}: {found}" + (f", {before}" if label == "clean" else "")


def _on_rigid_shaft(s: dict[str, Any]) -> tuple[str, str]:
    """Return the label of the corrected cam, and its residual."""
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
    """Return the residual of the corrected cam behind an elastic shaft in a sentence, empty where it does not matter."""
    if s["shaft"] is None:
        return ""
    twisted = {one["name"]: one["above"] for one in s["shaft"]}
    left = twisted.get(FOR_RIGID_SHAFT, math.inf)
    if left <= s["above"]["law"] + _TOO_MUCH:
        return ""
    found = f"the cam corrected for a rigid shaft leaves {_percent(left)} of order 1 in orders above {s['above']['orders']}"
    if FOR_RIGID_SHAFT not in twisted:
        found = "no periodic motion was obtained with the cam corrected for a rigid shaft"
    if FOR_TWIST not in twisted:
        return found
    rest = "nothing" if twisted[FOR_TWIST] <= _CLEAN else _percent(twisted[FOR_TWIST])
    return f"{found}, corrected for the twist too it leaves {rest}"


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def _watts(power: float) -> str:
    return f"{power / 1e3:.3g} kW" if abs(power) >= 1e3 else f"{power:.3g} W"


def warnings(plan: Plan, f: Findings, s: dict[str, Any]) -> list[str]:
    """Return the warnings."""
    said = []
    ratio, contraction = s["inertia_ratio"], s["contraction"]
    shown = f"the inertia ratio J1 max psi'^2/J0 is {ratio:.3g}"
    if plan.enforced:
        pass
    elif ratio > _DIVERGING:
        diverging = "above about 1 cutting a cam and measuring again may diverge; take the predicted cam, or a larger flywheel"
        said.append(f"{shown}: {diverging}")
    elif ratio > _SLOW:
        each = "" if contraction is None else f", each cam leaves {_percent(contraction)} of the residual of the one before"
        said.append(f"{shown}: cutting a cam and measuring again converges slowly{each}; take the predicted cam")
    if f.failure:
        said.append(f.failure)
    elif contraction is not None and contraction >= 1:
        said.append("cutting a cam and measuring again diverges: the last cam is worse than the one before")
    for name, turning in (("original", f.original), ("corrected", f.corrected)):
        if (share := unresolved(turning.shaft)) > _UNRESOLVED:
            more = f"with the {name} cam the highest orders of the speed are {share:.1e} of its mean, higher ones are left out"
            said.append(f"{more}: the shaft nearly stands still within a turn, or the law's acceleration jumps")
    said += [_unstable(name, one) for name, one in (("original", f.original), ("corrected", f.corrected)) if one.left > 1]
    for name, one, turning in zip(("original", "corrected"), f.confirmed, (f.original, f.corrected), strict=False):
        if not one.deviation <= _DOUBTFUL:
            said.append(f"the simulation with the {name} cam {one.failure or _departs(one, turning)}")
    said += [] if f.vibrations is None else f.vibrations.notes
    return said + ([] if f.twists is None else _twisted(plan, f.clean, f.twists))


def _departs(one: Confirmation, turning: Turning) -> str:
    """Return the deviation of a simulation, with the reason where it is known."""
    why = ""
    if turning.left > 1:
        why = ": this motion is not stable"
    elif unresolved(turning.shaft) > _UNRESOLVED:
        why = ", by the orders that the prediction leaves out"
    elif turning.left == 1:
        why = ": without a drive nothing restores the motion, and errors of the simulation add up from turn to turn"
    return f"departs from the prediction by {_percent(one.deviation)} of the speed{why}"


def _twisted(plan: Plan, law: float, twists: Twists) -> list[str]:
    """Return the warnings on an elastic shaft. law: orders of the law itself above N, over order 1."""
    left = [one.above for one in twists.cams if one.name == FOR_RIGID_SHAFT and one.above > law + _TOO_MUCH]
    rigid = f"in orders above {plan.count} the cam for the rigid shaft, that of this result, leaves"
    return [*(f"elastic shaft: {rigid} {_percent(share)} of order 1" for share in left), *twists.notes]


def _unstable(name: str, one: Turning) -> str:
    grows = f"with the {name} cam this motion is not stable, a disturbance grows {one.left:.4g}-fold in a turn"
    return f"{grows}: drive less loads rise with the speed; give another mean_speed, or another drive or load"
