"""What to check before orders are believed: sensors that fake them, a speed that drifts."""

from __future__ import annotations

import math

import numpy as np

from wucht.measurements.order_residual import LeftOutOrder
from wucht.numerics.harmonics import Harmonics

_ERRORS = 3.0  # standard errors: an order above is there
_ROUNDING = 1e-9  # of omega: an order below is none
_MATTERS = 1e-3  # of omega: an order that is left out
_SHARE = 0.05  # of the residual's square, by a drift
_HALF = 0.5  # of a fluctuation, or of what is left of it
_ROUGH = 1.0  # of block means: smoother ones are no noise
_ROUGH_SAMPLES = 0.5  # of samples, likewise; these may be few in a period


def warnings_of(
    speed: Harmonics, orders: tuple[int, ...], errors: np.ndarray, left: tuple[LeftOutOrder, ...], drifted: tuple[float, float]
) -> tuple[str, ...]:
    """What to check, in sentences: orders 1 and 2 that a sensor may fake, or that are left out, and a speed that drifts.

    errors (K,): of the amplitudes of the orders. drifted: by how much in rad/s, and the share of the residual's square.
    """
    texts, omega = [], speed.mean
    for order in (1, 2):
        if order in orders:
            amplitude = float(speed.amplitudes[order - 1])
            if amplitude > max(_ERRORS * errors[orders.index(order)], _ROUNDING * omega):
                texts.append(_kept(order, amplitude / omega))
        else:
            found = next((o for o in left if o.order == order), None)
            if found and found.amplitude > max(_ERRORS * found.error, _MATTERS * omega):
                texts.append(_left_out(order, found.amplitude / omega))
    if drifts(omega, drifted):
        texts.append(
            f"The speed drifts by {drifted[0]:+.3g} rad/s over the record, which orders of one constant speed cannot follow: "
            "cut the record to a part of constant mean speed."
        )
    return tuple(texts)


def drifts(omega: float, drifted: tuple[float, float]) -> bool:
    """Whether a speed drifts. drifted: by how much in rad/s, and the share of the residual's square."""
    return drifted[1] > _SHARE and abs(drifted[0]) > _MATTERS * omega


def unexplained_warning(
    explained: float, rough: tuple[float, float], left: tuple[LeftOutOrder, ...], drifted: float
) -> tuple[str, ...]:
    """A sentence where the orders kept explain less than half of a fluctuation that is no noise, no drift and no other orders.

    explained: the share. rough: of the residual, of block means and of samples, see ``roughness``. drifted: the share of its
    square by a drift.
    """
    others = sum(o.share for o in left if o.amplitude > _ERRORS * o.error)
    noise = rough[0] > _ROUGH and rough[1] > _ROUGH_SAMPLES
    if explained > _HALF or noise or others > _HALF or drifted > _HALF:
        return ()
    return (
        f"The orders kept explain {_percent(explained)} of the fluctuation, and the rest is no noise from sample to sample, no "
        "drift and in no other whole order: it does not repeat with the speed that the numbers say. Check unit and scale, of "
        "pulses pulses_per_turn, and whether this is the shaft of the cam.",
    )


def _kept(order: int, share: float) -> str:
    return f"Order {order} is {_percent(share)} of the speed and is kept. {_fake(order, share)} before it is corrected for."


def _left_out(order: int, share: float) -> str:
    text = f"Order {order} is left out, but the record holds {_percent(share)} of the speed in it."
    if order == 1:
        text += (
            f" If the shaft does turn so, a correction without it leaves about {_percent(9 * share)} of the motion as it was."
        )
    return f"{text} {_fake(order, share)} before it is left out."


def _fake(order: int, share: float) -> str:
    if order == 1:
        return (
            f"An encoder off centre by {_percent(share)} of its radius shows the same: check its run-out, or read it with two "
            "heads opposite each other,"
        )
    angle = math.degrees(math.sqrt(2 * share))
    return (
        f"A cardan (universal) joint bent by {angle:.2g} deg between shaft and encoder shows the same: check how the encoder "
        "is coupled,"
    )


def _percent(share: float) -> str:
    return f"{float(f'{100 * share:.2g}'):g} %"
