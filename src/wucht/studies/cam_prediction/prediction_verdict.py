"""The verdict of a prediction, and its doubts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from wucht.cams.confirmation import Confirmation
from wucht.cams.correction import Purity
from wucht.cams.driven_camshaft import DrivenCamshaft, ShaftPrediction
from wucht.cams.elasticity import RIGID_SHAFT_CAM, TWIST_CAM, Twist
from wucht.cams.prediction import unresolved_share
from wucht.cams.shaft_motion import ShaftMotion
from wucht.studies.answer import Answer
from wucht.studies.cam_prediction.answer import Predictions, simulated_residual

_CLEAN = 1e-6  # of order 1, and of the stroke: below the accuracy of a workshop
_SLOW, _DIVERGING = 0.5, 1.0  # inertia ratios
_TWIST_LIMIT = 1e-3  # of order 1: largest acceptable residual behind an elastic shaft
_UNRESOLVED_LIMIT = 1e-6  # of the mean speed: larger highest orders indicate that further ones are missing
_DEVIATION_LIMIT = 1e-5  # of the mean speed: prediction and simulation differ
_LEAST_SHARE, _SAME_MEAN = 0.5, 0.01  # of a record's fluctuation, and of its mean speed: with less, it is another motion
_KILO = 1e3


def state_prediction_verdict(
    a: Answer,
    camshaft: DrivenCamshaft,
    predictions: Predictions,
    confirmations: Sequence[Confirmation],
    twists: Sequence[Twist] | None,
    largest_power: float,
) -> None:
    """State whether the corrected cam is clean. largest_power: of the drive, with this cam."""
    purity, corrected = camshaft.purity, predictions["corrected"]
    of_twist = _twist_text(purity, twists)
    if camshaft.is_enforced:
        clause = f"the drive holds the shaft's speed with up to {_power_text(largest_power)}: the law itself is the cam"
        label, a.sentence = "enforced", clause
        if of_twist:
            label, a.sentence = "not clean", f"NOT CLEAN on the elastic shaft: {of_twist}; {clause}"
    else:
        fluctuates = f"fluctuates by {_percent_text(corrected.shaft.fluctuation)}"
        label, text = _rigid_shaft_verdict(purity, corrected, confirmations)
        shaft = f"on a shaft that {fluctuates}"
        if label == "clean" and of_twist:
            label, text, shaft = "not clean", of_twist, f"on the elastic shaft that {fluctuates}"
        a.sentence = f"{label.upper()} {shaft}: {text}"
        if label == "clean":
            a.sentence += f", the original one leaves {_brief_share_text(purity, predictions['original'].deviation.orders)}"
    a.number("verdict", label, "verdict")


def _rigid_shaft_verdict(purity: Purity, corrected: ShaftPrediction, confirmations: Sequence[Confirmation]) -> tuple[str, str]:
    """Return the label of the corrected cam, and its residual."""
    if not purity.is_clean(corrected.deviation, _CLEAN):
        off = f"its position is off by {_percent_text(corrected.deviation.position / purity.stroke)} of the stroke"
        return "not clean", f"the corrected cam leaves {_order_share_text(purity, corrected.deviation.orders)}, {off}"
    nothing = _order_share_text(purity, 0.0)
    if corrected.multiplier > 1:
        unstable = f"but this motion is not stable: a disturbance grows {corrected.multiplier:.4g}-fold in a turn"
        return "not clean", f"the corrected cam would leave {nothing}, {unstable}"
    simulated_share = simulated_residual(purity, confirmations[1]) if confirmations else 0.0
    if simulated_share > _CLEAN:
        simulation = f"by simulation {_brief_share_text(purity, simulated_share)}"
        return "not confirmed", f"by prediction the corrected cam leaves {nothing}, {simulation}"
    return "clean", f"the corrected cam leaves {nothing}"


def _brief_share_text(purity: Purity, share: float) -> str:
    """Return the same where the measure has been named."""
    off = "orders off by up to " if purity.count is None else ""
    return f"{off}{_percent_text(share)} of order {purity.reference}"


def _order_share_text(purity: Purity, share: float) -> str:
    """Return what a cam leaves by the measure, in words: 1.2 % of order 1 in orders above 5, or orders off the law's."""
    share_text = f"{_percent_text(share)} of order {purity.reference}"
    if purity.count is None:
        return f"orders off the law's by up to {share_text}" if share > _CLEAN else "no order off the law's"
    return f"{share_text if share > _CLEAN else 'nothing'} in orders above {purity.count}"


def _twist_text(purity: Purity, twists: Sequence[Twist] | None) -> str:
    """Return the residual of the corrected cam behind an elastic shaft in a sentence, empty where it does not matter."""
    if twists is None:
        return ""
    residuals = {one.name: one.above for one in twists}
    residual = residuals.get(RIGID_SHAFT_CAM, math.inf)
    if residual <= _TWIST_LIMIT:
        return ""
    text = f"the cam corrected for a rigid shaft leaves {_order_share_text(purity, residual)}"
    if RIGID_SHAFT_CAM not in residuals:
        text = "no periodic motion was obtained with the cam corrected for a rigid shaft"
    if TWIST_CAM not in residuals:
        return text
    rest = "nothing" if residuals[TWIST_CAM] <= _CLEAN else _percent_text(residuals[TWIST_CAM])
    return f"{text}, corrected for the twist too it leaves {rest}"


def warn_of_cutting(a: Answer, camshaft: DrivenCamshaft, contraction: float | None, failure: str) -> None:
    """Warn where cutting a cam and measuring again converges slowly or not at all. failure: why there are no more cams."""
    ratio = camshaft.shaft.inertia_ratio(camshaft.law)
    ratio_clause, again = f"the inertia ratio J1 max psi'^2/J0 is {ratio:.3g}", "cutting a cam and measuring again"
    if not camshaft.is_enforced and ratio > _DIVERGING:
        a.warn(f"{ratio_clause}: above about 1 {again} may diverge; take the predicted cam, or a larger flywheel")
    elif not camshaft.is_enforced and ratio > _SLOW:
        rate = (
            f", each cam leaves {_percent_text(contraction)} of the residual of the one before"
            if contraction is not None
            else ""
        )
        a.warn(f"{ratio_clause}: {again} converges slowly{rate}; take the predicted cam")
    if failure:
        a.warn(failure)
    elif contraction is not None and contraction >= 1:
        a.warn(f"{again} diverges: the last cam is worse than the one before")


def warn_of_motions(a: Answer, predictions: Predictions, confirmations: Sequence[Confirmation]) -> None:
    """Warn of motions of the shaft that are not resolved, not stable, or not confirmed."""
    for name, one in predictions.items():
        if (share := unresolved_share(one.shaft)) > _UNRESOLVED_LIMIT:
            a.warn(
                f"with the {name} cam the highest orders of the speed are {share:.1e} of its mean, and higher ones are left "
                "out: the shaft nearly stands still within a turn, or the law's acceleration jumps"
            )
    for name, one in predictions.items():
        if one.multiplier > 1:
            a.warn(
                f"with the {name} cam this motion is not stable: a disturbance grows {one.multiplier:.4g}-fold in a turn, "
                "because drive less loads rises with the speed; give another mean_speed, or another drive or load"
            )
    for confirmation, (name, one) in zip(confirmations, predictions.items(), strict=False):
        if not confirmation.deviation <= _DEVIATION_LIMIT:
            departure = confirmation.failure or _departure_text(confirmation, one)
            a.warn(f"the simulation with the {name} cam {departure}")


def _departure_text(confirmation: Confirmation, one: ShaftPrediction) -> str:
    """Return the deviation of a simulation, with the reason where it is known."""
    reason = ""
    if one.multiplier > 1:
        reason = ": this motion is not stable"
    elif unresolved_share(one.shaft) > _UNRESOLVED_LIMIT:
        reason = ", by the orders that the prediction leaves out"
    elif one.multiplier == 1:
        reason = ": without a drive nothing restores the motion, and errors of the simulation add up from turn to turn"
    return f"departs from the prediction by {_percent_text(confirmation.deviation)} of the speed{reason}"


def warn_of_record(a: Answer, record: ShaftMotion | None, shares: dict[str, float], predictions: Predictions) -> None:
    """Warn where there is a record of the speed, which is not that of the prediction with either cam."""
    if record is None:
        return
    name, share = max(shares.items(), key=lambda one: one[1])
    shaft = predictions[name].shaft
    if share < _LEAST_SHARE or abs(shaft.mean / record.mean - 1) > _SAME_MEAN:
        record_text = f"{record.mean:.4g} rad/s and fluctuates by {_percent_text(record.fluctuation)}"
        prediction_text = f"{shaft.mean:.4g} rad/s and {_percent_text(shaft.fluctuation)}"
        a.warn(
            f"the record of the speed has a mean of {record_text}, the prediction with the {name} cam has {prediction_text}: "
            "check the inertias, the drive and the loads of [shaft], or correct the cam for the measured speed by "
            "cam-correction"
        )


def warn_of_twists(a: Answer, purity: Purity, twists: Iterable[Twist], notes: Iterable[str]) -> None:
    """Warn where the cam for the rigid shaft is not clean behind the elastic one. notes: reasons for cams without a motion."""
    for one in twists:
        if one.name == RIGID_SHAFT_CAM and one.above > _TWIST_LIMIT:
            residual = _order_share_text(purity, one.above)
            a.warn(f"elastic shaft: the cam for the rigid shaft, that of this result, leaves {residual}")
    a.warn(*notes)


def _percent_text(share: float) -> str:
    return f"{100 * share:.3g} %"


def _power_text(power: float) -> str:
    return f"{power / _KILO:.3g} kW" if abs(power) >= _KILO else f"{power:.3g} W"
