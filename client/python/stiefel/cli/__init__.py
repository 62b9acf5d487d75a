"""The command `stiefel`: `main(arguments)` runs it in this process, `program()` is the program."""
from stiefel.cli.program import main, program

__all__ = ["main", "program"]
