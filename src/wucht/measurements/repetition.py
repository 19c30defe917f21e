"""Test if a record repeats at another speed than its numbers give: a wrong unit, wrong pulses per turn, a wrong scale."""

from __future__ import annotations

import numpy as np

from wucht.errors import InputError
from wucht.measurements.order_checks import drift, has_drift
from wucht.measurements.order_regression import START_BLOCKS, Fit, Mean, OrderModel, block_means, initial_fit, middle
from wucht.measurements.recording import ANGLE_UNIT, SPEED_UNIT
from wucht.measurements.shaft_signal import TURN, ShaftSignal

_TURNS = 60.0  # in the middle of a record, which are examined
_MOST_BLOCKS = 40_000  # in these, where two speeds are far apart
_FEWEST = 4  # samples
_EXPLAINED_SHARE = 0.1  # of the variance is left: the orders are those of this speed
_BETTER = 0.5  # of what is left
_NOTHING = 1e-3  # of the variance is left: in records without noise it differs by rounding
_OFF = 1e-3  # of omega: the mean is another
_NEAR, _ABOUT = 4e-3, 0.2  # of omega: so near another speed must be (two rpm are no 19 teeth), this one may be off by its scale
_LEFT_OUT = 10  # orders that may have been left out on purpose, or twice the highest one kept
_PULSES = (0.25, 0.5, 2.0, 4.0)  # of the speed: an encoder counted by its edges, or another one


def check_repetition(shaft: ShaftSignal, omega: float, orders: np.ndarray) -> tuple[str, ...]:
    """Return a sentence if the orders kept would explain far more with another unit, or another number of pulses in a turn.

    omega: the mean of the numbers in rad/s. Orders that were left out on purpose are no reason: at a multiple of this speed the
    orders kept may be these. Raises ``InputError`` where all whole orders of this speed, too, explain far less.
    """
    time, values = _speed(shaft)
    if (
        omega <= 0
        or _unexplained_share(*_blocks_at_speeds(time, values, orders, omega, omega), orders, omega, _ABOUT) < _EXPLAINED_SHARE
    ):
        return ()
    candidates: list[tuple[float, float, bool, str]] = []
    for ratio, name in _alternative_readings(shaft).items():
        t, y = _blocks_at_speeds(time, values, orders, omega, ratio * omega)
        alternative_share, stated_share = (
            _unexplained_share(t, y, orders, ratio * omega, _NEAR),
            _unexplained_share(t, y, orders, omega, _ABOUT),
        )
        if alternative_share < _BETTER * stated_share:
            multiple = ratio > 1 and abs(ratio - round(ratio)) < _OFF
            whole_share = _unexplained_share(t, y, _whole_orders(orders, t, omega), omega, _ABOUT)
            if (multiple and _BETTER * alternative_share < whole_share + _NOTHING) or alternative_share < _BETTER * whole_share:
                candidates.append((alternative_share, stated_share, multiple, name))
    if not candidates:
        return ()
    alternative_share, stated_share, multiple, name = min(candidates)
    if not multiple:
        raise InputError(shaft.location, None, _refusal(shaft, name))
    return (
        f"The orders kept explain {100 * (1 - stated_share):.0f} % of the fluctuation. {_condition(shaft, name)} they "
        f"would explain {100 * (1 - alternative_share):.0f} %: "
        f"check {'pulses_per_turn' if shaft.per_turn is not None else 'the unit'}.",
    )


def scale_warning(shaft: ShaftSignal, orders: np.ndarray, omega: float) -> tuple[str, ...]:
    """Return a sentence if orders repeat at another speed than the mean of the signal: if its scale or its zero is wrong.

    omega: about that mean. None if the speed drifts by more than that: then, too, no speed fits, and another warning says so.
    """
    t, y = _blocks_at_speeds(*_speed(shaft), orders, omega, omega)
    model = OrderModel(orders, Mean.FREE)
    if len(t) <= 2 * model.size:
        return ()
    free_fit, fixed_fit = initial_fit(model, t, y, omega), initial_fit(OrderModel(orders, Mean.SPEED), t, y, omega)
    repeats, mean = float(free_fit.theta[0]), float(free_fit.theta[1])
    ratio = mean / repeats
    if not free_fit.has_converged or free_fit.squares > _BETTER * fixed_fit.squares or not _OFF < abs(ratio - 1) < _ABOUT:
        return ()
    speed_drift = drift(model, free_fit, t, y)
    by_drift = has_drift(omega, speed_drift) and abs(speed_drift[0]) > abs(mean - repeats)
    return () if by_drift else (_scale_sentence(shaft, mean, repeats),)


def _speed(shaft: ShaftSignal) -> tuple[np.ndarray, np.ndarray]:
    """Return the speed of the shaft over the time from the middle of the record."""
    time, values = shaft.speed()
    return time - (time[0] + time[-1]) / 2, values


def _alternative_readings(shaft: ShaftSignal) -> dict[float, str]:
    """Return other readings of the numbers, by the ratio of the shaft's speed: a unit, or a number of pulses a turn."""
    if shaft.per_turn is not None:
        return {r: f"{shaft.per_turn / r:.0f}" for r in _PULSES if (shaft.per_turn / r).is_integer()}
    unit, names = (
        (SPEED_UNIT, ("rad/s", "rpm", "Hz", "deg/s")) if shaft.quantity == "speed" else (ANGLE_UNIT, ("rad", "deg", "rev"))
    )
    unit_factor = unit.parse_quantity(f"1 {shaft.unit}") if shaft.unit else 1.0
    ratios = {unit.parse_quantity(f"1 {name}") / unit_factor: name for name in names}
    return {ratio: name for ratio, name in ratios.items() if abs(ratio - 1) > _NEAR}


def _blocks_at_speeds(
    time: np.ndarray, values: np.ndarray, orders: np.ndarray, first_speed: float, second_speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return blocks (B,) of the middle of a record that resolve the orders of both speeds, with the same noise."""
    block = TURN / max(first_speed, second_speed) / orders[-1] / START_BLOCKS
    return block_means(*middle(time, values, min(_TURNS * TURN / min(first_speed, second_speed), _MOST_BLOCKS * block)), block)


def _whole_orders(orders: np.ndarray, time: np.ndarray, omega: float) -> np.ndarray:
    """Return the orders, and all other ones that blocks at these times can hold and that may have been omitted on purpose."""
    most = min(max(_LEFT_OUT, 2 * int(orders[-1])), int(len(time) * TURN / omega / float(np.ptp(time)) / 2.5))
    return np.union1d(orders, np.arange(1, most + 1))


def _unexplained_share(time: np.ndarray, values: np.ndarray, orders: np.ndarray, omega: float, near: float) -> float:
    """The share of the variance left without orders of about omega, the mean being free; 1 if the record is too short."""
    if len(time) < _FEWEST:
        return 1.0
    turns, spread = omega * float(np.ptp(time)) / TURN, float(np.var(values))
    model = OrderModel(orders, Mean.FREE)
    if turns < 1 or len(time) <= max(2 * orders[-1] * turns, 2 * model.size) or spread == 0:
        return 1.0
    fit: Fit = initial_fit(model, time, values, omega)
    return min(1.0, fit.variance / spread) if abs(fit.theta[0] / omega - 1) < near else 1.0


def _refusal(shaft: ShaftSignal, name: str) -> str:
    if shaft.per_turn is not None:
        return f"the pulses repeat as if there were {name} a turn, not {shaft.per_turn}: give pulses_per_turn = {name}"
    if shaft.unit:
        remedy = f"give unit = '{name}', or correct the heading"
        return f"the numbers are stated in {shaft.unit}, but they repeat as if they were in {name}: {remedy}"
    column = shaft.location.rsplit(": ", 1)[-1]
    remedy = f"write the unit into the heading, as in {column} [{name}], or give unit = '{name}'"
    return (
        f"the numbers have no unit and would be in {_stated_unit(shaft)}, but they repeat as if they were in {name}: {remedy}"
    )


def _condition(shaft: ShaftSignal, name: str) -> str:
    if shaft.per_turn is not None:
        return f"If the encoder gave {name} pulses a turn, not {shaft.per_turn},"
    return f"If the numbers were in {name}, not in {_stated_unit(shaft)},"


def _stated_unit(shaft: ShaftSignal) -> str:
    """The unit of the numbers, as stated or, if it was not, as assumed."""
    return shaft.unit or (SPEED_UNIT.si if shaft.quantity == "speed" else ANGLE_UNIT.si)


def _scale_sentence(shaft: ShaftSignal, mean: float, repeats: float) -> str:
    ratio = mean / repeats
    summary = f"The mean of the numbers is {ratio:.5g} times the speed at which their orders repeat, and no motion has both:"
    if shaft.per_turn is not None:
        pulses = shaft.per_turn * ratio
        return f"{summary} check pulses_per_turn, {shaft.per_turn}; {pulses:.6g} of them in a turn would fit."
    times = f"multiply the numbers by {1 / ratio:.5g} (key scale)"
    if shaft.quantity == "angle":
        return f"{summary} the scale of the sensor is wrong; {times}."
    offset = shaft.format_speed(abs(mean - repeats))
    offset = f"subtract {offset} from them in the record" if ratio > 1 else f"add {offset} to them in the record"
    return (
        f"{summary} the scale of the sensor is wrong, or its offset. If it is the scale, {times}; if it is the "
        f"offset, {offset}."
    )
