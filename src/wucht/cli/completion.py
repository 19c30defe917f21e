"""``wucht completion SHELL``: what ``--show-completion`` prints, for start-up files of shells that ask for it by name."""

from __future__ import annotations

import os
from enum import StrEnum
from typing import Annotated

import typer


class Shell(StrEnum):
    """Shells for which there is a script."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"


def completion(context: typer.Context, shell: Annotated[Shell, typer.Argument(help="bash, zsh or fish.")]) -> None:
    """Print the script that makes a shell complete at the press of Tab; `wucht --install-completion` writes it to its place."""
    os.environ["_WUCHT_COMPLETE"] = f"source_{shell}"  # the question that Typer answers with the script
    context.find_root().command(prog_name="wucht")
