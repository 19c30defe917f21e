"""A new study is one folder, or one file like this: the poles of a machine's carrier, their frequency and damping.

wucht run practice/laundry-drum --import examples/own_study.py --set study.kind=poles
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from wucht.extending import (
    COLOURS,
    SI,
    InputError,
    Machine,
    Quantity,
    ReportLines,
    Spec,
    Vibration,
    Work,
    label,
    legend_beside,
    new_figure,
    result_dataset,
    si,
    table,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Poles(Spec):
    """Natural vibrations of the carrier, with its bodies at rest on it."""

    kind: ClassVar[str] = "poles"

    below: SI[float | None] = si("rad/s", "speed", default=None, gt=0, help="only poles of a smaller angular frequency")


@dataclass(frozen=True)
class Plan:
    """M, C, K of the carrier, and the limit of the frequency."""

    vibration: Vibration
    below: float
    unit: str


@dataclass(frozen=True)
class Findings:
    """The poles (n,) in the upper half plane, the slowest first, in 1/time."""

    poles: np.ndarray


def prepare(spec: Poles, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` for a carrier that cannot vibrate."""
    if not machine.free_carrier:
        raise InputError("machine.carrier", None, "cannot vibrate in any direction")
    return Plan(Vibration.of(machine), spec.below or np.inf, machine.units.speed)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compute the poles in one unit of work."""
    yield work.unit("poles", lambda: Findings(_upper(plan)))


def _upper(plan: Plan) -> np.ndarray:
    poles = plan.vibration.poles
    poles = poles[(poles.imag >= 0) & (np.abs(poles) < plan.below)]
    return poles[np.argsort(np.abs(poles))]


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Return the results; the meaning and the unit of each number are stated only here."""
    size = np.abs(findings.poles)
    damping = -findings.poles.real / size
    poles = [{"frequency": w, "damping": d} for w, d in zip(size.tolist(), damping.tolist(), strict=True)]
    parts = {"frequency": ("natural frequency", plan.unit), "damping": ("damping ratio", "")}
    quantities = [
        *table("poles", poles, "natural vibrations", parts, "pole", {"frequency": float, "damping": float}),
        Quantity("pole_rate", findings.poles.real, "growth rate", plan.unit.replace("rad", "1"), "pole"),
    ]
    return result_dataset(quantities, f"{len(size)} poles; the least damped has a damping ratio of {damping.min():.4g}")


def figure(result: xr.Dataset) -> Figure:
    """Draw the poles in the complex plane."""
    sheet, (axis,) = new_figure(1, result.attrs["title"], result.attrs["sentence"], 3.0)
    rate, frequency = result.pole_rate.values, result.pole_frequency.values
    axis.plot(rate, np.sqrt(frequency**2 - rate**2), "x", color=COLOURS[0], label="poles")
    axis.set_xlabel(label(result, "pole_rate"))
    axis.set_ylabel(label(result, "pole_frequency"))
    legend_beside(axis)
    return sheet


def report(result: xr.Dataset) -> list[str]:
    """Return a line for each pole."""
    lines = ReportLines(result)
    for pole in result.wucht.summary["poles"]:
        lines.add("pole", "{frequency}, damping ratio {damping}", pole, "poles")
    return lines.report(result.wucht.sentence)
