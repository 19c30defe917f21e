"""What is seen of a motion is the same to the last bit, however it is cut into parts."""

from dataclasses import fields, is_dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from wucht.numerics.observers import records
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.records import SpanRecord, TurnRecord
from wucht.numerics.observers.turns import Samples, TurnObserver, Turns


def motion(legs, samples_a_turn, seed):
    """A body that turns on, stands, turns back, in so many samples each, with two followers and a distance.

    What the records do with it does not depend on whether speeds are the derivatives of angles: they are drawn at random.
    """
    draw = np.random.default_rng(seed)
    senses = np.concatenate([np.full(count, sense) for sense, count in legs])
    n = len(senses) + 1
    leader = 2 * np.pi / samples_a_turn * np.append(0, np.cumsum(senses))
    time = np.cumsum(draw.uniform(0.5, 1.5, n))
    speed = np.append(senses, 0) * np.append(0, senses**2) * draw.uniform(0.0, 1.5, n) * 2 * np.pi / samples_a_turn
    others = [(leader + np.cumsum(draw.normal(0, s, n)), speed + draw.normal(0, s, n)) for s in (0.01, 0.2)]
    samples = Samples.of(time, (leader, speed), *others)
    return replace(samples, square=draw.uniform(1.0, 2.0, n), rate=draw.normal(0, 1, n))


def parts(samples, cuts, overlap):
    """With ``overlap``, a part begins with the last sample of the part before."""
    n = len(samples.time)
    borders = [0, *sorted(cut % n for cut in cuts), n]
    return [samples.part(slice(max(a - overlap, 0), b)) for a, b in pairwise(borders)]


def observed(samples_in_parts):
    observer, found = TurnObserver(), []
    for part in samples_in_parts:
        observer, turns = observer.update(part)
        found.append(turns)
    return Turns.join(*found)


def recorded(record, samples_in_parts):
    """With short levels of the records, so that there are several."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(records, "LEVEL_BLOCKS", 16)
        for part in samples_in_parts:
            record = record.update(part)
    return record


def same(a, b):
    """Equal to the last bit, all the way down."""
    if is_dataclass(a):
        return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return np.array_equal(a, b)


WEIGHTS = (1.0, 0.37 + 0.21j, -0.13 - 0.31j)
LEGS = st.lists(st.tuples(st.sampled_from([1, 1, -1, 0]), st.integers(1, 150)), min_size=1, max_size=5)
CUTS = st.lists(st.integers(0, 10_000), max_size=8)
ANY_MOTION = given(LEGS, st.sampled_from([24, 32, 25.3]), st.integers(0, 100), CUTS, st.booleans())
# Cuts that matter lie anywhere: a smaller example would not tell more.
FEW = settings(deadline=None, max_examples=60, phases=[Phase.generate])


@FEW
@ANY_MOTION
def test_turns(legs, samples_a_turn, seed, cuts, overlap):
    samples = motion(legs, samples_a_turn, seed)
    assert same(observed([samples]), observed(parts(samples, cuts, overlap)))


@FEW
@ANY_MOTION
def test_turn_records(legs, samples_a_turn, seed, cuts, overlap):
    samples, record = motion(legs, samples_a_turn, seed), TurnRecord(2, WEIGHTS)
    whole, cut = recorded(record, [samples]), recorded(record, parts(samples, cuts, overlap))
    assert same((whole.pyramid, whole.passage, whole.sense), (cut.pyramid, cut.passage, cut.sense))


@FEW
@ANY_MOTION
def test_span_records(legs, samples_a_turn, seed, cuts, overlap):
    samples, record = motion(legs, samples_a_turn, seed), SpanRecord(15.0)
    assert same(recorded(record, [samples]), recorded(record, parts(samples, cuts, overlap)))


def test_the_distance_counts_while_the_leader_stands():
    samples = motion([(1, 100), (0, 30), (1, 100)], 24, 0)
    far = replace(samples, square=np.where(np.arange(231) == 115, 9.0, 1.0), rate=np.zeros(231))
    whole = observed([far])
    assert whole.largest.max() == 3.0
    assert same(whole.largest, observed(parts(far, [105, 125], False)).largest)


TIME = np.linspace(0, 5, 501)
STORED = 3 + 2 * np.cos(TIME)
SUPPLIED = np.array([4 * TIME, np.sin(TIME)])
LOST = SUPPLIED.sum(axis=0) - (STORED - STORED[0])


def residual(lost=LOST, shift=0.0):
    return EnergyBalance().update(STORED + shift, SUPPLIED, lost)[1]


def test_what_adds_up_leaves_no_residual():
    assert residual().max() < 1e-15


def test_the_residual_is_what_is_missing_over_the_largest_energy():
    assert residual(LOST + 1e-3)[-1] < 1e-15, "what was lost before is of no interest"
    missing = np.where(TIME > 2, 1e-3, 0.0)
    assert residual(LOST + missing)[-1] == pytest.approx(1e-3 / SUPPLIED.max(), rel=1e-9)
    assert residual(LOST + missing, shift=100.0)[-1] == pytest.approx(1e-3 / (100 + STORED.max()), rel=1e-9)


@pytest.mark.parametrize("cuts", [[250], [1, 2, 499]])
def test_it_is_the_same_in_parts_at_the_end(cuts):
    """A part begins with the last sample of the part before; the scale is the largest so far."""
    balance, missing = EnergyBalance(), LOST + 1e-3 * TIME
    for i, j in zip([0, *cuts], [*cuts, len(TIME) - 1], strict=True):
        part = slice(i, j + 1)
        balance, last = balance.update(STORED[part], SUPPLIED[:, part], missing[part])
    whole, each = EnergyBalance().update(STORED, SUPPLIED, missing)
    assert balance == whole
    assert last[-1] == each[-1]
