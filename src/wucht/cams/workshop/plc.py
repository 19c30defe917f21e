"""Cam tables of controllers: a motion law as the slave positions of an electronic cam over the master positions of a turn.

The terms are those of PLCopen (Motion Control): the table is handed to MC_CamTableSelect, with Periodic := TRUE, and MC_CamIn
couples the slave axis to the master axis by it. Between the rows the controller interpolates; a table is judged by the outcome.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from wucht.cams.demands import finite, places, positive
from wucht.cams.laws.law import Law
from wucht.errors import InputError

MOST_ROWS = 32767  # nElements of CODESYS' MC_CAM_REF is an INT
MASTER_DECIMALS = 4  # of degrees: steps are whole multiples of 0.0001 deg, so that even spacing survives rounding
VELOCITY_FINER, ACCELERATION_FINER = 3, 5  # decimals more than the slave position has
_FEWEST = 8
_BETWEEN = 16  # parts of each interval at which the table is compared with the law; the middle is one
_SAMPLES = 2048
_SHARE = 0.99  # of the tolerance is used: between the samples lies at most 0.4 % more
_CLOSED = 1e-9  # of the law's range: by how much it may differ after a turn
_DEGREE = math.pi / 180
_TURN = 2 * math.pi


class Unit(Enum):
    """The unit of the slave in the file: mm for a law in m, deg for a law in rad."""

    MILLIMETRE = "mm"
    DEGREE = "deg"

    @property
    def per_si(self) -> float:
        """How many of it are one m, or one rad."""
        return 1e3 if self is Unit.MILLIMETRE else 1 / _DEGREE


class Interpolation(Enum):
    """What the controller does between the rows, and to which power of their distance its error falls."""

    LINEAR = 2
    QUINTIC = 6  # polynomials of fifth degree from position, velocity and acceleration at both ends


@dataclass(frozen=True, eq=False)
class CamTable:
    """The rows of a cam table, in SI, rounded as in the file. It is a law itself: what the controller makes of it.

    phi (N,): master positions in rad, from 0 to 2 pi, both included. position (N,): of the slave in m or rad. velocity,
    acceleration (N,): its derivatives by phi; None for linear interpolation. decimals: of the slave position in its unit.
    """

    phi: np.ndarray
    position: np.ndarray
    velocity: np.ndarray | None
    acceleration: np.ndarray | None
    unit: Unit
    decimals: int

    @property
    def interpolation(self) -> Interpolation:
        """Linear where positions are all that is there."""
        return Interpolation.LINEAR if self.velocity is None else Interpolation.QUINTIC

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The motion, or its derivative by phi of order 1 to 3, at master positions in rad of any shape."""
        angle = np.mod(np.asarray(phi, float), _TURN)
        i = np.clip(np.searchsorted(self.phi, angle, side="right") - 1, 0, len(self.phi) - 2)
        h = np.diff(self.phi)[i]
        share = (angle - self.phi[i]) / h
        coefficients = self._polynomials()
        value = np.zeros(angle.shape)
        for power in range(len(coefficients) - 1, order - 1, -1):
            value = value * share + math.perm(power, order) * coefficients[power][i]
        return np.asarray(value / h**order)

    def _polynomials(self) -> list[np.ndarray]:
        """The coefficients (N - 1,) of the powers of the share of each interval, from the constant one on."""
        y, h = self.position, np.diff(self.phi)
        if self.velocity is None or self.acceleration is None:
            return [y[:-1], np.diff(y)]
        v, a = self.velocity, self.acceleration
        first, second = h * v[:-1], h**2 * a[:-1] / 2
        d, e, f = np.diff(y) - first - second, h * v[1:] - first - 2 * second, h**2 * a[1:] - 2 * second
        return [y[:-1], first, second, 10 * d - 4 * e + f / 2, -15 * d + 7 * e - f, 6 * d - 3 * e + f / 2]


def cam_table(
    law: Law,
    unit: Unit,
    tolerance: float,
    interpolation: Interpolation = Interpolation.QUINTIC,
    decimals: int = 6,
    most: int = MOST_ROWS,
) -> CamTable:
    """The table of about as few rows as keep the interpolated, rounded motion within the tolerance of the law.

    tolerance: in m or rad, as the law. decimals: of the slave position in its unit, mm or deg; the velocity has three more, the
    acceleration five. most: the number of rows that the controller takes. Raises ``InputError``.
    """
    positive("tolerance", tolerance)
    half = 0.5 * 10.0 ** -places("decimals", decimals) / unit.per_si
    if tolerance <= half:
        need = math.floor(-math.log10(2 * tolerance * unit.per_si)) + 1
        raise InputError("decimals", decimals, f"rounding alone spoils the tolerance: {need} decimals or more are needed")
    _check_closed(law)
    steps = _even_steps(most)
    count = _FEWEST
    for n in steps:
        if n < count:
            continue
        table = _rounded(law, unit, n, interpolation, decimals)
        excess = largest_deviation(table, law) / (_SHARE * tolerance)
        if excess <= 1:
            return table
        count = math.ceil(n * min(excess ** (1 / interpolation.value), 1.5))
    raise InputError(
        "tolerance", tolerance, f"{most} rows do not keep it (in m or rad): choose a wider one, more decimals or more rows"
    )


def largest_deviation(table: CamTable, law: Law, order: int = 0) -> float:
    """How far the interpolated table is from the law, or its derivative from the law's: the largest, in SI."""
    parts = max(_BETWEEN, math.ceil(_SAMPLES / (len(table.phi) - 1)))
    shares = np.arange(parts) / parts
    phi = (table.phi[:-1, None] + np.diff(table.phi)[:, None] * shares).ravel()
    return float(np.abs(table(phi, order) - finite("law", law(phi, order))).max())


def _check_closed(law: Law) -> None:
    values = finite("law", law(np.linspace(0, _TURN, _SAMPLES + 1)))
    if abs(values[-1] - values[0]) > _CLOSED * max(float(np.abs(values).max()), float(np.ptp(values))):
        raise InputError(
            "law", None, "it must come back after a turn: a lift at each turn is no periodic cam table", code="not-periodic"
        )


def _even_steps(most: int) -> list[int]:
    """The numbers of intervals of which each is a whole multiple of the last decimal of the master."""
    whole = 360 * 10**MASTER_DECIMALS
    return [n for n in range(_FEWEST, min(most, MOST_ROWS)) if whole % n == 0]


def _rounded(law: Law, unit: Unit, n: int, interpolation: Interpolation, decimals: int) -> CamTable:
    phi = np.arange(n + 1) * (_TURN / n)

    def rounded(order: int, finer: int) -> np.ndarray:
        per_si = unit.per_si * _DEGREE**order  # derivatives stand in the file by the degree
        values = np.round(finite("law", law(phi, order)) * per_si, decimals + finer) / per_si
        values[-1] = values[0]
        return values

    if interpolation is Interpolation.LINEAR:
        return CamTable(phi, rounded(0, 0), None, None, unit, decimals)
    return CamTable(phi, rounded(0, 0), rounded(1, VELOCITY_FINER), rounded(2, ACCELERATION_FINER), unit, decimals)
