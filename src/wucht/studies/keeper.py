"""Saving what there is now and then: seldom enough that it takes a tenth of the time at most."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import TYPE_CHECKING

from wucht.studies.kinds import Checkpoint

if TYPE_CHECKING:
    import xarray as xr

SAVE_EVERY_S = 5.0


class Keeper:
    """Called often, with what describes the result so far; it is handed to ``checkpoint`` when it is time."""

    def __init__(self, checkpoint: Checkpoint | None) -> None:
        self._checkpoint, self._next = checkpoint, clock.perf_counter() + SAVE_EVERY_S

    def __call__(self, describe: Callable[[], xr.Dataset]) -> None:
        """Save, if there is where to and it is time."""
        begun = clock.perf_counter()
        if self._checkpoint is None or begun < self._next:
            return
        self._checkpoint(describe())
        ended = clock.perf_counter()
        self._next = ended + max(SAVE_EVERY_S, 9 * (ended - begun))
