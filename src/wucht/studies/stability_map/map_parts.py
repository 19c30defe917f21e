"""The parts of a map: lines, points, places and regions; and the common base of plans of maps."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

import numpy as np

from wucht.dynamics.branches.plane_regions import Bounds, PlaneCurve, PlanePoint, PlaneRegions
from wucht.dynamics.sampling.label_maps import share, uncertainty
from wucht.dynamics.work import Work
from wucht.schema import Parameter

MODULATED_MOTION, PERIODIC_ORBIT = "modulated motion", "periodic orbit"  # of a machine, and of user equations
UNKNOWN = "not identified"
NOT_EXAMINED = "not examined"
NOTHING_ELSE, NO_OTHER_STATE = "nothing else", "no other steady state"
UNDECIDED_TONE = 4
_LEVEL = 0.05  # probability with which what exists in a larger share of the plane is missed at all places


@dataclass(frozen=True)
class MapPlace:
    """An examined place, with its motions. begins, ends: values of the third parameter."""

    x: float
    y: float
    label: str
    begins: float = math.nan
    ends: float = math.nan


@dataclass(frozen=True, eq=False)
class MapParts:
    """The parts of a map. lines: boundaries by name, the kind being their style. labels, tones, hatches: of its regions;
    everywhere: names of states that are stable in all of them.

    contradictions: places that no line separates from others of another kind. omissions: sentences on missing parts. runs:
    number of checking runs. searches: number of places at which all motions were sought.
    """

    lines: Mapping[str, PlaneCurve]
    marks: tuple[PlanePoint, ...]
    places: tuple[MapPlace, ...]
    areas: PlaneRegions
    labels: tuple[str, ...]
    tones: tuple[int, ...]
    hatches: tuple[int, ...]
    everywhere: tuple[str, ...] = ()
    contradictions: tuple[MapPlace, ...] = ()
    omissions: tuple[str, ...] = field(default_factory=tuple)
    runs: int = 0
    searches: int = 0

    def uncertainty(self, label: str, by_resolution: float) -> float:
        """Return the uncertainty of a label's share: that of absence contains what may be missed."""
        return max(by_resolution, self.detection_limit) if label in (NOTHING_ELSE, NO_OTHER_STATE) else by_resolution

    @property
    def detection_limit(self) -> float:
        """Share of the plane below which a motion may be missed at all places."""
        return detection_limit(self.searches)


def detection_limit(places: int) -> float:
    """Return the share of the plane below which a motion may exist without being detected at any place, in 19 of 20 cases.

    Of n places that lie at random to what is narrower than their distances, all miss a share s with probability (1 - s)^n.
    """
    return float(1 - _LEVEL ** (1 / places)) if places else 1.0


class MapFindings(Protocol):
    """Findings of a map. complete: True if nothing is left to do."""

    @property
    def complete(self) -> bool: ...  # noqa: D102


F = TypeVar("F", bound=MapFindings)


@dataclass(frozen=True, eq=False)
class MapPlan(ABC, Generic[F]):
    """A plan of a map.

    along, second: the parameters of the plane, with their bounds. warnings: doubts about the equations. third: the
    parameter whose values lines, marks and places have, if there is one; ends: its range, empty without one. motion: the name
    of a motion that is periodic but not steady.
    """

    along: Parameter
    second: Parameter
    bounds: Bounds
    warnings: tuple[str, ...]
    third: Parameter | None
    ends: tuple[float, ...]
    motion: str = field(default=MODULATED_MOTION, kw_only=True)

    @abstractmethod
    def run(self, work: Work) -> Iterator[F]:
        """Yield the findings, each more complete than those before."""

    @abstractmethod
    def parts(self, findings: F) -> MapParts:
        """Return the parts of the map."""

    @abstractmethod
    def sentence(self, parts: MapParts, areas: Mapping[str, float]) -> str:
        """Return the answer as a sentence. areas: the share of the plane of each label, the largest first."""


def plane_shares(areas: PlaneRegions, labels: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the share of the plane of each label, and its uncertainty in 19 of 20 cases, by the resolution of the regions."""
    shares = {}
    for label in dict.fromkeys(labels):
        inside = np.isin(areas.index, [k for k, region_label in enumerate(labels) if region_label == label])
        shares[label] = share(inside), uncertainty(inside, (False, False))
    return shares


def curves_by_name(curves: Sequence[PlaneCurve]) -> dict[str, PlaneCurve]:
    """Return curves by their kinds, those of one kind with numbers: ``fold: together``, ``fold: together (2)``."""
    count, named_curves = Counter[str](), dict[str, PlaneCurve]()
    for curve in curves:
        count[curve.kind] += 1
        named_curves[curve.kind if count[curve.kind] == 1 else f"{curve.kind} ({count[curve.kind]})"] = curve
    return named_curves
