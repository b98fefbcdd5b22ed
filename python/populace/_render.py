"""Films and pictures of data frames."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import subprocess
import weakref
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any, Optional, Union

from populace._program import Error, program
from populace._table import LINES_BEFORE_ROWS, Rate, well_known_text, write_rows

_TAGS = {
    ".mp4": '<video controls loop src="data:video/mp4;base64,{}"></video>',
    ".gif": '<img src="data:image/gif;base64,{}">',
}


@dataclass(frozen=True)
class Rendering:
    """A film, or pictures, of a trajectory. A notebook shows it where it is the value of a cell."""

    #: The film, the picture, or the first of several; ``None`` if nothing was drawn. A file in a
    #: temporary folder is removed together with this object.
    path: Optional[Path]
    #: The document of the program: counts, times, ``foot_skate`` and ``position_error``.
    measures: dict[str, Any]
    #: The messages of the program: what it read and assumed, and warnings.
    messages: str = field(repr=False)

    def _repr_html_(self) -> Optional[str]:
        """Returns a player with the film in it; ``None`` if this is a picture."""
        tag = _TAGS.get(self.path.suffix.lower()) if self.path else None
        if self.path is None or tag is None:
            return None
        return tag.format(base64.b64encode(self.path.read_bytes()).decode("ascii"))

    def _repr_png_(self) -> Optional[bytes]:
        """Returns the picture, or the first of several; ``None`` if this is a film."""
        is_picture = self.path is not None and self.path.suffix.lower() == ".png"
        return self.path.read_bytes() if self.path is not None and is_picture else None


def render(
    frame: Any,
    fps: Rate = 25,
    area: Any = None,
    out: Union[str, os.PathLike[str], None] = None,
    **options: Any,
) -> Rendering:
    """Draws the people of a trajectory as a film.

    :param frame: a ``TrajectoryData`` of PedPy, or a data frame with columns ``id``, ``frame`` or
        ``t`` (seconds, lengths of time, or dates), ``x`` and ``y`` (metres). Further columns are
        kept; those of geometries are not.
    :param fps: frames per second of the film. Numbers in a column ``frame`` count at this rate
        too, unless the data is a ``TrajectoryData``, which knows its own, or ``data_fps`` says it.
    :param area: the walkable area in metres: WKT, a geometry of shapely, or a ``WalkableArea``.
    :param out: file to write: ``.mp4``, ``.gif`` or ``.png``. Without it the film, or with ``at``
        the picture, is a temporary file that is removed together with the result.
    :param options: flags of ``populace render``, with ``_`` for ``-``: ``size="640x360"`` is
        ``--size 640x360``. ``True`` sets a flag without a value, ``False`` and ``None`` set none,
        and lists repeat a flag for each value. ``size=(640, 360)`` and ``frames=range(5)`` work
        too.
    :raises ValueError: for data or options that cannot be written down for the program.
    :raises ProgramNotFound: if the program is missing.
    :raises Error: if it fails, with its messages.
    """
    if out is not None or options.get("no_draw"):
        return _run(frame, fps, area, {**options, "out": out})
    folder = mkdtemp(prefix="populace-")
    try:
        out = Path(folder, "film.mp4" if options.get("at") is None else "picture.png")
        rendering = _run(frame, fps, area, {**options, "out": out})
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    weakref.finalize(rendering, shutil.rmtree, folder, ignore_errors=True)
    return rendering


def _run(frame: Any, fps: Rate, area: Any, options: dict[str, Any]) -> Rendering:
    """Writes the data, runs the program on them, and removes them."""
    command = [str(program()), "render"]
    _check_rate(fps)
    with TemporaryDirectory(prefix="populace-") as inputs:
        rows = Path(inputs, "data.csv")
        write_rows(frame, fps, rows)
        command += [str(rows), f"--fps={fps}", "--json"]
        if area is not None:
            Path(inputs, "area.wkt").write_text(well_known_text(area), encoding="utf-8")
            command.append(f"--geometry={Path(inputs, 'area.wkt')}")
        command += flags(options)
        run = subprocess.run(
            command, capture_output=True, encoding="utf-8", errors="replace", check=False
        )
    messages = _of_frame(run.stderr, inputs)
    if run.returncode != 0:
        raise Error(messages.strip() or f"{command[0]} failed", run.returncode)
    measures = json.loads(run.stdout)
    path = Path(measures["out"]) if "out" in measures else None
    return Rendering(path, measures, messages)


def _check_rate(fps: Rate) -> None:
    try:
        is_rate = Fraction(str(fps)) > 0
    except (ValueError, ZeroDivisionError):
        is_rate = False
    if not is_rate:
        raise ValueError(
            f'fps is a number above 0, or a fraction as text such as "30000/1001", not {fps!r}'
        )


def _of_frame(messages: str, inputs: str) -> str:
    """Returns messages about the temporary files as messages about the data frame and the area."""
    messages = messages.replace(str(Path(inputs, "area.wkt")), "the walkable area")
    messages = messages.replace(str(Path(inputs, "data.csv")), "the data frame")

    def row(match: re.Match[str]) -> str:
        nth = int(match[2]) - 1 - LINES_BEFORE_ROWS
        return match[0] if nth < 0 else f"{match[1]}row {nth}"

    # Errors name the file before the line; warnings have the line in brackets.
    return re.sub(r"(the data frame, |\(|the first in )line (\d+)", row, messages)


def flags(options: dict[str, Any]) -> list[str]:
    """Returns options as arguments of the program."""
    arguments = []
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if name == "size" and isinstance(value, (list, tuple)):
            value = "x".join(map(str, value))
        if isinstance(value, range):
            value = _first_to_last(name, value)
        if value is True:
            arguments.append(flag)
        elif isinstance(value, (list, tuple)):
            arguments += [f"{flag}={_argument(one)}" for one in value]
        elif value is not None and value is not False:
            arguments.append(f"{flag}={_argument(value)}")
    return arguments


def _first_to_last(name: str, numbers: range) -> str:
    if len(numbers) == 0 or numbers.step != 1:
        raise ValueError(f"{name} is a range with a step of 1 that is not empty, not {numbers!r}")
    return f"{numbers[0]}..{numbers[-1]}"


def _argument(value: Any) -> str:
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)
