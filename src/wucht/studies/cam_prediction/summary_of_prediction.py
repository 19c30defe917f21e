"""The answer of a prediction: its numbers, the verdict, and what is to be warned of."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from wucht.cams.prediction import unresolved
from wucht.studies.cam_prediction.confirmation import Confirmation
from wucht.studies.cam_prediction.elasticity import Twists
from wucht.studies.cam_prediction.prepare import Plan
from wucht.studies.cam_prediction.run import Findings, Turning

_CLEAN = 1e-6  # of order 1, beside what the law itself has: below what a workshop can mill
_SLOW, _DIVERGING = 0.5, 1.0  # inertia ratios
_KEPT = 1e-12  # of the mean speed: orders that a cam is made for
_FLOOR = 1e-9  # residuals below are rounding
_TOO_MUCH = 1e-3  # of order 1: what an elastic shaft leaves
_UNRESOLVED = 1e-6  # of the mean speed: orders beyond which more must be
_DOUBTFUL = 1e-5  # of the mean speed: prediction and simulation differ


def summary(plan: Plan, f: Findings) -> dict[str, Any]:
    """The numbers of ``summary.json``: how the shaft turns with the original cam, which moves its output by the law over the
    cam angle, and under ``corrected`` how with the corrected one; inertia_ratio; power; cut_residuals; simulation."""
    both = {"original": f.original, "corrected": f.corrected}
    constant = _power(f.constant)
    powers = {name: _power(one.drive * one.shaft.speed(f.tau)) for name, one in both.items()}
    found: dict[str, Any] = {
        "unit": plan.motion.unit,
        "harmonics": plan.motion.count,
        "inertia_ratio": plan.shaft.inertia_ratio(plan.motion.law),
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


def _confirmed(plan: Plan, one: Confirmation) -> dict[str, float | None]:
    amplitudes = one.acceleration.amplitudes
    above = amplitudes[plan.count :].max(initial=0.0) / amplitudes[0] if len(amplitudes) else math.nan
    return {"deviation": _number(one.deviation), "above": _number(float(above))}


def sentence(plan: Plan, s: dict[str, Any]) -> str:
    """The verdict."""
    if plan.enforced:
        peak = s["power"]["corrected"]["peak"]
        return f"the drive holds the shaft at its speed whatever that takes, up to {_watts(peak)}: the law itself is the cam"
    above, orders = s["above"], f"orders above {s['above']['orders']}"
    simulated = s["simulation"] and s["simulation"]["corrected"]["above"]
    left = above["corrected"] if simulated is None else max(simulated, above["corrected"])
    shaft = f"on a shaft that fluctuates by {_percent(s['corrected']['fluctuation'])}"
    if not left <= above["law"] + _CLEAN:
        return f"NOT CLEAN {shaft}: {orders} are {_percent(left)} of order 1 with the corrected cam"
    before = f"the original one leaves {_percent(above['original'])} of order 1"
    if above["law"] > _CLEAN:
        own = f"{orders} are at {_percent(above['law'])} of order 1 with the corrected cam, as in the law"
        return f"CLEAN {shaft}: {own}; with the original one {_percent(above['original'])}"
    return f"CLEAN {shaft}: the corrected cam leaves nothing in {orders}, {before}"


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
        said.append(f"{shown}: above about 1 cutting a cam and measuring again may diverge; a larger flywheel is needed")
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
    for name, one in zip(("original", "corrected"), f.confirmed, strict=False):
        if not one.deviation <= _DOUBTFUL:
            off = (
                "fails"
                if math.isnan(one.deviation)
                else f"departs from the prediction by {_percent(one.deviation)} of the speed"
            )
            said.append(f"the simulation with the {name} cam {off}")
    said += [] if f.vibrations is None else f.vibrations.notes
    return said + ([] if f.twists is None else _twisted(plan, f.twists))


def _twisted(plan: Plan, twists: Twists) -> list[str]:
    left = [one.above for one in twists.cams if one.name == "corrected cam" and one.above > _TOO_MUCH]
    orders = f"orders above {plan.count}"
    shown = [f"the shaft twists: of {orders} the cam for the rigid shaft leaves {_percent(share)} of order 1" for share in left]
    return shown + ([twists.note] if twists.note else [])


def _unstable(name: str, one: Turning) -> str:
    grows = f"with the {name} cam this motion is not stable, a disturbance grows {one.left:.4g}-fold in a turn"
    return f"{grows}: drive less loads rise with the speed; give another mean_speed, or another drive or load"
