"""The summary of a prediction: its numbers, the verdict, and warnings."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from wucht.cams.correction import Deviation, compare_orders
from wucht.cams.prediction import unresolved_share
from wucht.cams.shaft_motion import ShaftMotion
from wucht.results.quantities import Quantity, group
from wucht.studies.cam_prediction.computation import Findings, Plan, ShaftPrediction
from wucht.studies.cam_prediction.confirmation import Confirmation
from wucht.studies.cam_prediction.elasticity import RIGID_SHAFT_CAM, TWIST_CAM, Twists

_CLEAN = 1e-6  # of order 1, and of the stroke: below the accuracy of a workshop
_SLOW, _DIVERGING = 0.5, 1.0  # inertia ratios
_ORDER_TOLERANCE = 1e-12  # of the mean speed: smaller orders are not corrected by a cam
_FLOOR = 1e-9  # residuals below are rounding
_TWIST_LIMIT = 1e-3  # of order 1: largest acceptable residual behind an elastic shaft
_UNRESOLVED_LIMIT = 1e-6  # of the mean speed: larger highest orders indicate that further ones are missing
_DEVIATION_LIMIT = 1e-5  # of the mean speed: prediction and simulation differ
_LEAST_SHARE, _SAME_MEAN = 0.5, 0.01  # of a record's fluctuation, and of its mean speed: with less, it is another motion


def _predictions(f: Findings) -> dict[str, ShaftPrediction]:
    return {"original": f.original_cam, "corrected": f.corrected_cam}


def prediction_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    """Return the numbers of ``summary.json``: the motion of the shaft with the original cam, which moves its output by the law
    over the cam angle, and under ``corrected`` that with the corrected one."""
    predictions = _predictions(f)
    constant, shaft, motion_law = _power(f.constant_speed_power), plan.shaft, plan.motion_law
    powers = {name: _power(one.drive * one.shaft.speed(f.tau)) for name, one in predictions.items()}
    original_quantities, corrected_quantities = (
        _shaft_quantities(one, powers[name]["mean"], f"{name} cam") for name, one in predictions.items()
    )
    corrected_quantities.append(
        Quantity("speed", _speed_coefficients(f.corrected_cam), "coefficients of the speed, corrected cam", "rad/s")
    )
    driven = "eigenmotion" if plan.driving is None else "enforced" if plan.is_enforced else "drive"
    above = {
        "orders": plan.purity.count,
        "reference_order": plan.purity.reference,
        "law": plan.purity.share(plan.purity.target),
    }
    above |= {name: one.deviation.orders for name, one in predictions.items()}
    position_errors = {name: one.deviation.position for name, one in predictions.items()}
    multipliers = {name: _finite_or_none(one.multiplier) for name, one in predictions.items()}
    saving = {key: constant[key] - powers["corrected"][key] for key in ("peak", "mean_positive")}
    ratio_limit = shaft.most_inertia_ratio(motion_law.function)
    return [
        Quantity("unit", motion_law.unit, "unit of the output"),
        Quantity("harmonics", motion_law.count, "number N of harmonics of the law"),
        Quantity(
            "inertia_ratio", shaft.inertia_ratio(motion_law.function), "largest inertia of the output over that of the shaft"
        ),
        Quantity("inertia_ratio_limit", ratio_limit, "largest inertia ratio with a corrected cam without a drive"),
        Quantity("driven", driven, "kind of drive of the shaft"),
        *original_quantities,
        group("corrected", corrected_quantities, "the same with the corrected cam"),
        Quantity("above", above, f"acceleration of the output: {plan.purity.name}"),
        Quantity("position_error", position_errors, "largest distance of the output from its law over time", motion_law.unit),
        Quantity("left_after_a_turn", multipliers, "share of a disturbance of the energy that remains after a turn"),
        Quantity("power", {"constant_speed": constant, **powers}, "power of the drive", "W"),
        Quantity("power_saved", saving, "power that the corrected cam saves against constant speed", "W"),
        Quantity("cut_residuals", f.cuts.tolist(), "the same of cams cut by measurement, one after another"),
        Quantity("contraction", _contraction(f.cuts), "ratio of the residual of each further cam to that before"),
        Quantity("simulation", _simulation(plan, f), "turns simulated, and the deviation of the speed from the prediction"),
        _record_group(plan, f),
        *_spring_quantities(plan, f),
    ]


def order_deviation_text(s: dict[str, Any]) -> str:
    """Return what a share is, see ``Purity.share``, in a line of the report that ends with the share."""
    count = s["above"]["orders"]
    return "orders off the law's by" if count is None else f"orders above {count}:"


def _record_group(plan: Plan, f: Findings) -> Quantity:
    description, record = "record of the speed beside the prediction", plan.record
    if record is None:
        return Quantity("record", None, description)
    shares = {name: _explained_share(record, one.shaft) for name, one in _predictions(f).items()}
    numbers = [
        Quantity("mean_speed", record.mean, "mean speed of the record", "rad/s"),
        Quantity("fluctuation", record.fluctuation, "its fluctuation as a share of its mean"),
        Quantity("speed_orders", record.speed.amplitudes.tolist(), "amplitudes of its orders", "rad/s"),
        Quantity("explained", shares, "share of its fluctuation that the prediction explains, at the phase that fits best"),
    ]
    return group("record", numbers, description)


def _explained_share(record: ShaftMotion, prediction: ShaftMotion) -> float:
    """Return the share of the mean square of a record's fluctuation that a prediction explains, at the best phase."""
    is_even = not record.speed.amplitudes.any()
    return 0.0 if is_even else compare_orders(record.speed, prediction.speed).best_delay[1]


def _shaft_quantities(one: ShaftPrediction, mean_power: float, cam: str) -> list[Quantity]:
    shaft = one.shaft
    orders = shaft.speed.without_rounding(_ORDER_TOLERANCE).amplitudes.tolist()
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


def _spring_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    """Return the elastic output and shaft, each None where it is rigid."""
    output, twists, acceleration = Quantity("output", None, "elastic output"), None, f"{plan.motion_law.unit}/s^2"
    if f.vibrations is not None and plan.output is not None:
        excitations = [asdict(e) for e in f.vibrations.excitations]
        of_excited = {
            "deviation": ("deviation in the dwell", plan.motion_law.unit),
            "acceleration": ("acceleration in the dwell", acceleration),
            "peak": ("largest acceleration of the output", acceleration),
        }
        numbers_of_output = [
            Quantity("natural_frequency", plan.output.natural_frequency, "natural frequency", "rad/s"),
            Quantity("damping_ratio", plan.output.damping_ratio, "damping ratio"),
            Quantity("excited", excitations, "residual vibration in the dwell by each motion of the lever", parts=of_excited),
        ]
        output = group("output", numbers_of_output, output.long_name)
    if f.twists is not None:
        twists = [asdict(c) for c in f.twists.cams]
    of_shaft = {
        "above": (plan.purity.name, ""),
        "torque": ("largest torque in the shaft", "N m"),
        "twist": ("largest twist", "rad"),
    }
    return [output, Quantity("shaft", twists, "elastic shaft, each cam", parts=of_shaft)]


def _speed_coefficients(one: ShaftPrediction) -> dict[str, Any]:
    """Return the speed with the corrected cam in the form of the table [speed] of cam-correction and cam-contour."""
    speed = one.shaft.speed.without_rounding(_ORDER_TOLERANCE)
    return {"mean": speed.mean, "cosine": speed.cosine.tolist(), "sine": speed.sine.tolist()}


def _power(power: np.ndarray) -> dict[str, float]:
    """Return peak, mean, and mean of the positive part over a turn of evenly spaced points, the last equal to the first."""
    samples = power[:-1]
    return {
        "peak": float(samples.max()),
        "mean": float(samples.mean()),
        "mean_positive": float(np.maximum(samples, 0.0).mean()),
    }


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _contraction(cuts: np.ndarray) -> float | None:
    """Return the ratio of the last two residuals of cams cut one after the other that exceed rounding."""
    above = cuts[cuts > _FLOOR]
    return float(above[-1] / above[-2]) if len(above) > 1 else None


def _simulation(plan: Plan, f: Findings) -> dict[str, Any] | None:
    pairs = zip(("original", "corrected"), f.confirmations, strict=False)
    return {"turns": plan.turns, **{name: _confirmation_numbers(plan, one) for name, one in pairs}} if f.confirmations else None


def _confirmation_numbers(plan: Plan, one: Confirmation) -> dict[str, float | str | None]:
    above = math.nan if one.failure else plan.purity.share(one.acceleration)
    return {"deviation": _finite_or_none(one.deviation), "above": _finite_or_none(above), "failure": one.failure}


def verdict(plan: Plan, s: dict[str, Any]) -> tuple[str, str]:
    """Return the label, in lower case, and the whole sentence."""
    twists = _twist_finding(s)
    if plan.is_enforced:
        peak = s["power"]["corrected"]["peak"]
        drive_clause = f"the drive holds the shaft's speed with up to {_power_text(peak)}: the law itself is the cam"
        return (
            ("not clean", f"NOT CLEAN on the elastic shaft: {twists}; {drive_clause}") if twists else ("enforced", drive_clause)
        )
    above, fluctuates = s["above"], f"fluctuates by {_percent_text(s['corrected']['fluctuation'])}"
    label, finding = _rigid_shaft_verdict(plan, s)
    shaft = f"on a shaft that {fluctuates}"
    if label == "clean" and twists:
        label, finding, shaft = "not clean", twists, f"on the elastic shaft that {fluctuates}"
    before = f"the original one leaves {_brief_share_text(s, above['original'])}"
    return label, f"{label.upper()} {shaft}: {finding}" + (f", {before}" if label == "clean" else "")


def _rigid_shaft_verdict(plan: Plan, s: dict[str, Any]) -> tuple[str, str]:
    """Return the label of the corrected cam, and its residual."""
    above, error = s["above"]["corrected"], s["position_error"]["corrected"]
    if not plan.purity.is_clean(Deviation(above, error), _CLEAN):
        off = f", its position is off by {_percent_text(error / plan.purity.stroke)} of the stroke"
        return "not clean", f"the corrected cam leaves {_order_share_text(s, above)}{off}"
    grows, simulated_share = s["left_after_a_turn"]["corrected"], s["simulation"] and s["simulation"]["corrected"]["above"]
    if grows is not None and grows > 1:
        unstable = f"but this motion is not stable: a disturbance grows {grows:.4g}-fold in a turn"
        return "not clean", f"the corrected cam would leave {_order_share_text(s, 0.0)}, {unstable}"
    if simulated_share is not None and simulated_share > _CLEAN:
        simulation = f"by simulation {_brief_share_text(s, simulated_share)}"
        return "not confirmed", f"by prediction the corrected cam leaves {_order_share_text(s, 0.0)}, {simulation}"
    return "clean", f"the corrected cam leaves {_order_share_text(s, 0.0)}"


def _brief_share_text(s: dict[str, Any], share: float) -> str:
    """Return the same where the measure has been named."""
    off = "orders off by up to " if s["above"]["orders"] is None else ""
    return f"{off}{_percent_text(share)} of order {s['above']['reference_order']}"


def _order_share_text(s: dict[str, Any], share: float) -> str:
    """Return what a cam leaves by the measure, in words: 1.2 % of order 1 in orders above 5, or orders off the law's."""
    above, share_text = s["above"], f"{_percent_text(share)} of order {s['above']['reference_order']}"
    if above["orders"] is None:
        return f"orders off the law's by up to {share_text}" if share > _CLEAN else "no order off the law's"
    return f"{share_text if share > _CLEAN else 'nothing'} in orders above {above['orders']}"


def _twist_finding(s: dict[str, Any]) -> str:
    """Return the residual of the corrected cam behind an elastic shaft in a sentence, empty where it does not matter."""
    if s["shaft"] is None:
        return ""
    residuals = {one["name"]: one["above"] for one in s["shaft"]}
    residual = residuals.get(RIGID_SHAFT_CAM, math.inf)
    if residual <= _TWIST_LIMIT:
        return ""
    finding = f"the cam corrected for a rigid shaft leaves {_order_share_text(s, residual)}"
    if RIGID_SHAFT_CAM not in residuals:
        finding = "no periodic motion was obtained with the cam corrected for a rigid shaft"
    if TWIST_CAM not in residuals:
        return finding
    rest = "nothing" if residuals[TWIST_CAM] <= _CLEAN else _percent_text(residuals[TWIST_CAM])
    return f"{finding}, corrected for the twist too it leaves {rest}"


def _percent_text(share: float) -> str:
    return f"{100 * share:.3g} %"


def _power_text(power: float) -> str:
    return f"{power / 1e3:.3g} kW" if abs(power) >= 1e3 else f"{power:.3g} W"


def warnings(plan: Plan, f: Findings, s: dict[str, Any]) -> list[str]:
    """Return the warnings."""
    notes = []
    ratio, contraction = s["inertia_ratio"], s["contraction"]
    ratio_clause = f"the inertia ratio J1 max psi'^2/J0 is {ratio:.3g}"
    if plan.is_enforced:
        pass
    elif ratio > _DIVERGING:
        diverging = "above about 1 cutting a cam and measuring again may diverge; take the predicted cam, or a larger flywheel"
        notes.append(f"{ratio_clause}: {diverging}")
    elif ratio > _SLOW:
        rate_clause = (
            "" if contraction is None else f", each cam leaves {_percent_text(contraction)} of the residual of the one before"
        )
        notes.append(f"{ratio_clause}: cutting a cam and measuring again converges slowly{rate_clause}; take the predicted cam")
    if f.failure:
        notes.append(f.failure)
    elif contraction is not None and contraction >= 1:
        notes.append("cutting a cam and measuring again diverges: the last cam is worse than the one before")
    for name, turning in (("original", f.original_cam), ("corrected", f.corrected_cam)):
        if (share := unresolved_share(turning.shaft)) > _UNRESOLVED_LIMIT:
            order_clause = (
                f"with the {name} cam the highest orders of the speed are {share:.1e} of its mean, and higher ones are left out"
            )
            notes.append(f"{order_clause}: the shaft nearly stands still within a turn, or the law's acceleration jumps")
    notes += [
        _instability_warning(name, one)
        for name, one in (("original", f.original_cam), ("corrected", f.corrected_cam))
        if one.multiplier > 1
    ]
    for name, one, turning in zip(("original", "corrected"), f.confirmations, (f.original_cam, f.corrected_cam), strict=False):
        if not one.deviation <= _DEVIATION_LIMIT:
            notes.append(f"the simulation with the {name} cam {one.failure or _departure_text(one, turning)}")
    notes += [] if f.vibrations is None else f.vibrations.notes
    notes += _record_warnings(s)
    return notes + ([] if f.twists is None else _twist_warnings(s, f.twists))


def _departure_text(one: Confirmation, turning: ShaftPrediction) -> str:
    """Return the deviation of a simulation, with the reason where it is known."""
    reason = ""
    if turning.multiplier > 1:
        reason = ": this motion is not stable"
    elif unresolved_share(turning.shaft) > _UNRESOLVED_LIMIT:
        reason = ", by the orders that the prediction leaves out"
    elif turning.multiplier == 1:
        reason = ": without a drive nothing restores the motion, and errors of the simulation add up from turn to turn"
    return f"departs from the prediction by {_percent_text(one.deviation)} of the speed{reason}"


def _record_warnings(s: dict[str, Any]) -> list[str]:
    """Return a warning where the record of the speed is not that of the prediction with either cam."""
    if (record := s["record"]) is None:
        return []
    (name, share), mean = max(record["explained"].items(), key=lambda one: one[1]), record["mean_speed"]
    prediction = s if name == "original" else s["corrected"]
    if share >= _LEAST_SHARE and abs(prediction["mean_speed"] / mean - 1) <= _SAME_MEAN:
        return []
    record_clause = (
        f"the record of the speed has a mean of {mean:.4g} rad/s and fluctuates by {_percent_text(record['fluctuation'])}"
    )
    prediction_clause = f"{prediction['mean_speed']:.4g} rad/s and {_percent_text(prediction['fluctuation'])}"
    return [
        f"{record_clause}, the prediction with the {name} cam has {prediction_clause}: check the inertias, the drive and the "
        "loads of [shaft], or correct the cam for the measured speed by cam-correction"
    ]


def _twist_warnings(s: dict[str, Any], twists: Twists) -> list[str]:
    """Return the warnings on an elastic shaft."""
    residuals = [one.above for one in twists.cams if one.name == RIGID_SHAFT_CAM and one.above > _TWIST_LIMIT]
    rigid = "elastic shaft: the cam for the rigid shaft, that of this result, leaves"
    return [*(f"{rigid} {_order_share_text(s, share)}" for share in residuals), *twists.notes]


def _instability_warning(name: str, one: ShaftPrediction) -> str:
    grows = f"with the {name} cam this motion is not stable: a disturbance grows {one.multiplier:.4g}-fold in a turn"
    return f"{grows}, because drive less loads rises with the speed; give another mean_speed, or another drive or load"
