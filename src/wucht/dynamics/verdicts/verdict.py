"""The verdict on a run: its outcome, the sentence that says it, and the numbers behind it."""

from __future__ import annotations

from dataclasses import dataclass, field

from wucht.analysis.starting import StartFromRest, not_started_in_words
from wucht.dynamics.verdicts.evidence import RotorAssessment
from wucht.dynamics.verdicts.locking import LockingAssessment
from wucht.dynamics.verdicts.outcomes import SPEED_TOLERANCE, Evidence, Outcome
from wucht.numerics.observers.modulation import Modulation

_EVEN_LAG = 0.02  # of the lag: its possible change at the end of a run until settled
_LOCKED_PERIODS = 200  # a run until settled of rotors that may be entrained lasts for four hundred of their turns


@dataclass(frozen=True)
class Verdict:
    """The verdict on a run: its outcome, and the numbers behind it.

    Attributes
    ----------
    outcome : Outcome
    evidence : Evidence
        Truth of the criteria.
    window : (float, float)
        Begin and end time of the final window, over which the numbers of the summary are taken.
    assessment : RotorAssessment or None
        Of the main rotor, None if it does not turn.
    speed : float
        Of the main rotor.
    settling_time : float or None
        Of speed and unbalance.
    amplitude_settling_time : float or None
        Of the vibration.
    advice : str or None
        A sentence on how to get a verdict.
    needed_time : float or None
        The end time of a run that decides.
    faster_branch : bool
        The drive could hold a higher speed as well.
    locking : LockingAssessment or None
        Of rotors that may be entrained.
    rotors : dict of str to Outcome
        The outcome of each of several.
    not_started : dict of str to StartFromRest
        The rotors that never turned, with the torques that say why.
    growth_rate : float or None
        Of differences of like bodies that move together, per unit of time, where they grow and leave the outcome open.
    """

    outcome: Outcome
    evidence: Evidence[float]
    window: tuple[float, float]
    assessment: RotorAssessment | None = None
    speed: float = 0.0
    settling_time: float | None = None
    amplitude_settling_time: float | None = None
    advice: str | None = None
    needed_time: float | None = None
    faster_branch: bool = False
    locking: LockingAssessment | None = None
    rotors: dict[str, Outcome] = field(default_factory=dict)
    not_started: dict[str, StartFromRest] = field(default_factory=dict)
    growth_rate: float | None = None

    @property
    def never_parts(self) -> bool:
        """True if the outcome stays open in every longer run: bodies move as one that real ones would leave."""
        return self.growth_rate is not None and self.needed_time is None

    @property
    def sentence(self) -> str:
        """The outcome as a sentence."""
        if self.outcome is Outcome.NOT_STARTED:
            return not_started_in_words(self.not_started, is_named=len(self.rotors) > 1)
        if self.outcome is Outcome.PASSED:
            return self._passed_in_words()
        free = self.evidence.free_speed
        if self.outcome is Outcome.BALANCER_CAPTURED and (free is None or self.speed < (1 - SPEED_TOLERANCE) * abs(free)):
            below = "" if free is None else f" to {100 * self.speed / abs(free):.0f} % of its speed without vibration"
            return f"the rotor gets through its resonance, but bodies lag behind it, captured there, and brake it{below}"
        if self.never_parts:
            return "bodies that are alike move as one, on a motion that they would leave if they were the least apart"
        if self.outcome is Outcome.UNIDENTIFIED and self.needed_time is None:
            return "the motion does not settle into an identifiable state"
        captured_rotors = [name for name, o in self.rotors.items() if o in (Outcome.CAPTURED, Outcome.CAPTURED_MODULATED)]
        share = f", at {100 * self.speed / abs(free):.0f} % of the speed without vibration" if free else ""
        together = share if self.outcome is Outcome.SYNCHRONISED else ""
        return self.outcome.sentence + (
            (f"; captured at the resonance: {', '.join(captured_rotors)}{together}" if captured_rotors else "")
            + (f"; {not_started_in_words(self.not_started)}" if self.rotors and self.not_started else "")
        )

    def _passed_in_words(self) -> str:
        nothing_below = "the rotor settles, and no resonance lies below the speed of its drive; unbalance is left"
        sentence = nothing_below if self.evidence.resonance is None else self.outcome.sentence
        if self.unbalance_factor is None:
            return sentence
        return f"{sentence}: the bodies increase it, to {self.unbalance_factor:.3g} times that of the rotor alone"

    @property
    def modulation(self) -> Modulation | None:
        """The modulation of the main rotor's speed."""
        return None if self.assessment is None else self.assessment.modulation

    @property
    def amplitudes(self) -> tuple[float, float, float] | None:
        """The amplitudes of the main rotor's axis in the window, the largest ones over a turn: mean, least and greatest.

        None if it does not turn; or with a modulation, whose valleys turns do not resolve.
        """
        if self.locking is not None:
            return self.locking.final.amplitudes
        return None if self.assessment is None or self.evidence.is_modulated else self.assessment.window.amplitudes

    @property
    def phases(self) -> dict[str, float]:
        """The phases of the bodies about the main rotor."""
        return {} if self.assessment is None else self.assessment.phases

    @property
    def residual(self) -> float | None:
        """The largest share of the unbalance that is left in the window."""
        return None if self.assessment is None else self.assessment.residual

    @property
    def unbalance_factor(self) -> float | None:
        """The factor by which the bodies increase the rotor's unbalance in the window; None where they do not."""
        return None if self.assessment is None else self.assessment.unbalance_factor

    def settled_within(self, tolerance: float) -> bool:
        """True if the outcome is known and its numbers will change by less than the tolerance, or no more than they scatter."""
        if self.outcome is Outcome.UNIDENTIFIED:
            return False
        if self.locking is not None:
            return self.locking.evidence.periods >= _LOCKED_PERIODS
        if self.assessment is None or self.evidence.is_modulated:
            return True
        if self.evidence.asynchronous:
            return all(high - low <= _EVEN_LAG * max(abs(low), abs(high)) for low, high in self.evidence.lags)
        sizes = (self.evidence.free_speed or self.speed, 1.0)
        projections = zip(self.assessment.projections, sizes, strict=False)
        return all(p.scatters or p.width <= tolerance * abs(size) for p, size in projections)
