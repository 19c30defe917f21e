"""The voltage that an inverter gives with a frequency: V/f control."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from wucht.piecewise import Pieces


def proportional_voltage(name: str, frequency: Pieces, rated: tuple[float, float], boost: float) -> Pieces:
    """The voltage over time that belongs to a frequency over time.

    It rises in a straight line from ``boost`` at 0 Hz to the rated voltage at the rated frequency, which holds above it, where
    the field is weakened. rated: frequency in Hz and voltage in V. The corner is a breakpoint.
    """
    limit, full = rated
    slope = (full - boost) / limit
    places = sorted({*frequency.breakpoints, *_crossings(frequency, limit)})
    inside = [(0.5 * (a + b), a) for a, b in pairwise(places)]
    looked_at = [(places[0] - 1.0, places[0]), *inside, (places[-1] + 1.0, places[-1])]
    coefficients = []
    for within, origin in looked_at:
        piece = int(np.searchsorted(frequency.breakpoints, within, side="right"))
        shifted = _about(frequency, piece, origin)
        below = frequency(within) < limit
        coefficients.append((boost + slope * shifted[0], *(slope * c for c in shifted[1:])) if below else (full, 0.0, 0.0, 0.0))
    return Pieces(name, places, coefficients)


def _about(pieces: Pieces, piece: int, origin: float) -> tuple[float, float, float, float]:
    """The cubic of a piece as a polynomial in the distance from another origin."""
    c0, c1, c2, c3 = pieces.coefficients[piece]
    s = origin - pieces.origins[piece]
    return c0 + s * (c1 + s * (c2 + s * c3)), c1 + s * (2 * c2 + 3 * s * c3), c2 + 3 * s * c3, c3


def _crossings(pieces: Pieces, limit: float) -> list[float]:
    """Where the function passes a limit between its breakpoints."""
    found = []
    for k, (low, high) in enumerate(pairwise(pieces.breakpoints), 1):
        c0, c1, c2, c3 = pieces.coefficients[k]
        roots = np.polynomial.Polynomial([c0 - limit, c1, c2, c3]).trim().roots()
        real = low + roots[np.abs(roots.imag) < 1e-12].real
        margin = 1e-9 * (high - low)  # closer to a breakpoint it is that one
        found += real[(real > low + margin) & (real < high - margin)].tolist()
    return found
