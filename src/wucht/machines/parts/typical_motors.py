"""Typical cage motors: what a nameplate does not say, by rated power and number of poles.

Source: Motive s.r.l., General Catalogue, Delphi series (IEC frames 56 to 355, 400 V, 50 Hz), technical data, pages 20 to 23:
maximum and locked-rotor torque over the rated one, moment of inertia of the rotor. Between two motors of the catalogue the
values are interpolated over the logarithm of the power. Of its 129 motors 19 in 20 lie within the spreads below, which are
as wide as those of other makers, and wider than the tolerances of IEC 60034-1 (breakdown torque -10 %, locked-rotor torque
-15 and +25 %). Design N of IEC 60034-12 requires less: 4 to 6.3 kW 2.0 and 1.5 times the rated torque.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_MOTORS = {  # by poles: rated power in kW, breakdown and starting torque over the rated one, inertia in kg m^2
    2: (
        (0.25, 2.91, 2.91, 0.0003), (0.75, 2.99, 2.83, 0.00075), (3, 3.24, 2.98, 0.0029), (11, 3.19, 2.69, 0.0377),
        (37, 2.3, 2.0, 0.139), (132, 2.2, 1.8, 1.82),
    ),
    4: (
        (0.25, 2.59, 2.59, 0.0005), (0.75, 2.88, 2.56, 0.0021), (3, 2.86, 2.68, 0.0067), (11, 3.11, 2.73, 0.061),
        (37, 2.3, 2.2, 0.406), (132, 2.2, 2.1, 3.62),
    ),
    6: (
        (0.25, 2.93, 2.70, 0.0014), (0.75, 2.32, 2.0, 0.0029), (3, 2.75, 2.11, 0.0286), (11, 2.1, 2.1, 0.116),
        (37, 2.1, 2.1, 0.843), (132, 2.0, 2.0, 6.12),
    ),
    8: (
        (0.37, 2.0, 2.0, 0.0021), (0.75, 2.65, 2.28, 0.009), (3, 2.0, 1.8, 0.0395), (11, 2.0, 2.0, 0.203),
        (37, 2.0, 1.9, 1.93), (110, 2.0, 1.8, 7.23),
    ),
}  # fmt: skip
BREAKDOWN_SPREAD, STARTING_SPREAD, INERTIA_SPREAD = 1.2, 1.25, 2.0  # largest and least value over the typical one, each way


@dataclass(frozen=True)
class TypicalMotor:
    """A cage motor as catalogues have it. power: in kW. inertia: of its rotor, in kg m^2."""

    power: float
    poles: int
    breakdown: float
    starting: float
    inertia: float

    @classmethod
    def of(cls, power: float, poles: float) -> TypicalMotor:
        """The typical motor of a rated power in W.

        More than 8 poles count as 8. Beyond the catalogue torques are those of its last motor, and the inertia is extrapolated.
        """
        nearest_poles = max(p for p in _MOTORS if p <= max(poles, 2))
        powers, breakdown, starting, inertia = np.log(np.array(_MOTORS[nearest_poles])).T
        at = float(np.log(power / 1e3))
        right = int(np.clip(np.searchsorted(powers, at), 1, len(powers) - 1))
        share = (at - powers[right - 1]) / (powers[right] - powers[right - 1])
        rise = inertia[right] - inertia[right - 1]
        return cls(
            power / 1e3,
            round(poles),
            float(np.interp(at, powers, np.exp(breakdown))),
            float(np.interp(at, powers, np.exp(starting))),
            float(np.exp(inertia[right - 1] + share * rise)),
        )

    def __str__(self) -> str:
        return f"typical of {self.power:.4g} kW, {self.poles} poles (catalogue Motive Delphi)"


def estimate_text(name: str, value: float, spread: float, unit: str = "", least: float = 0.0) -> str:
    """Return an estimate with its range as text: ``starting torque ratio 2.7 (estimate, 2.1 to 3.4)``."""
    return f"{name} {value:.2g}{unit} (estimate, {max(value / spread, least):.2g} to {value * spread:.2g})"
