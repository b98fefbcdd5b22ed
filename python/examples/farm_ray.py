"""Draws a film on many cores or machines with Ray: farm_ray.py walk.csv --out walk.mp4.

Each chunk of frames is a task, in any order. A task that fails is tried again, and leaves out the
pictures that exist. On several machines, the inputs, the program and the folder of the pictures
have the same paths on all of them. Arguments after -- go to `populace render`, and those of them
that say how the file is read go to `populace plan` too.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import ray

#: Times that a chunk is tried again.
RETRIES = 3
#: Exit codes of rejected inputs and of wrong usage, which the same run would end with again.
HOPELESS = (1, 2)
#: Options that say how the file is read: `plan` counts its frames by them, as `render` does.
READING = ("--format", "--unit", "--data-fps", "--heading", "--geometry")


class Failed(Exception):
    """A run that may succeed when it is tried again."""


@ray.remote(num_cpus=1, max_retries=RETRIES, retry_exceptions=[Failed])
def draw(command, first, last):
    """Draws the frames from first to last, both included."""
    run = subprocess.run([*command, "--frames", f"{first}..{last}"], capture_output=True)
    if run.returncode != 0:
        message = f"frames {first}..{last}: {run.stderr.decode(errors='replace')}"
        raise (ValueError if run.returncode in HOPELESS else Failed)(message)


def arguments():
    """Returns the arguments of this script, and those after --."""
    given, options = sys.argv[1:], []
    if "--" in given:
        given, options = given[: given.index("--")], given[given.index("--") + 1 :]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("inputs", nargs="+", help="a trajectory file, and characters")
    parser.add_argument("--out", required=True, type=Path, help="film to write: .mp4 or .gif")
    parser.add_argument("--fps", default="25", help="frames a second")
    parser.add_argument("--chunk", default="50", help="frames of a task")
    parser.add_argument("--workers", type=int, help="tasks at a time [default: one for each core]")
    parser.add_argument("--address", help="a cluster of Ray [default: this machine alone]")
    return parser.parse_args(given), options


def reading(options):
    """Returns the options that say how the file is read, with their values."""
    kept = []
    for number, option in enumerate(options):
        name, _, value = option.partition("=")
        if name in READING:
            kept += [option] if value else options[number : number + 2]
        elif option == "--strict":
            kept.append(option)
    return kept


def main():
    args, options = arguments()
    program = os.environ.get("POPULACE", "populace")
    fps = ["--fps", args.fps]
    plan = [program, "plan", *args.inputs, *fps, *reading(options), "--chunk", args.chunk]
    plan.append("--json")
    plan = json.loads(subprocess.run(plan, check=True, stdout=subprocess.PIPE).stdout)
    pictures = args.out.absolute().with_suffix(".frames") / "frame.png"
    pictures.parent.mkdir(parents=True, exist_ok=True)
    inputs = [os.path.abspath(path) if os.path.exists(path) else path for path in args.inputs]
    command = [program, "render", *inputs, *fps, *options, "--out", str(pictures)]
    command.append("--skip-existing")

    cores = {} if args.address else {"num_cpus": args.workers, "include_dashboard": False}
    ray.init(address=args.address or "local", **cores)
    chunks = [draw.remote(command, chunk["first"], chunk["last"]) for chunk in plan["chunks"]]
    for number in range(len(chunks)):
        done, chunks = ray.wait(chunks)
        ray.get(done)
        print(f"{number + 1} of {len(plan['chunks'])} chunks", file=sys.stderr)
    # Refuses a series with gaps, and names them.
    frames = ["--frames", str(plan["frame_count"])]
    film = [program, "film", str(pictures), *fps, *frames, "--out", str(args.out)]
    sys.exit(subprocess.run(film).returncode)


if __name__ == "__main__":
    main()
