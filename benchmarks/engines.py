"""Run-ups with verdict and Dataset by each engine: processor time of the first, of the next, and the ratios of these.

Asked: compiled within 3 times heyoka's time, and at least 10 times faster than SciPy; the first below 5 s for R1. The first
finds what an earlier process kept on disk: set WUCHT_CACHE_DIR to an empty folder to see it compile.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from wucht.errors import WuchtError
from wucht.studies.study_file import read_study, run_study

STUDIES = {
    "R1": ("drozdetskaya-2020/r1", {"study.until": "20 s", "study.start": {"p1": "0.3 rad", "p2": "-0.5 rad"}}),
    "four balls": ("practice/grinder-4-balls", {}),
    "washing machine": ("practice/laundry-drum", {}),
}
ENGINES = ("heyoka", "compiled", "scipy")


def measure() -> Iterator[tuple[str, str]]:
    for label, (name, settings) in STUDIES.items():
        times = dict[str, float]()
        for engine in ENGINES:
            study = read_study(name, {"study.kind": "run-up", **settings, "study.engine": engine})
            try:
                first = processor_time(lambda study=study: run_study(study))
            except WuchtError as error:
                yield f"{label}, {engine}", str(error)
                continue
            count = 1 if first > 10 else 5
            times[engine] = min(processor_time(lambda study=study: run_study(study)) for _ in range(count))
            yield f"{label}, {engine}: first, again", f"{first:8.3f} s {times[engine]:8.3f} s"
        ratios = " : ".join(f"{seconds / min(times.values()):.2f}" for seconds in times.values())
        yield f"{label}, {' : '.join(times)}", f"{ratios:>20}"


def processor_time(job: Callable[[], object]) -> float:
    """Seconds that do not depend on what else the computer does."""
    begun = time.process_time()
    job()
    return time.process_time() - begun


def main() -> None:
    for label, value in measure():
        print(f"  {label:50} {value}", flush=True)


if __name__ == "__main__":
    main()
