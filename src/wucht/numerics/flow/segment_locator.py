"""The segments in use: at the start of a run, and where Python decides what happens at an instant."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.numerics.flow.events import NOT_FINITE, LegError
from wucht.numerics.flow.segments import Segmentation, indices_in
from wucht.numerics.flow.system_code import SystemCode
from wucht.system import System


@dataclass(frozen=True, eq=False)
class SegmentLocator:
    """Locator of the segments in use at a time and state.

    state_indices: for each argument, the indices of the states (the time last) from which it is computed.
    """

    code: SystemCode
    state_indices: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, code: SystemCode, smooth: System) -> SegmentLocator:
        """Make the locator of a smooth System."""
        return cls(code, indices_in([s.argument for s in code.segmentations.segmentations], smooth))

    @property
    def segmentations(self) -> tuple[Segmentation, ...]:
        """Those of the System."""
        return self.code.segmentations.segmentations

    def start(self, time: float, state: np.ndarray, parameter_values: np.ndarray) -> np.ndarray:
        """Return the values of the additional parameters at the start of a run. parameter_values: those of the System."""
        segments, sizes = [0] * len(self.segmentations), self._sizes(time, state)
        for _ in self.segmentations:  # an argument may depend on another one's segment; rates may be infinite on wrong ones
            instant = self.code.instant.at(time, state, np.concatenate([parameter_values, self._values(segments)]))
            arguments = self._finite(instant)
            segments = [x.locate(h, h, size) for x, h, size in zip(self.segmentations, arguments, sizes, strict=True)]
        for _ in range(len(self.segmentations) + 1):
            arguments, ahead = self._lookahead(time, state, np.concatenate([parameter_values, self._values(segments)]))
            segments = [x.locate(*at) for x, *at in zip(self.segmentations, arguments, ahead, sizes, strict=True)]
        return self._values(segments, arguments, sizes)

    def values_after_event(
        self, time: float, state: np.ndarray, parameter_values: np.ndarray, values: np.ndarray, event: tuple[int, int] | None
    ) -> np.ndarray:
        """Return the values after an event: the segmentation that reached an end of its segment and the direction, or None.

        Where two arguments reach a breakpoint together only one event may be reported, and an argument that has just passed a
        breakpoint may by rounding lie before it: so the other segments are located from their arguments now and a little later.
        """
        segments = self.numbers(values)
        if event is not None:
            segments[event[0]] += event[1]
        sizes, first_arguments = self._sizes(time, state), None
        for _ in range(len(segments) + 1):  # an argument may depend on another one's segment
            arguments, ahead = self._lookahead(time, state, np.concatenate([parameter_values, self._values(segments)]))
            first_arguments, before = first_arguments or arguments, segments.copy()
            for i, segmentation in enumerate(self.segmentations):
                if event is None or i != event[0] or arguments[i] != first_arguments[i]:
                    segments[i] = segmentation.locate(arguments[i], ahead[i], sizes[i])
            if segments == before:
                break
        return self._values(segments, arguments, sizes)

    def right_values(self, time: float, state: np.ndarray, parameter_values: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the values on the arguments' segments as outputs use them: on the right of each breakpoint."""
        arguments, _ = self._lookahead(time, state, np.concatenate([parameter_values, values]))
        return self._values(
            [int(np.searchsorted(x.breakpoints, h, side="right")) for x, h in zip(self.segmentations, arguments, strict=True)]
        )

    def numbers(self, values: np.ndarray) -> list[int]:
        """Return the number of the segment in use of each segmentation, from the values of the additional parameters."""
        segments, at, numbers = [], 0, values.tolist()
        for segmentation in self.segmentations:
            low, has_low = numbers[at], numbers[at + 2]
            segments.append(segmentation.nearest(low) + 1 if has_low else 0)
            at += len(segmentation.symbols)
        return segments

    @cached_property
    def tables(self) -> dict[str, np.ndarray]:
        """What the stepper reads to change segments, by the names of its memory."""
        parts = self.segmentations
        return {
            "segment_rows": np.concatenate([x.rows.ravel() for x in parts]),
            "segment_begins": np.cumsum([0, *(x.rows.size for x in parts[:-1])]),
            "segment_places": np.cumsum([0, *(len(x.symbols) for x in parts)]),
            "breakpoints": np.concatenate([x.breakpoints for x in parts]),
            "breakpoint_begins": np.cumsum([0, *(len(x.breakpoints) for x in parts)]),
            "scales": np.array([x.scale for x in parts]),
            "size_states": np.array([i for indices in self.state_indices for i in indices], np.int64),
            "size_begins": np.cumsum([0, *map(len, self.state_indices)]),
        }

    def _lookahead(self, time: float, state: np.ndarray, parameter_values: np.ndarray) -> tuple[list[float], list[float]]:
        now, ahead = self.code.lookahead(time, state, parameter_values)
        return self._finite(now), self._finite(ahead)

    def _finite(self, instant_values: np.ndarray) -> list[float]:
        """Return the arguments among the values of an instant. Raises ``LegError`` where one is not finite."""
        arguments = self.code.arguments(instant_values)
        if not np.isfinite(arguments).all():
            raise LegError(*NOT_FINITE, np.empty((len(self.code.is_angle), 0)))
        values: list[float] = arguments.tolist()
        return values

    def _sizes(self, time: float, state: np.ndarray) -> list[float]:
        """Return the largest number from which each argument is computed: its rounding is a few units of that."""
        values = np.append(np.abs(state), abs(time))
        return [float(values[list(index)].max(initial=0.0)) for index in self.state_indices]

    def _values(
        self, segments: Sequence[int], arguments: Sequence[float] | None = None, sizes: Sequence[float] | None = None
    ) -> np.ndarray:
        at, n = arguments or itertools.repeat(None), sizes or itertools.repeat(1.0)
        blocks = (x.segment(r, h, size) for x, r, h, size in zip(self.segmentations, segments, at, n, strict=False))
        return np.array([v for segment in blocks for v in segment])
