"""A new study is one class, in one file like this: the poles of a machine's carrier, their frequency and damping.

wucht run practice/laundry-drum --import examples/own_study.py --set study.kind=poles
"""

import numpy as np

from wucht.extending import COLOURS, SI, Answer, InputError, Study, Vibration, label, legend_beside, new_figure, si


class Poles(Study):
    """Natural vibrations of the carrier, with its bodies at rest on it."""

    kind = "poles"

    below: SI[float | None] = si("rad/s", "speed", default=None, gt=0, help="only poles of a smaller angular frequency")

    def prepare(self, machine):
        """Return M, C, K of the carrier. Raises ``InputError`` for a carrier that cannot vibrate."""
        if not machine.free_carrier:
            raise InputError("machine.carrier", None, "cannot vibrate in any direction")
        return Vibration.of(machine)

    def solve(self, machine, vibration, work):
        """State the poles in the upper half plane, the slowest first."""
        a, poles = Answer(machine.units), work.unit("poles", lambda: vibration.poles)
        poles = poles[(poles.imag >= 0) & (np.abs(poles) < (self.below or np.inf))]
        if not len(poles):
            raise InputError("study.below", self.below, "must be greater: no pole has a smaller angular frequency")
        poles = poles[np.argsort(np.abs(poles))]
        size, damping = np.abs(poles), -poles.real / np.abs(poles)
        a.table(
            "poles", "natural vibrations", over="pole",
            frequency=(size, "natural frequency", "speed"), damping=(damping, "damping ratio"),
            rate=(poles.real, "growth rate", "1/time"),
        )  # fmt: skip
        a.line("pole", "{frequency}, damping ratio {damping}", at="poles")
        a.sentence = f"{len(size)} poles; the least damped has a damping ratio of {damping.min():.4g}"
        yield a

    def draw(self, result):
        """Draw the poles in the complex plane."""
        sheet, (axis,) = new_figure(1, result.attrs["title"], result.attrs["sentence"], 3.0)
        rate, frequency = result.pole_rate.values, result.pole_frequency.values
        axis.plot(rate, np.sqrt(frequency**2 - rate**2), "x", color=COLOURS[0], label="poles")
        axis.set(xlabel=label(result, "pole_rate"), ylabel=label(result, "pole_frequency"))
        legend_beside(axis)
        return sheet
