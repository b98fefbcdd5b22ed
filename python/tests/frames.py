"""Data for the tests: a data frame that is no library's, and a program that tells what it got."""

import os
import sys
from pathlib import Path

#: Reads its input files, and prints them with its arguments, as the document of a run.
TELLTALE = f"""#!{sys.executable}
import json, pathlib, sys
values = dict(a.split("=", 1) for a in sys.argv if a.startswith("--") and "=" in a)
geometry = values.get("--geometry")
document = {{
    "arguments": sys.argv[1:],
    "rows": pathlib.Path(sys.argv[2]).read_text(),
    "area": pathlib.Path(geometry).read_text() if geometry else None,
}}
if "--out" in values:
    pathlib.Path(values["--out"]).write_bytes(b"picture")
    document["out"] = values["--out"]
print("assumed nothing", file=sys.stderr)
print(json.dumps(document))
"""


class Frame:
    """Columns by name, as far as data frames of pandas and Polars agree."""

    def __init__(self, **columns):
        self._columns = columns

    @property
    def columns(self):
        return list(self._columns)

    def __getitem__(self, name):
        return iter(self._columns[name])


class Point:
    """A geometry as shapely's."""

    geom_type = "Point"


class Trajectory:
    """Data as PedPy's TrajectoryData."""

    def __init__(self, data, frame_rate):
        self.data, self.frame_rate = data, frame_rate


def two_walkers():
    """Returns two people who pass each other within a second, ten rows each."""
    rows = [(number % 2, number // 2) for number in range(20)]
    return Frame(
        id=[agent for agent, _ in rows],
        frame=[row for _, row in rows],
        x=[row * 0.13 if agent else 1.2 - row * 0.13 for agent, row in rows],
        y=[float(agent) for agent, _ in rows],
        group=["left" if agent else "right" for agent, _ in rows],
    )


def write_program(folder, text=TELLTALE):
    """Writes a program and returns its path."""
    path = Path(folder, "program")
    path.write_text(text)
    path.chmod(0o755)
    return path


def skips_drawing():
    """Returns true on machines without OpenGL."""
    return "gl" in os.environ.get("POPULACE_SKIP", "").split(",")
