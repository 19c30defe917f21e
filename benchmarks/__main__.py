"""``python -m benchmarks``: all benchmarks, a table each."""

from __future__ import annotations

from benchmarks import build, cams, continuation, engines, ensembles, repeated, run_up, slow, start_up


def main() -> None:
    for benchmark in (run_up, repeated, engines, ensembles, slow, cams, continuation, build, start_up):
        print(f"\n{benchmark.__doc__.strip().splitlines()[0]}")
        for label, value in benchmark.measure():
            print(f"  {label:66} {value}")


if __name__ == "__main__":
    main()
