"""What a map is made of, whichever it is: lines, points, places and regions; and what plans of maps have in common."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

import numpy as np

from wucht.dynamics.branches.plane_regions import Bounds, PlaneCurve, PlanePoint, Regions
from wucht.dynamics.work import Work
from wucht.schema import Parameter

MODULATED = "modulated motion"
UNKNOWN = "not identified"


@dataclass(frozen=True)
class Place:
    """A place that was examined, with what is the case there. begins, ends: values of the third parameter."""

    x: float
    y: float
    label: str
    begins: float = math.nan
    ends: float = math.nan


@dataclass(frozen=True, eq=False)
class MapParts:
    """Of a map. lines: boundaries by name, the kind being what they are drawn by. labels, tones, hatches: of its regions;
    everywhere: names of states that are stable in all of them.

    against: places that say otherwise than their region. lost: sentences on what is missing. runs: by which places are checked.
    """

    lines: Mapping[str, PlaneCurve]
    marks: tuple[PlanePoint, ...]
    places: tuple[Place, ...]
    areas: Regions
    labels: tuple[str, ...]
    tones: tuple[int, ...]
    hatches: tuple[int, ...]
    everywhere: tuple[str, ...] = ()
    against: tuple[Place, ...] = ()
    lost: tuple[str, ...] = field(default_factory=tuple)
    runs: int = 0


class MapFindings(Protocol):
    """complete: nothing is left to do."""

    @property
    def complete(self) -> bool: ...  # noqa: D102


F = TypeVar("F", bound=MapFindings)


@dataclass(frozen=True, eq=False)
class MapPlan(ABC, Generic[F]):
    """What is to be done, and what is made of it.

    along, second: the parameters of the plane, with their bounds. warnings: what is doubtful about the equations. third: the
    parameter whose values lines, marks and places have, if there is one; ends: its range, empty without one.
    """

    along: Parameter
    second: Parameter
    bounds: Bounds
    warnings: tuple[str, ...]
    third: Parameter | None
    ends: tuple[float, ...]

    @abstractmethod
    def run(self, work: Work) -> Iterator[F]:
        """The findings, each more complete than those before."""

    @abstractmethod
    def parts(self, findings: F) -> MapParts:
        """The map."""

    @abstractmethod
    def sentence(self, parts: MapParts, areas: Mapping[str, float]) -> str:
        """The answer. areas: the share of the plane of each label, the largest first."""


def shares(areas: Regions, labels: Sequence[str]) -> dict[str, float]:
    """Of the plane that each label has."""
    sizes = np.bincount(areas.index.ravel(), minlength=areas.count) / areas.index.size
    return {label: float(sizes[[k for k, each in enumerate(labels) if each == label]].sum()) for label in dict.fromkeys(labels)}


def by_name(curves: Sequence[PlaneCurve]) -> dict[str, PlaneCurve]:
    """Curves by their kinds, those of one kind with numbers: ``fold: together``, ``fold: together (2)``."""
    count, named = Counter[str](), dict[str, PlaneCurve]()
    for curve in curves:
        count[curve.kind] += 1
        named[curve.kind if count[curve.kind] == 1 else f"{curve.kind} ({count[curve.kind]})"] = curve
    return named
