"""Limits of resources, checked before anything is computed: memory, and the number of turns; and what equations will take."""

from __future__ import annotations

import math
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from wucht.analysis.time_constants import highest_speed
from wucht.errors import InputError, RunError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.numerics.flow.compiled_system import RADAU
from wucht.studies.study import Study

BYTES = 8  # of a number
_COPIES = 3  # of the stored numbers: while they are joined, in the Dataset, and in the file
_SHARE = 0.8  # of the machine's memory; the rest is for libraries and other programs
_MOST_TURNS = 1e9  # takes weeks to compute; the same limit holds for vibrations of the carrier, each of which takes steps, too
_COORDINATE_S = 0.12  # to derive the equations and to compile them, for each coordinate: measured with 43 to 203 of them
_SILENCE_S = 5.0  # at most, of which nothing is said
_GROUPS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")  # limits of a container
REMEDY = "give a shorter time, or fewer runs or points"


def machine_memory() -> float:
    """Memory in bytes available to this process: of the machine, its container, or by a limit; infinite if unknown."""
    limits = [math.inf]
    with suppress(AttributeError, ValueError, OSError):  # not available on every system
        limits.append(float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES"))
    for group in _GROUPS:
        with suppress(ValueError, OSError):
            limits.append(float(Path(group).read_text(encoding="ascii")))
    with suppress(ImportError):
        import resource

        soft, _ = resource.getrlimit(resource.RLIMIT_AS)
        limits += [float(soft)] if soft != resource.RLIM_INFINITY else []
    return min(limits)


def refuse_numbers(numbers: float) -> None:
    """Raise ``InputError`` if the memory does not suffice for this many stored numbers."""
    required_bytes, memory = numbers * BYTES * _COPIES, machine_memory()
    if required_bytes > _SHARE * memory:
        problem = f"its result may take {required_bytes / 1e9:.3g} GB of memory, and {memory / 1e9:.3g} GB are available"
        raise InputError("study", None, f"{problem}; {REMEDY}")


def refuse_turns(spec: Study, subject: Any) -> None:
    """Raise ``InputError`` if the number of turns or vibrations until the given time would take weeks to compute."""
    until = getattr(spec, "until", None)
    if not isinstance(until, float) or not isinstance(subject, Machine):
        return
    free = [abs(free_speed(subject, rotor) or 0.0) for rotor in subject.rotors]
    frequencies = {"turns": min(max(free), highest_speed(subject))}
    if getattr(spec, "model", "full") != "slow" and getattr(spec, "engine", None) != RADAU:
        frequencies["free vibrations"] = max(natural_frequencies(subject).values(), default=0.0)
    for motion, fastest in frequencies.items():
        count = until * fastest / (2 * math.pi)
        if count > _MOST_TURNS:
            longest = f"{until * (_MOST_TURNS / count):.3g} {subject.units.time}".rstrip()
            reason = f"these are {count:.3g} {motion}, and at most {_MOST_TURNS:.3g} can be computed"
            requirement = f"must be at most {longest}: {reason}"
            raise InputError("study.until", until, requirement)


def equations_note(subject: Any) -> str | None:
    """A sentence on how long the equations of a machine with many bodies will take, before they are derived."""
    seconds = _COORDINATE_S * len(subject.coordinates) if isinstance(subject, Machine) else 0.0
    if seconds <= _SILENCE_S:
        return None
    return f"the equations of {len(subject.coordinates)} coordinates are derived and compiled first, in about {seconds:.0f} s"


def memory_error(error: MemoryError) -> RunError:
    """The error for a study that exceeded the memory in spite of the checks."""
    detail = f" ({error})" if str(error) else ""
    return RunError(f"there is not enough memory for this study{detail}; {REMEDY}", code="memory")
