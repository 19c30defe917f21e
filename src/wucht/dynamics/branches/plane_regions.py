"""Curves of a plane, the regions between them, and the kind of each region, from examined places."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.numerics.zeros_and_peaks import values_at_passages

Range = tuple[float, float]
Bounds = tuple[Range, Range]  # of both parameters of a plane

COINCIDE, DOUBLE = "two folds at once", "two-saddle-nodes-connected"  # kinds of points
NOT_DECIDED = "not-decided"  # kind of a region: between places that differ, where no curve separates them

_FINE = 240  # pixels a side
_SMALLEST = 6e-4  # of the plane: a smaller region belongs to its neighbour
_EDGE = 4  # pixels
_BESIDE = 3.0  # pixels: distance from a curve at which the kinds on its sides are read
_NEAR = 0.3  # of a cell: places that differ without a curve between them are examined until they are as near as this
_BETWEEN = 1 / 3  # of the way between two places that differ: its middle is not decided


def cell_centres(bounds: Range, cells: int) -> np.ndarray:
    """Return the centres (cells,) of equal cells between bounds."""
    low, high = bounds
    return np.asarray(low + (high - low) * (np.arange(cells) + 0.5) / cells)


def cell_size(bounds: Bounds, cells: int) -> Range:
    """Return width and height of equal cells, so many a side, between bounds."""
    (x0, x1), (y0, y1) = bounds
    return (x1 - x0) / cells, (y1 - y0) / cells


@dataclass(frozen=True)
class PlaneCurve:
    """Curve of the plane.

    kind: of the bifurcation on it. x, y (N,): its points. value (N,): of a third parameter there, empty where there is none.
    """

    kind: str
    x: np.ndarray
    y: np.ndarray
    value: np.ndarray = field(default_factory=lambda: np.empty(0))

    def passes(self, x: float, y: float, near: float) -> bool:
        """True if it passes within a distance of a place, in the first parameter."""
        return bool((np.abs(values_at_passages(self.y, y, self.x)[1] - x) < near).any())

    def ends_before(self, x: float, y: float, near: tuple[float, float]) -> bool:
        """True if one of its ends lies so near to a place, in both parameters, without reaching it."""
        k = int(np.abs(self.y - y).argmin())
        return bool(k in (0, len(self.y) - 1) and 0 < abs(self.y[k] - y) < near[1] and abs(self.x[k] - x) < near[0])

    def passes_between(self, a: tuple[float, float], b: tuple[float, float]) -> bool:
        """True if it crosses the straight line between two places."""
        way, x, y = np.array([b[0] - a[0], b[1] - a[1]]), self.x - a[0], self.y - a[1]
        beside = x * way[1] - y * way[0]
        along = (x * way[0] + y * way[1]) / (way @ way)
        _, crossings = values_at_passages(beside, 0.0, along)
        return bool(((crossings >= 0) & (crossings <= 1)).any())


@dataclass(frozen=True)
class PlanePoint:
    """Point of the plane where curves meet. value: of a third parameter there, nan where there is none."""

    kind: str
    x: float
    y: float
    value: float = math.nan


@dataclass(frozen=True, eq=False)
class PlaneRegions:
    """Regions of a plane. index (rows, columns): number of the region at each place; x (columns,), y (rows,): the places."""

    index: np.ndarray
    x: np.ndarray
    y: np.ndarray

    @property
    def count(self) -> int:
        """Number of regions."""
        return int(self.index.max()) + 1

    def region_at(self, x: float, y: float) -> int:
        """Return the region of a place."""
        return int(self.index[np.abs(self.y - y).argmin(), np.abs(self.x - x).argmin()])

    def is_near_edge(self, x: float, y: float) -> bool:
        """True if another region is so near to a place that the place might belong to it."""
        column, row = int(np.abs(self.x - x).argmin()), int(np.abs(self.y - y).argmin())
        around = self.index[max(row - _EDGE, 0) : row + _EDGE + 1, max(column - _EDGE, 0) : column + _EDGE + 1]
        return bool((around != self.index[row, column]).any())

    def innermost_point(self, region: int) -> tuple[float, float]:
        """Return the place of a region that is farthest from its edge."""
        from scipy.ndimage import distance_transform_edt

        inside = np.pad(self.index == region, 1)
        row, column = np.unravel_index(int(distance_transform_edt(inside)[1:-1, 1:-1].argmax()), self.index.shape)
        return float(self.x[column]), float(self.y[row])


def divide_plane(curves: Sequence[tuple[np.ndarray, np.ndarray]], bounds: Sequence[tuple[float, float]]) -> PlaneRegions:
    """Return the regions between curves, each given by its x and y (N,), of a plane with these bounds."""
    from scipy.ndimage import distance_transform_edt, label

    (x0, x1), (y0, y1) = bounds
    wall = np.zeros((_FINE, _FINE), bool)
    for x, y in curves:
        across, up = (x - x0) / (x1 - x0) * _FINE, (y - y0) / (y1 - y0) * _FINE
        for a, b, c, d in zip(across[:-1], up[:-1], across[1:], up[1:], strict=True):
            share = np.linspace(0.0, 1.0, int(4 * max(abs(c - a), abs(d - b))) + 2)
            column, row = np.floor(a + share * (c - a)).astype(int), np.floor(b + share * (d - b)).astype(int)
            inside = (column >= 0) & (column < _FINE) & (row >= 0) & (row < _FINE)
            wall[row[inside], column[inside]] = True
    index, count = label(~wall)
    sizes = np.bincount(index.ravel(), minlength=count + 1)
    large = np.flatnonzero(sizes >= _SMALLEST * wall.size)
    large = large[large > 0]
    if not len(large):
        index, large = np.ones_like(index), np.array([1])
    number = np.full(max(count, 1) + 1, -1)
    number[large] = np.arange(len(large))
    index = number[index]
    nearest = distance_transform_edt(index < 0, return_distances=False, return_indices=True)
    index = index[tuple(nearest)]
    centres = (np.arange(_FINE) + 0.5) / _FINE
    return PlaneRegions(index, x0 + centres * (x1 - x0), y0 + centres * (y1 - y0))


def kinds_by_region(
    partition: PlaneRegions, places: Sequence[tuple[float, float, str]]
) -> tuple[list[str], list[tuple[float, float, str]]]:
    """Return the kind of each region by the majority of places (x, y, kind) in it, "" where there is none.

    Returns also the places that contradict it, except for those at an edge.
    """
    votes = [Counter[str]() for _ in range(partition.count)]
    for x, y, kind in places:
        votes[partition.region_at(x, y)][kind] += 1
    kinds = [v.most_common(1)[0][0] if v else "" for v in votes]
    return kinds, [
        p for p in places if kinds[partition.region_at(p[0], p[1])] != p[2] and not partition.is_near_edge(p[0], p[1])
    ]


def divided_by_places(
    partition: PlaneRegions, kinds: Sequence[str], places: Sequence[tuple[float, float, str]], cell: Range
) -> tuple[PlaneRegions, list[str]]:
    """Divide regions whose places (x, y, kind) differ although no curve separates them; return the regions and their kinds.

    Each part has the kind of its nearest place; the middle third of the way between two that differ is ``NOT_DECIDED``.
    kinds: of the regions, as from ``kinds_by_region``. cell: width and height in which distances are measured.
    """
    index, kinds = partition.index.copy(), list(kinds)
    inner = [p for p in places if not partition.is_near_edge(p[0], p[1])]
    for region in range(partition.count):
        by_kind: dict[str, list[tuple[float, float]]] = {}
        for x, y, kind in inner:
            if partition.region_at(x, y) == region:
                by_kind.setdefault(kind, []).append((x, y))
        if len(by_kind) < 2:
            continue
        rows, columns = np.nonzero(partition.index == region)
        pixels = np.stack([partition.x[columns], partition.y[rows]], axis=1) / cell
        index[rows, columns] = len(kinds) + _nearest_kind(pixels, [np.array(at) / cell for at in by_kind.values()])
        kinds += [*by_kind, NOT_DECIDED]
    numbers, new_index = np.unique(index, return_inverse=True)
    return replace(partition, index=new_index.reshape(index.shape)), [kinds[k] for k in numbers]


def _nearest_kind(pixels: np.ndarray, places_by_kind: Sequence[np.ndarray]) -> np.ndarray:
    """Return the number of the kind whose place is nearest to each pixel (N, 2); between kinds, their number.

    places_by_kind: of each kind its places (M, 2).
    """
    from scipy.spatial import cKDTree

    queries = [cKDTree(places).query(pixels) for places in places_by_kind]
    distances = np.array([distance for distance, _ in queries])
    nearest = np.array([places[i] for places, (_, i) in zip(places_by_kind, queries, strict=True)])
    order, pixel = np.argsort(distances, axis=0)[:2], np.arange(len(pixels))
    apart = np.linalg.norm(nearest[order[0], pixel] - nearest[order[1], pixel], axis=1)
    difference = distances[order[1], pixel] - distances[order[0], pixel]
    return np.where(difference < _BETWEEN * apart, len(places_by_kind), order[0])


def widest_difference(
    partition: PlaneRegions, places: Sequence[tuple[float, float, str]], cell: Range
) -> tuple[float, float] | None:
    """Return the middle between two neighbours that differ, the farthest apart of places (x, y, kind) of one region.

    Neighbours are nearest to each other among the differing ones, and no other region lies between them. cell: width and
    height in rows_of_places distances are measured. None where all of them are nearer than ``_NEAR``.
    """
    inner = [(*p, partition.region_at(p[0], p[1])) for p in places if not partition.is_near_edge(p[0], p[1])]
    if not inner:
        return None
    at = np.array([p[:2] for p in inner])
    kinds, regions = (np.unique([p[k] for p in inner], return_inverse=True)[1] for k in (2, 3))
    distances = np.linalg.norm((at[:, None] - at) / cell, axis=-1)
    distances[(kinds[:, None] == kinds) | (regions[:, None] != regions)] = np.inf
    nearest = distances.argmin(axis=1)
    away = distances[np.arange(len(at)), nearest]
    away[away > away[nearest]] = 0.0  # its nearest place has a nearer one
    for k in np.argsort(-away).tolist():
        x, y = ((at[k] + at[nearest[k]]) / 2).tolist()
        if _NEAR < away[k] < np.inf and partition.region_at(x, y) == inner[k][3] and not partition.is_near_edge(x, y):
            return x, y
    return None


def sides_of(partition: PlaneRegions, kinds: Sequence[str], x: np.ndarray, y: np.ndarray) -> list[tuple[str, str]]:
    """Return the kinds of the regions left and right of the points (N,) of a curve."""
    dx, dy = partition.x[1] - partition.x[0], partition.y[1] - partition.y[0]
    along = np.gradient(np.array([x / dx, y / dy]), axis=1) if len(x) > 1 else np.ones((2, 1))
    across = np.array([-along[1], along[0]]) / np.maximum(np.linalg.norm(along, axis=0), 1e-12) * _BESIDE
    return [
        (kinds[partition.region_at(a + p * dx, b + q * dy)], kinds[partition.region_at(a - p * dx, b - q * dy)])
        for a, b, p, q in zip(x, y, *across, strict=True)
    ]
