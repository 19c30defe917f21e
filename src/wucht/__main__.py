"""``python -m wucht``: the command line."""

from wucht.cli import main

main()
