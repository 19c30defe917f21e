"""The command line: one file a command."""

from __future__ import annotations


def main() -> None:
    """Entry point of ``wucht``."""
    from wucht.cli.app import run_app

    run_app()
