"""The command `stiefel`, which imports numpy and gRPC only when a command line is right."""
from __future__ import annotations

import os
import sys
from typing import NoReturn, Optional, Sequence

from stiefel.cli.interrupt import Interrupted, catch, end
from stiefel.cli.options import parse


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs a command, by default that of the process, and returns its exit status."""
    try:
        given = parse(sys.argv[1:] if arguments is None else arguments)
    except SystemExit as over:
        return int(over.code or 0)
    from stiefel.cli.commands import perform

    return perform(given)


def program() -> NoReturn:
    """Runs the command of the process, and ends the process with its exit status or by the signal that interrupts it."""
    os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # the command explains failures itself
    catch()
    try:
        status = main()
    except Interrupted as where:
        end(where.how_far)
    try:
        sys.stdout.flush()
    except OSError:  # which the command has told; at its end Python would write again what is left
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.exit(status)
