"""``python -m benchmarks [NAME...]``: all benchmarks, or those named, a table each, with what the README says beside it.

``errors``: see ``benchmarks.errors``.
"""

from __future__ import annotations

import sys

from benchmarks import (
    build,
    cams,
    continuation,
    engines,
    ensembles,
    live,
    live_page,
    real_machines,
    repeated,
    run_up,
    slow,
    start_up,
)
from benchmarks.errors import runner
from benchmarks.readme import stated_numbers

ALL = {
    b.__name__.rpartition(".")[2]: b
    for b in (run_up, repeated, real_machines, engines, ensembles, slow, cams, continuation, build, start_up, live, live_page)
}


def main() -> None:
    named = sys.argv[1:]
    if named[:1] == ["errors"]:
        runner.main(named[1:])
        return
    if unknown := [name for name in named if name not in ALL]:
        sys.exit(f"benchmarks: there is no {unknown[0]!r}; known: {', '.join(ALL)}")
    for name in named or ALL:
        print(f"\n{ALL[name].__doc__.strip().splitlines()[0]}")
        stated = [number for number in stated_numbers() if number.benchmark == name]
        for label, value in ALL[name].measure():
            said = next((f"   README: {number.text}" for number in stated if label.startswith(number.label)), "")
            print(f"  {label:66} {value}{said}")


if __name__ == "__main__":
    main()
