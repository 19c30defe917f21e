"""The members of an ensemble, their observers, and the results: arrays over the members."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import IntEnum
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from wucht.errors import RunError, WuchtError

R = TypeVar("R")


class Status(IntEnum):
    """Reason for which a member ended."""

    SETTLED = 0  # by its observer's decision
    LIMIT = 1  # it reached the limit of time
    FAILED = 2


@dataclass(frozen=True)
class Members:
    """Starts and parameter sets.

    Attributes
    ----------
    starts : ndarray, (M, n)
        States at time zero, in the System's order and units.
    parameter_values : ndarray, (M, p)
        Of the parameters, in the System's order and units.
    numbers : ndarray of int, (M,)
        In the ensemble.
    """

    starts: np.ndarray
    parameter_values: np.ndarray
    numbers: np.ndarray

    @classmethod
    def of(cls, starts: np.ndarray, parameter_values: np.ndarray | Sequence[float]) -> Members:
        """Combine starts (M, n) with parameters (M, p), or (p,) shared by all, which are not copied.

        Raises ``WuchtError`` where their shapes do not fit.
        """
        start_states, values = np.asarray(starts, float), np.asarray(parameter_values, float)
        if start_states.ndim != 2 or values.ndim not in (1, 2) or (values.ndim == 2 and len(values) != len(start_states)):
            shapes = f"starts of the shape {start_states.shape} and parameters of the shape {values.shape}"
            raise WuchtError(f"{shapes} do not fit: members need (M, n) and (M, p) or (p,)", code="shape")
        count = len(start_states)
        return cls(start_states, np.broadcast_to(values, (count, values.shape[-1])), np.arange(count))

    def __len__(self) -> int:
        return len(self.starts)

    def part(self, first: int, last: int) -> Members:
        """Return the members from ``first`` on, before ``last``."""
        selection = slice(first, last)
        return Members(self.starts[selection], self.parameter_values[selection], self.numbers[selection])


class Source(Protocol):
    """Source of members: ``Members``, or an object that makes them on request and stores none of them."""

    def __len__(self) -> int: ...
    def part(self, first: int, last: int) -> Members: ...  # noqa: D102


@dataclass(frozen=True)
class Chunk:
    """What is observed of L members in a chunk of time: the requested ``Quantities``, or the states where none are requested.

    Attributes
    ----------
    times : ndarray, (K,)
        Of the samples, of each member since its start; the last is the end.
    samples : ndarray, (K, v, L)
    peaks : ndarray, (p, L)
        The largest values of the quantities in ``Quantities.peaks`` since the start.
    """

    times: np.ndarray
    samples: np.ndarray
    peaks: np.ndarray

    def select(self, lanes: np.ndarray) -> Chunk:
        """Select some of the members, by their numbers."""
        return Chunk(self.times, np.take(self.samples, lanes, axis=-1), np.take(self.peaks, lanes, axis=-1))


class Observer(Protocol[R]):
    """Observer of members: its record is a frozen dataclass of arrays whose last axis is the member.

    It is called with any number of members at once, but never with one alone (then that one is passed twice), since NumPy adds
    the samples of one in another order than those of several: so sums over samples are the same to the last bit in any company.
    Its result for a member must not depend on the others. Several threads call it at once, each with other members.
    """

    def begin(self, members: Members) -> R:
        """Return the record before any sample."""
        ...

    def update(self, record: R, chunk: Chunk) -> tuple[R, np.ndarray]:
        """Update the record of L members by a chunk, and decide which have settled: the record, and (L,) of bool."""
        ...

    def final_record(self, record: R) -> R:
        """Reduce the record of members that have ended to its result, without intermediate quantities."""
        ...


class Pacing(Protocol):
    """Division of time, which begins at zero for each member, into chunks: the same for all of them."""

    @property
    def chunks(self) -> int:
        """Largest number of chunks."""
        ...

    def times(self, index: int) -> np.ndarray:
        """Return the beginning of a chunk and its sampling times (K + 1,), rising; the last is the next one's beginning."""
        ...


@dataclass(frozen=True)
class Pace:
    """Even chunks, sampled at the same places in each.

    Parameters
    ----------
    chunk : float
        Length of time after which the observer is updated. Each end cuts a step short: some hundred steps are a good length.
    samples : int
        K in each chunk, evenly spaced: the last at its end, none at its beginning.
    until : float
        The limit of time. The last chunk is shorter where this is not a multiple.

    Raises
    ------
    WuchtError
        For a chunk or limit that is not positive, or no sample.
    """

    chunk: float
    samples: int
    until: float

    def __post_init__(self) -> None:
        if not (0 < self.chunk < math.inf and 0 < self.until < math.inf and self.samples >= 1):
            raise WuchtError(f"{self}: chunk and until must be positive and finite, with at least one sample", code="pace")

    @property
    def chunks(self) -> int:
        """Largest number of chunks."""
        return max(1, math.ceil(self.until / self.chunk * (1 - 1e-12)))

    def times(self, index: int) -> np.ndarray:
        """Return the beginning of a chunk and its sampling times (K + 1,)."""
        end = self.until if index + 1 == self.chunks else (index + 1) * self.chunk
        return np.linspace(index * self.chunk, end, self.samples + 1)


@dataclass(frozen=True)
class EnsembleResult(Generic[R]):
    """Results of members.

    Attributes
    ----------
    times : ndarray, (M,)
        End time of each; of one that failed, the time of its last sample.
    states : ndarray, (M, n)
        At these times.
    status : ndarray of int8, (M,)
        ``Status`` of each.
    sentences : mapping of int to str
        Why a member failed, or the name of the event that stopped it, by its number.
    record : R
        The observer's, of all members: of one that failed or was stopped, up to the previous chunk.
    """

    times: np.ndarray
    states: np.ndarray
    status: np.ndarray
    sentences: Mapping[int, str]
    record: R

    def count(self, status: Status) -> int:
        """Count the members with a status."""
        return int((self.status == status).sum())

    @classmethod
    def join(cls, parts: Sequence[EnsembleResult[R]]) -> EnsembleResult[R]:
        """Join the results of at least one part, in order."""
        begins = np.cumsum([0, *(len(p.times) for p in parts)]).tolist()
        return EnsembleResult(
            np.concatenate([p.times for p in parts]),
            np.concatenate([p.states for p in parts]),
            np.concatenate([p.status for p in parts]),
            {first + i: s for first, p in zip(begins, parts, strict=False) for i, s in p.sentences.items()},
            joined_records([p.record for p in parts]),
        )


def checked_record(record: R, count: int) -> R:
    """Return the record. Raises ``RunError`` where it is not one of so many members."""
    if not is_dataclass(record) or any(np.shape(a)[-1:] != (count,) for a in _arrays(record).values()):
        raise RunError(
            f"an observer's record must be a frozen dataclass of arrays whose last axis has its {count} members", code="record"
        )
    return record


def select_members(record: R, lanes: np.ndarray) -> R:
    """Return the record of some of its members, by their numbers."""
    return type(record)(**{name: np.take(a, lanes, axis=-1) for name, a in _arrays(record).items()})


def joined_records(records: Sequence[R]) -> R:
    """Join at least one record into that of all members."""
    columns = {name: [_arrays(r)[name] for r in records] for name in _arrays(records[0])}
    return type(records[0])(**{name: np.concatenate(arrays, axis=-1) for name, arrays in columns.items()})


def _arrays(record: Any) -> dict[str, np.ndarray]:
    return {f.name: getattr(record, f.name) for f in fields(record)}
