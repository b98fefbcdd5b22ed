"""``python -m populace ARGUMENTS`` runs the program ``populace`` with these arguments."""

from __future__ import annotations

import os
import subprocess
import sys

from populace._program import ProgramNotFound, program

#: Exit code of a shell that does not find a command.
NOT_FOUND = 127


def main() -> int:
    """Runs the program and returns its exit code. On POSIX it takes the place of Python."""
    try:
        command = [str(program()), *sys.argv[1:]]
    except ProgramNotFound as error:
        print(f"populace: {error}", file=sys.stderr)
        return NOT_FOUND
    if os.name == "posix":
        os.execv(command[0], command)
    return subprocess.call(command)


if __name__ == "__main__":
    sys.exit(main())
