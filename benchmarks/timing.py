"""The time that a job takes."""

from __future__ import annotations

import time
from collections.abc import Callable


def processor_time(job: Callable[[], object], repetitions: int = 5) -> float:
    """Seconds that do not depend on what else the computer does, the least of some."""
    times = []
    for _ in range(repetitions):
        begun = time.process_time()
        job()
        times.append(time.process_time() - begun)
    return min(times)
