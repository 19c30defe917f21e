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
    InputError,
    Machine,
    Spec,
    Vibration,
    Work,
    answered,
    formats,
    label,
    legend_beside,
    new_figure,
    si,
    summary_of,
    variable,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class Poles(Spec):
    """How the carrier vibrates when it is left alone, its bodies at rest on it.

    below: only poles of a smaller angular frequency.
    """

    kind: ClassVar[str] = "poles"

    below: float | None = si("rad/s", "speed", default=None, gt=0)


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
    """The plan. Raises ``InputError`` for a carrier that cannot vibrate."""
    if not machine.free_carrier:
        raise InputError("machine.carrier", None, "nothing here is free to vibrate")
    return Plan(Vibration.of(machine), spec.below or np.inf, machine.units.speed)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """One unit of work."""
    yield work.unit("poles", lambda: Findings(_upper(plan)))


def _upper(plan: Plan) -> np.ndarray:
    answer = plan.vibration.poles
    answer = answer[(answer.imag >= 0) & (np.abs(answer) < plan.below)]
    return answer[np.argsort(np.abs(answer))]


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """frequency and damping (pole): |lambda| and -Re lambda/|lambda|."""
    import xarray as xr_

    size = np.abs(findings.poles)
    damping = -findings.poles.real / size
    answer = xr_.Dataset(
        {
            "frequency": variable("pole", size, "natural frequency", plan.unit),
            "damping": variable("pole", damping, "damping ratio"),
            "rate": variable("pole", findings.poles.real, "growth rate", plan.unit.replace("rad", "1")),
        }
    )
    summary = {"frequencies": size.tolist(), "damping_ratios": damping.tolist()}
    return answered(answer, summary, f"{len(size)} poles; the least damped has a damping ratio of {damping.min():.4g}")


def figure(result: xr.Dataset) -> Figure:
    """The poles in the complex plane."""
    drawn, (axis,) = new_figure(1, result.attrs["title"], result.attrs["sentence"], 3.0)
    rate, frequency = result.rate.values, result.frequency.values
    axis.plot(rate, np.sqrt(frequency**2 - rate**2), "x", color=COLOURS[0], label="poles")
    axis.set_xlabel(label(result, "rate"))
    axis.set_ylabel(label(result, "frequency"))
    legend_beside(axis)
    return drawn


def report(result: xr.Dataset) -> list[str]:
    """A line a pole."""
    speed, _ = formats(result)
    summary = summary_of(result)
    pairs = zip(summary["frequencies"], summary["damping_ratios"], strict=True)
    return [result.attrs["title"], *(f"  {speed(w)}, damping ratio {d:.4g}" for w, d in pairs)]
