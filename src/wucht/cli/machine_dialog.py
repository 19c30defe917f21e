"""``wucht new --ask``: five questions about a machine, from whose answers its file follows."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import typer

from wucht.cli.machine_text import Amount, machine_text
from wucht.machines.purpose import Purpose
from wucht.schema import Unit

T = TypeVar("T")


@dataclass(frozen=True)
class Item:
    """A part of an answer: its name in words, its SI unit, and what is usual."""

    name: str
    unit: str
    usual: str = ""


_SUPPORT = (
    Item("mass without rotors", "kg"),
    Item("natural frequency on its springs", "rad/s"),
    Item("damping ratio", "", "0.05"),
)
_ROTOR = (Item("mass", "kg"), Item("unbalance m r", "kg m"), Item("moment of inertia", "kg m^2"))
_MOTOR = (
    Item("power", "W"), Item("rated speed", "rad/s"), Item("voltage", "V", "400 V"), Item("frequency", "Hz", "50 Hz"),
    Item("breakdown torque over rated", "", "2.8"), Item("starting torque over rated", "", "2.4"),
)  # fmt: skip
_KINDS = {
    Purpose.SCREEN: "a vibratory screen with two exciters that turn against each other",
    Purpose.DRUM: "a drum with a ring of balancing balls",
    Purpose.FAN: "a fan, or another rotor that turns against air",
    Purpose.RIG: "an exciter with a pendulum, that beats",
}
# What is usual of each: of its support, its rotor and its motor, in the order of the items.
_USUAL: Mapping[Purpose, tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]] = {
    Purpose.SCREEN: (("1900 kg", "2.6 Hz"), ("80 kg", "4.5 kg m", "0.6 kg m^2"), ("3 kW", "1450 rpm")),
    Purpose.DRUM: (("45 kg", "2.5 Hz", "0.15"), ("15 kg", "0.1 kg m", "0.75 kg m^2"), ("0.55 kW", "1390 rpm")),
    Purpose.FAN: (("120 kg", "5 Hz"), ("40 kg", "0.02 kg m", "3 kg m^2"), ("5.5 kW", "1460 rpm")),
    Purpose.RIG: (("8 kg", "24 Hz"), ("10 kg", "0.004 kg m", "0.01 kg m^2"), ("0.12 kW", "2800 rpm")),
}


def machine_of_dialog() -> tuple[Purpose, str]:
    """Ask five questions on the terminal, and return the kind of machine and the text of its file.

    Raises ``typer.Abort`` where Ctrl-C or the end of the input comes before the last answer.
    """
    typer.echo("Five questions. Enter takes what is in brackets; several values have commas between them.", err=True)
    _explain({str(purpose): words for purpose, words in _KINDS.items()})
    purpose = Purpose(_ask("1. What kind of machine", str(Purpose.SCREEN), _one_of([str(one) for one in Purpose])))
    support_usual, rotor_usual, motor_usual = _USUAL[purpose]
    support = _ask_items("2. Its support", _SUPPORT, support_usual)
    rotor = _ask_items("3. Each exciter" if purpose is Purpose.SCREEN else "3. Its rotor", _ROTOR, rotor_usual, _possible_rotor)
    motor = _ask_items("4. The motor, from its nameplate", _MOTOR, motor_usual)
    questions = _questions(purpose)
    _explain({kind: words for kind, (words, _) in questions.items()})
    kind = _ask("5. What do you want to know", next(iter(questions)), _one_of(list(questions)))
    return purpose, machine_text(purpose, support, rotor, motor, {"kind": json.dumps(kind)} | questions[kind][1])


def _questions(purpose: Purpose) -> dict[str, tuple[str, dict[str, str]]]:
    """Questions about such machines that name nothing of them, by the kind of study: in words, and their further keys."""
    from wucht.studies.designer_questions import QUESTIONS

    simple = [question for question in QUESTIONS[purpose] if not any("{" in value for value in question.settings.values())]
    keys = [{key.removeprefix("study."): value for key, value in question.settings.items()} for question in simple]
    return {of_one.pop("kind"): (question.answers, of_one) for question, of_one in zip(simple, keys, strict=True)}


def _explain(words: Mapping[str, str]) -> None:
    for name, what in words.items():
        typer.echo(f"   {name:20} {what}", err=True)


def _ask_items(
    prompt: str, items: Sequence[Item], usual: Sequence[str], check: Callable[[Sequence[Amount]], None] = lambda _: None
) -> list[Amount]:
    """Ask for several values, again until they are right."""
    default = ", ".join([*usual, *(item.usual for item in items[len(usual) :])])

    def amounts(answer: str) -> list[Amount]:
        parts = [part.strip() for part in answer.split(",")]
        if len(parts) != len(items):
            raise typer.BadParameter(f"these are {len(parts)} values; needed are {len(items)}, such as {default}")
        values = [_amount(part, item) for part, item in zip(parts, items, strict=True)]
        check(values)
        return values

    return _ask(f"{prompt}: {', '.join(item.name for item in items)}\n  ", default, amounts)


def _amount(text: str, item: Item) -> Amount:
    """A positive value with its unit. Raises ``typer.BadParameter``."""
    try:
        float(text)
        is_bare = True
    except ValueError:
        is_bare = False
    if is_bare and item.unit:
        raise typer.BadParameter(f"{item.name}: give {text} with its unit")
    try:
        value = Unit(item.unit, item.name).parse_quantity(float(text) if is_bare else text)
    except ValueError as error:
        raise typer.BadParameter(f"{item.name}: {error}") from None
    if value <= 0:
        raise typer.BadParameter(f"{item.name}: must be greater than 0")
    return Amount(text if is_bare else json.dumps(text, ensure_ascii=False), value)


def _possible_rotor(values: Sequence[Amount]) -> None:
    """Raise ``typer.BadParameter`` for a moment of inertia that is less than that of the unbalance alone, U^2/m."""
    mass, unbalance, inertia = (one.value for one in values)
    if inertia < unbalance**2 / mass:
        raise typer.BadParameter(f"moment of inertia: must be at least U^2/m = {unbalance**2 / mass:.4g} kg m^2")


def _one_of(known_words: Sequence[str]) -> Callable[[str], str]:
    def word(answer: str) -> str:
        if answer.strip() not in known_words:
            raise typer.BadParameter(f"one of {', '.join(known_words)}")
        return answer.strip()

    return word


def _ask(prompt: str, default: str, value: Callable[[str], T]) -> T:
    answer: T = typer.prompt(prompt, default=default, value_proc=value, err=True)
    return answer
