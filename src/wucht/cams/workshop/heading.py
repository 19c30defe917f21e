"""What each file for the workshop says of its cam: title, original or corrected, law, speed, date and wucht's version."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime

from wucht.cams.shaft_motion import ShaftMotion

CAM_VERSIONS = ("original", "corrected")
_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss", "°": " deg", "µ": "u"})
_RPM = 30 / math.pi


@dataclass(frozen=True)
class Heading:
    """Origin of the files of a cam.

    Parameters
    ----------
    title : str
        Of the cam drive.
    law : str
        Motion law of the output, in words.
    shaft : ShaftMotion or None
        Motion of the camshaft, None where no table states it.
    is_corrected : bool
        True if the cam makes the law over time on this shaft, False if it makes it over the cam angle.
    date : datetime.datetime
        Of the files.
    version : str
        Of wucht.
    """

    title: str
    law: str
    shaft: ShaftMotion | None
    is_corrected: bool
    date: datetime
    version: str

    @property
    def cam_version(self) -> str:
        """``original`` or ``corrected``; empty where no speed is stated, so that there is one cam only."""
        return cam_version(self.shaft, self.is_corrected)

    @property
    def entries(self) -> Mapping[str, str]:
        """Names and texts of the lines: ASCII, each in one line, without what would end a comment in a file."""
        cam = {
            "": "for a shaft that turns evenly",
            "original": "original, for a shaft that turns evenly: it makes the law over the cam angle",
            "corrected": "corrected, for a shaft that turns at this speed: it makes the law over time",
        }[self.cam_version]
        texts = {
            "title": self.title,
            "cam": cam,
            "law": self.law,
            "speed": "not stated" if self.shaft is None else speed_in_words(self.shaft),
            "date": self.date.date().isoformat(),
            "program": f"wucht {self.version}",
        }
        return {name: _plain(text) for name, text in texts.items()}


def cam_version(shaft: ShaftMotion | None, is_corrected: bool) -> str:
    """Return ``original`` or ``corrected``; empty where no speed is stated, so that there is one cam only."""
    return "" if shaft is None else CAM_VERSIONS[is_corrected]


def speed_in_words(shaft: ShaftMotion) -> str:
    """Return the speed of a shaft: its mean, and by how much and in which orders it fluctuates."""
    orders = [str(j) for j, amplitude in enumerate(shaft.speed.amplitudes, 1) if amplitude > 0]
    if not orders:
        return f"{_RPM * shaft.mean:.6g} rpm, constant"
    order_names = f"{'orders' if len(orders) > 1 else 'order'} {', '.join(orders)}"
    return f"{_RPM * shaft.mean:.6g} rpm, fluctuating by {100 * shaft.fluctuation:.4g} % in {order_names}"


def _plain(text: str) -> str:
    letters = unicodedata.normalize("NFKD", text.translate(_UMLAUTS))
    ascii_text = "".join(c for c in letters if not unicodedata.combining(c)).encode("ascii", "replace").decode()
    printable = re.sub(r"[\x00-\x1f\x7f]+", " ", ascii_text)
    return re.sub(r"(?<=\()\*|\*(?=\))", "", printable).strip() or "-"
