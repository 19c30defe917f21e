"""Questions that follow from the answer of a study: each study lists its own, and the first that fits is proposed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class NextQuestion:
    """A question that follows from the answer of a study about the same file.

    Parameters
    ----------
    answers : str
        What its answer is, as a noun phrase.
    settings : mapping
        Keys of the file to be set, as with ``--set``; ``{name}`` in a value is a number of the summary, a key of the study or a
        fact of the machine: ``rotor``, ``motor`` (the path of what makes its drive larger), ``motor_low``, ``motor_high``.
    outcomes : tuple of str
        Outcomes after which it is proposed; empty: any.
    further : str
        Name of a table of further settings that follow from machine and summary: ``motors_that_start``.
    """

    answers: str
    settings: Mapping[str, str] = field(default_factory=dict)
    outcomes: tuple[str, ...] = ()
    further: str = ""

    def settings_after(self, summary: Mapping[str, Any], spec: Mapping[str, Any]) -> dict[str, str] | None:
        """Return the settings after an answer; None where it does not follow, or a number in them is missing.

        spec: the keys of the study, and facts of the machine.
        """
        if self.outcomes and summary.get("outcome") not in self.outcomes:
            return None
        if self.further and not spec.get(self.further):
            return None
        numbers = {name: value for name, value in {**spec, **summary}.items() if value is not None}
        try:
            return {key: text.format_map(numbers) for key, text in self.settings.items()} | (
                spec[self.further] if self.further else {}
            )
        except KeyError:
            return None


def next_settings(
    questions: tuple[NextQuestion, ...], summary: Mapping[str, Any], spec: Mapping[str, Any]
) -> Iterator[tuple[dict[str, str], str]]:
    """Yield the settings of each question that follows from an answer, and what that answers, in the order of the study."""
    for question in questions:
        if (settings := question.settings_after(summary, spec)) is not None:
            yield settings, question.answers
