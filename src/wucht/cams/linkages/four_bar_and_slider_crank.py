"""The linkages between the follower's lever and the output: four-bar and slider-crank.

R. L. Norton, "Design of Machinery", McGraw-Hill, chapter 4: position analysis of both, open and crossed, and toggle positions.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wucht.cams.demands import format_degrees, format_millimetres
from wucht.cams.linkages.closure import Linkage, check_parameters, corner
from wucht.errors import InputError

_ROUNDING = 1e-12
_CLOSES = "to close the linkage at the angle where the law is zero (linkage.angle)"


@dataclass(frozen=True)
class FourBar(Linkage):
    """Lever and output turn about fixed pivots, and a coupler joins their ends; the output psi is an angle in rad.

    ground: the distance of the pivots; input, output: from pivot to joint, of lever and output; coupler: between the joints;
    all in m. angle: of the lever where rho = psi = 0, in rad from the line to the output's pivot. branch: +1, the open
    linkage, or -1, the crossed one, with the lever on the left of that line (0 < angle < pi): in the open one the
    output is clockwise of the line from its pivot to the lever's joint.

    Raises ``InputError`` (linkage.KEY): no length, lengths that do not close at ``angle``, a dead point there.
    """

    ground: float
    input: float
    coupler: float
    output: float
    angle: float
    branch: int = +1

    def __post_init__(self) -> None:
        lengths = {"ground": self.ground, "input": self.input, "coupler": self.coupler, "output": self.output}
        check_parameters(lengths, self.angle, self.branch)
        reach = abs(self.input * cmath.exp(1j * self.angle) - self.ground)
        least, most = abs(reach - self.output), reach + self.output
        if not least <= self.coupler <= most:
            message = f"must be between {format_millimetres(least)} and {format_millimetres(most)}"
            raise InputError("linkage.coupler", self.coupler, f"{message}, not {format_millimetres(self.coupler)}, {_CLOSES}")
        self._check_reference()

    @property
    def _arm(self) -> float:
        return self.input

    @property
    def _rod(self) -> float:
        return self.coupler

    @property
    def _period(self) -> float:
        return 2 * math.pi

    def _output_joint(self, y: np.ndarray) -> np.ndarray:
        turning = self.output * np.exp(1j * np.asarray(y))
        return np.stack([self.ground + turning, 1j * turning, -turning, -1j * turning])

    def _direction(self, y: np.ndarray) -> np.ndarray:
        return _angle_of_sum(self.ground, self.output, y)

    def _output_position(self, alpha: np.ndarray) -> np.ndarray:
        # z: from the output's pivot to the lever's joint; -z is the sum of ground and -input.
        reach = np.abs(self.input * np.exp(1j * alpha) - self.ground)
        z = math.pi + _angle_of_sum(self.ground, self.input, alpha - math.pi)
        return np.asarray(z - self.branch * corner(reach, self.output, self.coupler))

    def _dead_positions(self) -> Iterator[tuple[float, float]]:
        g, a, b, c = self.ground, self.input, self.coupler, self.output
        for reach in (c + b, c - b):
            for alpha in _angles((a**2 + g**2 - reach**2) / (2 * a * g)):
                yield alpha, cmath.phase((cmath.rect(a, alpha) - g) * reach)

    def _reversal_outputs(self) -> Iterator[float]:
        g, a, b, c = self.ground, self.input, self.coupler, self.output
        for reach in (a + b, a - b):
            yield from _angles((reach**2 - g**2 - c**2) / (2 * g * c))

    @staticmethod
    def _format_output(psi: float) -> str:
        return format_degrees(psi)


@dataclass(frozen=True)
class SliderCrank(Linkage):
    """The lever is a crank, and a rod joins its end to a slider; the output psi is the slider's way in m.

    crank: the lever's arm on this side; rod: its length. offset: by how much the slide passes the lever's pivot on the left, as
    viewed in the direction in which psi grows. All in m. angle: of the crank where rho = psi = 0, in rad from that
    direction. branch: +1, the slider is ahead of the crank's end, or -1, behind it.

    Raises ``InputError`` (linkage.KEY): no length, lengths that do not close at ``angle``, a dead point there.
    """

    crank: float
    rod: float
    angle: float
    offset: float = 0.0
    branch: int = +1

    def __post_init__(self) -> None:
        check_parameters({"crank": self.crank, "rod": self.rod}, self.angle, self.branch)
        if not math.isfinite(self.offset):
            raise InputError("linkage.offset", self.offset, "must be a finite length")
        least = abs(self.offset - self.crank * math.sin(self.angle))
        if not self.rod >= least:
            requirement = f"must be at least {format_millimetres(least)}, not {format_millimetres(self.rod)}, {_CLOSES}"
            raise InputError("linkage.rod", self.rod, requirement)
        self._check_reference()

    @property
    def _arm(self) -> float:
        return self.crank

    @property
    def _rod(self) -> float:
        return self.rod

    @property
    def _period(self) -> float:
        return math.inf

    def _output_joint(self, y: np.ndarray) -> np.ndarray:
        along, still = np.ones_like(y), np.zeros_like(y)
        return np.stack([y + 1j * self.offset, along, still, still])

    def _direction(self, y: np.ndarray) -> np.ndarray:
        return np.asarray(np.arctan2(self.offset, y))

    def _output_position(self, alpha: np.ndarray) -> np.ndarray:
        rise = self.offset - self.crank * np.sin(alpha)
        along = np.sqrt(np.maximum((self.rod - rise) * (self.rod + rise), 0.0))
        return np.asarray(self.crank * np.cos(alpha) + self.branch * along)

    def _dead_positions(self) -> Iterator[tuple[float, float]]:
        for rise in (self.offset + self.rod, self.offset - self.rod):
            for alpha in _angles(rise / self.crank):
                yield math.pi / 2 - alpha, self.crank * math.sin(alpha)

    def _reversal_outputs(self) -> Iterator[float]:
        for reach in (self.crank + self.rod, self.crank - self.rod):
            if abs(reach) >= abs(self.offset):
                along = math.sqrt((reach - self.offset) * (reach + self.offset))
                yield from (along, -along)

    @staticmethod
    def _format_output(psi: float) -> str:
        return format_millimetres(psi)


def _angle_of_sum(fixed_length: float, turning_length: float, angle: np.ndarray) -> np.ndarray:
    """The angle of fixed + turning e^(i angle), without jumps as it turns round; both are lengths."""
    if fixed_length >= turning_length:
        return np.angle(fixed_length + turning_length * np.exp(1j * angle))
    return np.asarray(angle + np.angle(turning_length + fixed_length * np.exp(-1j * angle)))


def _angles(cosine: float) -> tuple[float, ...]:
    """The angles with this cosine."""
    if abs(cosine) > 1 + _ROUNDING:
        return ()
    angle = math.acos(max(-1.0, min(1.0, cosine)))
    return angle, -angle
