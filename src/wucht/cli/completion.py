"""``wucht completion``: scripts with which a shell completes commands, options, studies and keys at the press of Tab."""

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


# Typer's own takes the words that Readline splits at "=", escapes no blanks, and has a blank follow "KEY=" and "folder/". This
# asks as fish does, with the whole line; the part of a word before "=" is removed again, since Readline keeps it.
_BASH = r"""_wucht_complete() {
    local IFS=$'\n' line="${COMP_LINE:0:COMP_POINT}" word
    COMPREPLY=($(_WUCHT_COMPLETE=complete_fish _TYPER_COMPLETE_FISH_ACTION=get-args _TYPER_COMPLETE_ARGS="$line" \
        "${COMP_WORDS[0]/#\~/$HOME}" 2>/dev/null | cut -f 1))
    word="${COMP_WORDS[COMP_CWORD]}"
    if [[ "$word" != [\"\']* ]]; then COMPREPLY=("${COMPREPLY[@]// /\\ }"); fi
    word="${line##*[[:space:]]}"
    if [[ "$word" == *=* && "$COMP_WORDBREAKS" == *=* ]]; then
        COMPREPLY=("${COMPREPLY[@]#"${word%"${word##*=}"}"}")
    fi
    if [[ ${#COMPREPLY[@]} == 1 && "${COMPREPLY[0]}" == *[=/] ]]; then compopt -o nospace; fi
}
complete -o default -F _wucht_complete wucht
"""


def completion(context: typer.Context, shell: Annotated[Shell, typer.Argument(help="bash, zsh or fish.")]) -> None:
    """Print the script that makes a shell complete at the press of Tab.

    In ~/.bashrc or ~/.zshrc: eval "$(wucht completion bash)", or zsh; in fish: wucht completion fish | source.
    """
    if shell is Shell.BASH:
        typer.echo(_BASH, nl=False)
        return
    os.environ["_WUCHT_COMPLETE"] = f"source_{shell}"  # the question that Typer answers with the script
    context.find_root().command(prog_name="wucht")
