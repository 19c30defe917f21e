"""The first minute: what a machine of the catalogue teaches, in two sentences and one thing to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Card:
    """A card. text: two sentences; task: one thing to do."""

    title: str
    text: str
    task: str


SOMMERFELD = Card(
    "The Sommerfeld effect",
    "Near its resonance the rotor shakes its carrier, and this costs torque. A motor that has none to spare stays there: more "
    "power brings more vibration, no more speed.",
    "Choose “from the time shown”, and raise the slope of the torque-speed curve while the rotor is captured: at some slope it "
    "passes.",
)
SELF_BALANCING = Card(
    "A rotor that balances itself",
    "Below the resonance the balancing bodies run to the heavy side, above it to the light side. There they settle where the "
    "residual unbalance is zero.",
    "Choose the view that turns with the rotor, play slowly, and watch the bodies find their places.",
)
BEATING = Card(
    "Captured, and beating",
    "The balancing bodies lag behind the rotor and take the motor's power in the rhythm of their slip. So the speed is held "
    "near the resonance, and rises and falls for ever.",
    "Raise the slope of the torque-speed curve to twice its value: the bodies are carried along, and the vibration ends.",
)
SYNCHRONISATION = Card(
    "Exciters that find one rhythm",
    "No gear and no belt connects these rotors; the carrier's vibration alone makes them turn at one speed. It also sets their "
    "phases, and with them the direction in which the machine throws.",
    "Switch off one motor while both run: often the vibration keeps its rotor turning.",
)
WASHING_MACHINE = Card(
    "A washing machine spins up",
    "Balls in a ring lie at the bottom until the oil drags them along. Beyond the resonance of the tub they spread out "
    "opposite to the laundry, and the vibration ceases.",
    "Drag the laundry's unbalance up: beyond what the balls can balance, the vibration stays.",
)

TUMBLING_LAUNDRY = Card(
    "Laundry that falls into one place",
    "The laundry is well distributed at first. At 40 s, at full speed, some of it falls into one place, and from 60 to 80 s "
    "this heap loses water: the balls follow its unbalance.",
    "Play from 38 s: the laundry falls into one place at 40 s, and the balls find new places within seconds.",
)

_BY_NAME: Mapping[str, Card] = {
    "sperling-vibration/figure-5": SOMMERFELD, "drozdetskaya-2020/figure-3.3": SOMMERFELD,
    "drozdetskaya-2020/table-3.1-carrier": SOMMERFELD, "drozdetskaya-2020/table-3.1-laval": SOMMERFELD,
    "drozdetskaya-2020/r1-u1": SOMMERFELD,
    "drozdetskaya-2020/r1-u40": SELF_BALANCING, "drozdetskaya-2020/r1-u80": SELF_BALANCING,
    "drozdetskaya-2020/r2-u80": SELF_BALANCING, "practice/laboratory-centrifuge": SELF_BALANCING,
    "practice/angle-grinder": SELF_BALANCING, "practice/fan-ball-ring": SELF_BALANCING,
    "practice/balls-at-resonance-thick-oil": SELF_BALANCING, "drozdetskaya-2020/r1": BEATING,
    "drozdetskaya-2020/r2": BEATING, "practice/screen": SYNCHRONISATION, "practice/screen-loaded": SYNCHRONISATION,
    "sperling-vibration/self-synchronisation-soft": SYNCHRONISATION,
    "sperling-vibration/self-synchronisation-stiff": SYNCHRONISATION, "practice/laundry-drum": WASHING_MACHINE,
    "practice/laundry-drum-friction": WASHING_MACHINE, "practice/laundry-drum-tumbling": TUMBLING_LAUNDRY,
}  # fmt: skip


def card_of(name: str) -> Card | None:
    """Return the card of a catalogue name, None where there is none."""
    return _BY_NAME.get(name)
