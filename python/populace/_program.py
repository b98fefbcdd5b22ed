"""The program: where it is, and how its failures look in Python."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

#: Environment variable that names the program.
VARIABLE = "POPULACE"

_NAME = "populace.exe" if sys.platform == "win32" else "populace"
_PACKAGE = Path(__file__).resolve().parent


class ProgramNotFound(FileNotFoundError):
    """The program ``populace`` is not on this machine, or not where it is looked for."""


class Error(RuntimeError):
    """A run of the program that failed.

    :ivar code: exit code: 1 input rejected, 2 wrong usage, 3 no usable device or OpenGL, 4 output
        or run failed; negative if a signal ended the program.
    """

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


def program() -> Path:
    """Returns the path of the program.

    The first of these counts: the file that the environment variable ``POPULACE`` names, a file
    ``populace`` in the folder of this package, the release build of the repository that the
    package lies in, and a program ``populace`` on the ``PATH``.

    :raises ProgramNotFound: if there is none.
    """
    named = os.environ.get(VARIABLE)
    if named:
        found = shutil.which(named)
        if found is None:
            raise ProgramNotFound(f"{VARIABLE} is {named!r}, which is no program")
        return Path(found).absolute()
    for place in (_PACKAGE / _NAME, _PACKAGE.parents[1] / "target" / "release" / _NAME):
        if place.is_file() and os.access(place, os.X_OK):
            return place
    found = shutil.which("populace")
    if found is None:
        raise ProgramNotFound(
            "the program populace is missing: build it with `make release` in its repository, and "
            f"set {VARIABLE} to its path, or put it on the PATH"
        )
    return Path(found).absolute()
