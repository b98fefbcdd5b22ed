"""Data frames and areas as files that the program reads. No library of either is imported."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, Union

#: A number of frames per second, or a fraction as text, such as ``"30000/1001"``.
Rate = Union[int, float, str, Fraction]

#: Texts of values that stand for no value.
_MISSING = frozenset(["", "None", "nan", "NaN", "NaT", "<NA>"])


def write_rows(frame: Any, fps: Rate, path: Path) -> None:
    """Writes a data frame as CSV, without its columns of geometries.

    :param frame: a ``TrajectoryData`` of PedPy, or columns by name, as in a data frame of pandas
        or Polars, or a dictionary of lists.
    :param fps: rate of the numbers in a column of frames, if the frame does not say its own.
    :raises ValueError: if there are no columns, or if their lengths differ.
    """
    rate = fps
    if not hasattr(frame, "columns") and hasattr(frame, "frame_rate"):
        frame, rate = frame.data, frame.frame_rate
    keys = [key for key in _keys(frame) if not _holds_geometries(frame[key])]
    if not keys:
        raise ValueError("the data frame has no columns; it needs id, frame or t, x and y")
    columns = [list(_fields(frame[key])) for key in keys]
    lengths = [len(column) for column in columns]
    if len(set(lengths)) > 1:
        named = ", ".join(f"{key}: {length}" for key, length in zip(keys, lengths))
        raise ValueError(
            f"the columns have different lengths ({named}); give each a value for every row, and "
            "None where there is none"
        )
    with path.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# framerate: {float(Fraction(str(rate)))}\n")
        # The program takes lines that begin with # for remarks. Quotes keep names apart from them.
        writer = csv.writer(file, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)
        writer.writerow([_field(key) for key in keys])
        writer.writerows(zip(*columns))


def well_known_text(area: Any) -> str:
    """Returns an area as WKT.

    :param area: WKT, a geometry of shapely, or a ``WalkableArea`` of PedPy.
    :raises TypeError: for anything else.
    """
    for candidate in (area, getattr(area, "wkt", None), getattr(area, "polygon", None)):
        text = getattr(candidate, "wkt", candidate)
        if isinstance(text, str):
            return text
    kind = type(area).__name__
    raise TypeError(f"an area is WKT, a shapely geometry or a WalkableArea of PedPy, not {kind}")


def _keys(frame: Any) -> list[Any]:
    if hasattr(frame, "columns"):
        return list(frame.columns)
    if hasattr(frame, "keys"):
        return list(frame.keys())
    kind = type(frame).__name__
    raise TypeError(f"{kind} is neither a data frame nor a TrajectoryData of PedPy")


def _holds_geometries(column: Any) -> bool:
    first = next((value for value in column if value is not None), None)
    return hasattr(first, "geom_type")


def _fields(column: Any) -> Iterator[Union[int, float, str]]:
    # Numbers of Python are written several times faster than those of NumPy.
    return map(_field, column.tolist() if hasattr(column, "tolist") else column)


def _field(value: Any) -> Union[int, float, str]:
    """Returns a value as a field of one line; empty if there is none."""
    if type(value) in (int, float):
        return value if value == value else ""
    text = str(value)
    return "" if text in _MISSING else " ".join(text.splitlines())
