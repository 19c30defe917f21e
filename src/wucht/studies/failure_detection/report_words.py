"""How soon a failure is seen, in words."""

from __future__ import annotations

_HOUR = 3600.0  # s


def duration(time: float, unit: str) -> str:
    """A time in its unit, from an hour on in hours too: ``5770 s (1.6 h)``."""
    hours = f" ({time / _HOUR:.3g} h)" if unit == "s" and abs(time) >= _HOUR else ""
    return f"{float(f'{time:.4g}'):g} {unit}".rstrip() + hours  # 17260, not 1.726e+04


def within(readings: int, time: float, unit: str) -> str:
    """As far as something is known: ``within 5,080 readings, 2540 s``."""
    return f"within {readings:,} readings, {duration(time, unit)}"


def counted_from(failure_time: float | None) -> str:
    """From when a delay counts."""
    return "the failure" if failure_time is not None else "the chart begins"
