"""The base class of followers: a table [follower] of a cam file, and the cams it needs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from pydantic import Field, StrictBool

from wucht.cams.cam import Cam
from wucht.cams.laws import Law
from wucht.cams.milled_cam import MilledContour
from wucht.cams.sizing.size_limits import CamLimits, Size, SmallestCam
from wucht.schema import TableModel


@dataclass(frozen=True)
class Outline:
    """Elements of a follower that are drawn at cam angle 0 beside its roller, in m; None where there is none.

    Parameters
    ----------
    pivot : float, optional
        Of a lever, on x.
    rod_offset : float, optional
        Of a rod with a roller, along y.
    face_from, face_to : float, optional
        The range of y in which a face is touched over a turn.
    face_at : float, optional
        Position of the face on x.
    """

    pivot: float | None = None
    rod_offset: float | None = None
    face_from: float | None = None
    face_to: float | None = None
    face_at: float | None = None


class Follower(TableModel, ABC):
    """A follower of some kind.

    Its motion is an angle on a lever, a length on a rod (``unit``); a smaller or larger cam changes its keys ``placing``.
    """

    unit: ClassVar[str] = "m"
    placing: ClassVar[tuple[str, ...]] = ()

    clockwise: StrictBool = Field(default=False, description="sense of rotation of the cam, true for clockwise")

    @classmethod
    def error_location(cls) -> str:
        """Return its path in a file."""
        return "follower"

    @abstractmethod
    def make_cams(self, law: Law) -> dict[str, Cam]:
        """Make the cams, by name, that make it move by a law: ``cam``; with a counter cam ``counter``, in a groove ``outer``.

        Raises ``InputError`` where it would lose its cams.
        """

    @abstractmethod
    def place(self, value: np.ndarray) -> np.ndarray:
        """Return the position of its roller or face for a value of the law (any shape), complex or along x, in m."""

    @abstractmethod
    def motion_on(self, contour: MilledContour, rotation: np.ndarray, guess: np.ndarray) -> np.ndarray:
        """See ``ContourFollower``: its motion on a milled contour."""

    @property
    def output_arm(self) -> float | None:
        """Length in m of the arm by which it turns; None where it slides."""
        return None

    def outline(self, law: Law) -> Outline:
        """Return the elements that are drawn of it beside its roller where it moves by a law."""
        return Outline()

    def smallest_cam(self, law: Law, limits: CamLimits, size: Size) -> SmallestCam | None:
        """Return the smallest cam of a law within the permitted limits; None where no limit is given that determines its size.

        Raises ``InputError`` (the key of ``limits``), ``RunError``.
        """
        return None

    def with_placement(self, placement: Mapping[str, float]) -> tuple[Self, tuple[str, ...]]:
        """Return the follower with other values of the keys ``placing``, and notes on values that must be chosen anew."""
        return self.model_copy(update=dict(placement)), ()
