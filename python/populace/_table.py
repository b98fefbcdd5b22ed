"""Data frames and areas as files that the program reads. No library of either is imported."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Iterator
from datetime import datetime, timedelta
from fractions import Fraction
from pathlib import Path
from typing import Any, Union

#: A number of frames per second, or a fraction as text, such as ``"30000/1001"``.
Rate = Union[int, float, str, Fraction]

#: Names of columns of times, without blanks, dots and dashes, and in small letters.
_TIMES = frozenset(["t", "time", "timestamp", "simtime", "sec", "seconds"])

#: Lines of a written file before the first row: the rate and the names of columns.
LINES_BEFORE_ROWS = 2

#: Texts of values that stand for no value.
_MISSING = frozenset(["", "None", "nan", "NaN", "NaT", "<NA>"])


def write_rows(frame: Any, fps: Rate, path: Path) -> None:
    """Writes a data frame as CSV, without its columns of geometries.

    :param frame: a ``TrajectoryData`` of PedPy, or columns by name, as in a data frame of pandas
        or Polars, or a dictionary of lists. Named levels of an index are columns too.
    :param fps: rate of the numbers in a column of frames, if the frame does not say its own.
    :raises ValueError: if there are no columns, if two have one name, or if their lengths differ.
    """
    rate = fps
    if not hasattr(frame, "columns") and hasattr(frame, "frame_rate"):
        frame, rate = frame.data, frame.frame_rate
    names = _keys(frame)
    twice = [str(key) for key, count in Counter(names).items() if count > 1]
    if twice:
        raise ValueError(f"several columns are named {', '.join(twice)}; rename all but one")
    levels = [name for name in _levels(frame) if name not in names]
    keys = levels + [key for key in names if not _holds_geometries(frame[key])]
    if not keys:
        raise ValueError("the data frame has no columns; it needs id, frame or t, x and y")
    columns = []
    for nth, key in enumerate(keys):
        column = frame.index.get_level_values(key) if nth < len(levels) else frame[key]
        values = _values(column)
        columns.append([_field(value) for value in (_seconds(values) if _is_time(key) else values)])
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


def _levels(frame: Any) -> list[Any]:
    """Returns the names of the levels of an index, as data frames of pandas have one."""
    names = getattr(getattr(frame, "index", None), "names", None) or []
    return [name for name in names if name is not None]


def _is_time(key: Any) -> bool:
    return "".join(c for c in str(key).lower() if c not in " _-.") in _TIMES


def _holds_geometries(column: Any) -> bool:
    first = next((value for value in column if value is not None), None)
    return hasattr(first, "geom_type")


def _values(column: Any) -> Iterable[Any]:
    # Arrays of NumPy turn nanoseconds into plain numbers, and microseconds into dates.
    kind = getattr(getattr(column, "dtype", None), "kind", None)
    if kind in ("M", "m") and type(column).__module__ == "numpy":
        column = column.astype("datetime64[us]" if kind == "M" else "timedelta64[us]")
    # Numbers of Python are written several times faster than those of NumPy.
    return column.tolist() if hasattr(column, "tolist") else column


def _seconds(values: Iterable[Any]) -> Iterator[Any]:
    """Returns times in seconds: dates since the first of them, and lengths of time."""
    values = list(values)
    # A missing date of pandas is a date that does not equal itself.
    dates = [value for value in values if isinstance(value, datetime) and value == value]
    first = min(dates, default=None)
    for value in values:
        if isinstance(value, datetime) and first is not None:
            value = value - first
        yield value.total_seconds() if isinstance(value, timedelta) else value


def _field(value: Any) -> Union[int, float, str]:
    """Returns a value as a field of one line; empty if there is none."""
    if type(value) in (int, float):
        return value if value == value else ""
    text = str(value)
    return "" if text in _MISSING else " ".join(text.splitlines())
