"""What is stated of a prediction: both motions of the shaft, power, cuts, the simulation, and springs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict

import numpy as np

from wucht.cams.confirmation import Confirmation
from wucht.cams.correction import MotionOverTime, Purity, best_delay
from wucht.cams.driven_camshaft import DrivenCamshaft, ShaftPrediction
from wucht.cams.elastic_output import ElasticOutput
from wucht.cams.elasticity import Twist, Vibrations
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import even_angles
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import distance_text, pad_orders, watts_text

_ORDER_TOLERANCE = 1e-12  # of the mean speed: smaller orders are not corrected by a cam
_FLOOR = 1e-9  # residuals below are rounding
_SIMULATED_TIMES = 36  # times of a turn at which the simulated speed is stored
_BEST = 3  # motions of the elastic output that are listed

Predictions = Mapping[str, ShaftPrediction]


def state_motions(
    a: Answer, predictions: Predictions, tau: np.ndarray, constant_power: np.ndarray, unit: str, shown_count: int
) -> None:
    """State both motions over time, what the drive gives, and the orders of the output."""
    a.curve("tau", tau, "time of a turn as an angle", "rad")
    a.curve("cam_angle", tau, "cam angle", "rad")
    a.curve("cam", list(predictions), "cam")
    a.curve("order", np.arange(1, shown_count + 1), "order")
    speed = np.array([one.shaft.speed(tau) for one in predictions.values()])
    torque = np.array([one.drive for one in predictions.values()])
    a.curve("speed", speed, "speed of the shaft", "rad/s", "cam tau")
    a.curve("drive_torque", torque, "torque of the drive", "N m", "cam tau")
    a.curve("drive_power", torque * speed, "power of the drive", "W", "cam tau")
    a.curve("power_at_constant_speed", constant_power, "power at constant speed", "W", "tau")
    amplitudes = [one.acceleration.amplitudes[:shown_count] for one in predictions.values()]
    a.curve("output_acceleration", amplitudes, "acceleration of the output, amplitude", f"{unit}/s^2", "cam order")


_EIGENMOTION = {
    "mean_speed": ("mean speed of the shaft", "rad/s"),
    "fluctuation": ("fluctuation of the speed as a share of its mean", ""),
    "period": ("period of a turn", "s"),
    "energy": ("energy of the motion", "J"),
}


def state_shafts(a: Answer, camshaft: DrivenCamshaft, predictions: Predictions, powers: Mapping[str, dict[str, float]]) -> None:
    """State the motion of the shaft with the original cam, which moves its output by the law over the cam angle, and under
    ``corrected`` that with the corrected one."""
    shaft, purity = camshaft.shaft, camshaft.purity
    ratio = a.number("inertia_ratio", shaft.inertia_ratio(camshaft.law), "largest inertia of the output over that of the shaft")
    what = "largest inertia ratio with a corrected cam without a drive"
    ratio_limit = a.number("inertia_ratio_limit", shaft.most_inertia_ratio(camshaft.law), what)
    driven = "eigenmotion" if camshaft.driving is None else "enforced" if camshaft.is_enforced else "drive"
    a.number("driven", driven, "kind of drive of the shaft")
    limit = "" if camshaft.is_enforced else f"; without a drive there is a corrected cam up to {ratio_limit:.3g}"
    a.line("inertia", f"of the output at most {ratio:.3g} of the shaft's{limit}")
    original, corrected = predictions.values()
    _state_shaft(a, purity, "original", original, powers)
    with a.group("corrected", "the same with the corrected cam"):
        _state_shaft(a, purity, "corrected", corrected, powers)
        speed = corrected.shaft.speed.without_rounding(_ORDER_TOLERANCE).to_table()  # as in the table [speed]
        a.number("speed", speed, "coefficients of the speed, corrected cam", "rad/s")
    above = {"orders": purity.count, "reference_order": purity.reference, "law": purity.share(purity.target)}
    above |= {name: one.deviation.orders for name, one in predictions.items()}
    a.number("above", above, f"acceleration of the output: {purity.name}")
    multipliers = {name: _finite_or_none(one.multiplier) for name, one in predictions.items()}
    a.number("left_after_a_turn", multipliers, "share of a disturbance of the energy that remains after a turn")


def _state_shaft(a: Answer, purity: Purity, name: str, one: ShaftPrediction, powers: Mapping[str, dict[str, float]]) -> None:
    shaft, cam = one.shaft, f"{name} cam"
    fluctuation = _EIGENMOTION["fluctuation"][0]
    a.number("mean_speed", shaft.mean, f"mean speed of the shaft, {cam}", "rad/s")
    a.number("fluctuation", shaft.fluctuation, f"{fluctuation}, {cam}", headline=True)
    orders = shaft.speed.without_rounding(_ORDER_TOLERANCE).amplitudes.tolist()
    a.number("speed_orders", orders, f"amplitudes of the speed, {cam}", "rad/s")
    a.number("mean_power", powers[name]["mean"], f"mean power of the drive, {cam}", "W", headline=True)
    eigenmotion: dict[str, float | None] | None = None
    if one.eigenmotion is not None:
        eigenmotion = {"mean_speed": shaft.mean, "period": 2 * math.pi / shaft.mean, "energy": one.energy}
        eigenmotion["fluctuation"] = one.eigenmotion.fluctuation
    a.number("eigenmotion", eigenmotion, "motion at this mean speed without drive and loads", parts=_EIGENMOTION)
    residual = f"{_orders_text(purity)} {_share_text(one.deviation.orders)} of order {purity.reference}"
    a.line(name, f"{{mean_speed}}, fluctuating by {_share_text(shaft.fluctuation)}; {residual}")


def _orders_text(purity: Purity) -> str:
    """Return what a share is, see ``Purity.share``, in a line of the report that ends with the share."""
    return "orders off the law's by" if purity.count is None else f"orders above {purity.count}:"


def _finite_or_none(value: float) -> float | None:
    return value if math.isfinite(value) else None


def state_output_motions(
    a: Answer, predictions: Predictions, cams: Sequence[Law], tau: np.ndarray, unit: str, stroke: float
) -> None:
    """State the output's acceleration over time with each cam, of which the first is the law, and how far it is off the law."""
    per, over = f"{unit}/s^2", "cam tau"
    motions = [MotionOverTime(cam, one.shaft) for cam, one in zip(cams, predictions.values(), strict=True)]
    accelerations = [motion.shaft.mean**2 * motion(tau, 2) for motion in motions]
    a.curve("acceleration_over_time", accelerations, "acceleration of the output over time", per, over)
    a.curve("position_error", [motion(tau) - cams[0](tau) for motion in motions], "output less its law over time", unit, over)
    peaks = {name: float(np.abs(values).max()) for name, values in zip(predictions, accelerations, strict=True)}
    a.number("peak_acceleration", peaks, "largest acceleration of the output", per)
    a.line("acceleration", "at most {peak_acceleration.corrected}; with the original cam {peak_acceleration.original}")
    errors = {name: one.deviation.position for name, one in predictions.items()}
    a.number("position_error", errors, "largest distance of the output from its law over time", unit)
    rms = {name: one.deviation.rms for name, one in predictions.items()}
    a.number("position_error_rms", rms, "root mean square of this distance over time", unit)
    texts = {
        name: " (rms ".join(distance_text(one, unit, stroke) for one in (error, rms[name])) + ")"
        for name, error in errors.items()
    }
    a.line("position", f"off the law by at most {texts['corrected']}; with the original cam by {texts['original']}")


def state_speed_record(a: Answer, record: ShaftMotion | None, predictions: Predictions, tau: np.ndarray) -> dict[str, float]:
    """State the record of the speed beside the prediction. Returns the share of its fluctuation that each cam explains."""
    what = "record of the speed beside the prediction"
    if record is None:
        a.number("record", None, what)
        return {}
    a.curve("measured_speed", record.speed(tau), "measured speed of the shaft, orders fitted", "rad/s", "tau")
    is_even = not record.speed.amplitudes.any()
    shares = {name: 0.0 if is_even else best_delay(record.speed, one.shaft.speed)[1] for name, one in predictions.items()}
    with a.group("record", what):
        a.number("mean_speed", record.mean, "mean speed of the record", "rad/s")
        a.number("fluctuation", record.fluctuation, "its fluctuation as a share of its mean")
        a.number("speed_orders", record.speed.amplitudes.tolist(), "amplitudes of its orders", "rad/s")
        of_phase = "share of its fluctuation that the prediction explains, at the phase that fits best"
        a.number("explained", shares, of_phase)
        texts = ", ".join(f"the {name} cam {_share_text(max(share, 0.0))}" for name, share in shares.items())
        motion = f"{{mean_speed}}, fluctuating by {_share_text(record.fluctuation)}"
        a.line("record", f"{motion}; of this fluctuation the prediction explains with {texts}")
    return shares


def state_powers(
    a: Answer, camshaft: DrivenCamshaft, constant: dict[str, float], powers: Mapping[str, dict[str, float]]
) -> None:
    """State what the drive gives, and what the corrected cam saves against constant speed."""
    drive = powers["corrected"]
    a.number("power", {"constant_speed": constant, **powers}, "power of the drive", "W")
    saving = {key: constant[key] - powers["corrected"][key] for key in ("peak", "mean_positive")}
    a.number("power_saved", saving, "power that the corrected cam saves against constant speed", "W")
    demand = f"{watts_text(constant['peak'])} at most, {watts_text(constant['mean_positive'])} on average"
    a.line("even speed", f"would need {demand} without power flowing back")
    if camshaft.driving is None:
        a.line("drive", "none: the eigenmotion saves all of this power")
    elif not camshaft.is_enforced:
        demand = f"{watts_text(drive['peak'])} at most, {watts_text(drive['mean_positive'])} on average"
        a.line("drive", f"{demand}; saved {watts_text(saving['peak'])} and {watts_text(saving['mean_positive'])}")


def state_cuts(a: Answer, purity: Purity, cuts: np.ndarray) -> float | None:
    """State the residuals of cams cut by measurement. Returns the ratio of the last two that exceed rounding."""
    a.curve("cut", np.arange(1, len(cuts) + 1), "number of the cam")
    a.curve("cut_residual", cuts, purity.name, "", "cut")
    a.number("cut_residuals", cuts.tolist(), "the same of cams cut by measurement, one after another")
    if len(cuts):
        residuals = ", ".join(_share_text(residual) for residual in cuts.tolist())
        a.line("instead", f"cutting, measuring and cutting again leaves {residuals}")
    above = cuts[cuts > _FLOOR]
    contraction = float(above[-1] / above[-2]) if len(above) > 1 else None
    return a.number("contraction", contraction, "ratio of the residual of each further cam to that before")


def state_simulation(
    a: Answer,
    purity: Purity,
    turns: int,
    confirmations: Sequence[Confirmation],
    predictions: Predictions,
    unit: str,
    shown_count: int,
) -> None:
    """State the turns simulated, and how far they deviate from the prediction; no variables without a simulation."""
    what = "turns simulated, and the deviation of the speed from the prediction"
    if not confirmations:
        a.number("simulation", None, what)
        return
    tau, pairs = even_angles(_SIMULATED_TIMES), zip(confirmations, predictions.values(), strict=True)
    amplitudes = [pad_orders(of.shaft.mean**2 * one.acceleration.amplitudes, shown_count) for one, of in pairs]
    residuals = [simulated_residual(purity, one) for one in confirmations]
    speeds = [one.speed(tau) if not one.failure else np.full(_SIMULATED_TIMES, np.nan) for one in confirmations]
    a.curve("simulated_tau", tau, "time of the last turn simulated as an angle", "rad")
    a.curve("simulated_speed", speeds, "speed of the shaft in the last turn simulated", "rad/s", "cam simulated_tau")
    a.curve("simulated_deviation", [c.deviation for c in confirmations], "difference of speed over the mean speed", "", "cam")
    a.curve("simulated_residual", residuals, f"{purity.name}, simulated", "", "cam")
    of_turn = "acceleration of the output in the last turn simulated, amplitude"
    a.curve("simulated_acceleration", amplitudes, of_turn, f"{unit}/s^2", "cam order")
    numbers = {
        name: {"deviation": _finite_or_none(one.deviation), "above": _finite_or_none(residual), "failure": one.failure}
        for name, one, residual in zip(predictions, confirmations, residuals, strict=True)
    }
    a.number("simulation", {"turns": turns, **numbers}, what)
    corrected, residual = confirmations[1], residuals[1]
    speed_clause = "it fails" if corrected.failure else f"the speed deviates by {corrected.deviation:.1e}"
    share = f"; {_orders_text(purity)} {residual:.1e} of order {purity.reference}" if math.isfinite(residual) else ""
    a.line("simulated", f"{turns} turns with the corrected cam: {speed_clause}{share}")


def simulated_residual(purity: Purity, one: Confirmation) -> float:
    """Return what the output of a simulation leaves, see ``Purity.share``; not a number where it fails."""
    return math.nan if one.failure else purity.share(one.acceleration)


def state_output(a: Answer, output: ElasticOutput | None, vibrations: Vibrations | None, unit: str) -> None:
    """State the vibrations of an elastic output; no variables where it is rigid."""
    what, per = "elastic output", f"{unit}/s^2"
    if output is None or vibrations is None:
        a.number("output", None, what)
        return
    excitations, over = vibrations.excitations, "lever swept_speed"
    deviation, acceleration = "deviation in the dwell", "acceleration in the dwell"
    a.curve("lever", list(vibrations.names), "cam")
    a.curve("swept_speed", vibrations.speeds, "mean speed", "rad/s")
    a.curve("residual_deviation", vibrations.deviation, deviation, unit, over)
    a.curve("residual_acceleration", vibrations.acceleration, acceleration, per, over)
    a.curve("resonance_order", vibrations.orders, "order at resonance with the natural frequency", "", "resonance")
    a.curve("resonance_speed", vibrations.resonances, "mean speed at that resonance", "rad/s", "resonance")
    a.curve("excited", [e.name for e in excitations], "motion of the lever")
    parts = {"deviation": (deviation, unit), "acceleration": (acceleration, per)}
    parts["peak"] = "largest acceleration of the output", per
    for name, (words, part_unit) in parts.items():
        a.curve(f"excited_{name}", [getattr(e, name) for e in excitations], words, part_unit, "excited")
    with a.group("output", what):
        a.number("natural_frequency", output.natural_frequency, "natural frequency", "rad/s")
        a.number("damping_ratio", output.damping_ratio, "damping ratio")
        rows = [asdict(e) for e in excitations]
        a.number("excited", rows, "residual vibration in the dwell by each motion of the lever", parts=parts)
    frequency = output.natural_frequency / (2 * math.pi)
    a.line("elastic", f"output at {frequency:.4g} Hz, damping ratio {output.damping_ratio:.3g}; in the dwell at most")
    for i, e in enumerate(excitations):
        if i < _BEST or e.name.endswith("cam"):  # those with the least vibration, and each cam
            a.line("", f"{_deviation_text(e.deviation, unit)}: {{name}}", name=e.name)


def state_twists(a: Answer, purity: Purity, twists: Sequence[Twist] | None, has_elastic_output: bool) -> None:
    """State the motion of cams behind an elastic shaft; no variables where it is rigid."""
    parts = {"above": (purity.name, ""), "torque": ("largest torque in the shaft", "N m"), "twist": ("largest twist", "rad")}
    rows = None if twists is None else [asdict(one) for one in twists]
    a.number("shaft", rows, "elastic shaft, each cam", parts=parts)
    if twists is None:
        return
    over = "twisted"
    a.curve("twisted", np.array([one.name for one in twists], dtype=np.str_), "cam on the elastic shaft")
    a.curve("twist_residual", [one.above for one in twists], purity.name, "", over)
    a.curve("twist_torque", [one.torque for one in twists], "largest torque in the shaft", "N m", over)
    a.curve("twist_angle", [one.twist for one in twists], "largest twist", "rad", over)
    for one in twists:
        twist = f"twists by {math.degrees(one.twist):.3g}°, {one.torque:.4g} N m"
        residual = f"{_orders_text(purity)} {_share_text(one.above)} of order {purity.reference}"
        a.line("shaft", f"{twist}, {residual}: {one.name}")
    if has_elastic_output and twists:
        a.line("springs", "of output and shaft: each is computed with the other rigid")


def _share_text(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-6 or not share else f"{share:.0e}"


def _deviation_text(value: float, unit: str) -> str:
    return f"{math.degrees(value):.3g}°" if unit == "rad" else f"{1e3 * value:.3g} mm"
