"""``wucht completion``: scripts with which a shell completes commands, options, studies and keys at the press of Tab."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer


class Shell(StrEnum):
    """Shells for which there is a script."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"


# Each calls the program with the first word ``complete-words``. Readline splits words at "=": the part of a word before it is
# removed again. No blank is inserted after a key, which is followed by its value.
_BASH = r"""_wucht_complete() {
    local IFS=$'\n' line="${COMP_LINE:0:COMP_POINT}" word
    COMPREPLY=($("${COMP_WORDS[0]/#\~/$HOME}" complete-words "$line" 2>/dev/null))
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
_ZSH = r"""#compdef wucht
_wucht_complete() {
    local -a found ending whole
    local program=${~words[1]}
    found=("${(@f)$("$program" complete-words "${(j: :)words[1,CURRENT-1]} $PREFIX" 2>/dev/null)}")
    found=(${found:#})
    ending=(${(M)found:#*[=/]})
    whole=(${found:#*[=/]})
    if (( ! ${#found} )); then _files; return; fi
    (( ${#ending} )) && compadd -S '' -- "${ending[@]}"
    (( ${#whole} )) && compadd -- "${whole[@]}"
}
compdef _wucht_complete wucht
"""
_FISH = r"""function __wucht_complete
    set -l program (commandline -opc)[1]
    set -l found (eval $program complete-words (string escape -- (commandline -cp)) 2>/dev/null)
    if test (count $found) -gt 0
        printf '%s\n' $found
    else
        __fish_complete_path (commandline -ct)
    end
end
complete -c wucht -f -a '(__wucht_complete)'
"""
_SCRIPTS = {Shell.BASH: _BASH, Shell.ZSH: _ZSH, Shell.FISH: _FISH}


def completion(shell: Annotated[Shell, typer.Argument(help="bash, zsh or fish.")]) -> None:
    """Print the script that makes a shell complete at the press of Tab.

    In ~/.bashrc or ~/.zshrc: eval "$(wucht completion bash)", or zsh; in fish: wucht completion fish | source.
    """
    typer.echo(_SCRIPTS[shell], nl=False)
