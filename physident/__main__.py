"""``python -m physident``: the command line."""

from physident.cli import main

main()
