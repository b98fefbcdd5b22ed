"""Tests of the example that draws on Ray: its frames are those of one run."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from populace import _table
from tests.frames import skips_drawing, two_walkers, write_program

try:
    import ray
except ImportError:
    ray = None

FARM = Path(__file__).parents[1] / "examples" / "farm_ray.py"
LOOK = ["--size", "160x90", "--cast", "@child", "--device", "native"]
FRAMES = 12

#: Runs the program, but fails the first time that it is to draw the frames 4..7.
UNRELIABLE = """#!/bin/sh
case "$*" in *--frames\\ 4..7*) if mkdir '{folder}/failed' 2>/dev/null; then exit 4; fi;; esac
exec '{program}' "$@"
"""


class Plan(unittest.TestCase):
    """What the example gives to the program, without Ray."""

    def commands(self, *options):
        """Returns the commands that a film without frames runs."""
        plan = json.dumps({"frame_count": 0, "chunks": []})
        arguments = [str(FARM), "walk.csv", "--out", "walk.mp4", "--", *options]
        with tempfile.TemporaryDirectory() as folder:
            arguments[3] = str(Path(folder, "walk.mp4"))
            with mock.patch.dict(sys.modules, ray=mock.MagicMock()), mock.patch.object(
                sys, "argv", arguments
            ), mock.patch("subprocess.run") as run:
                run.return_value = mock.Mock(stdout=plan, returncode=0)
                specification = importlib.util.spec_from_file_location("farm_ray", FARM)
                farm = importlib.util.module_from_spec(specification)
                specification.loader.exec_module(farm)
                with self.assertRaises(SystemExit):
                    farm.main()
        return [call.args[0] for call in run.call_args_list]

    def test_options_for_reading_reach_the_plan(self):
        read = ["--data-fps", "10", "--unit=cm", "--strict", "--geometry", "hall.wkt"]
        plan, _ = self.commands(*LOOK, *read, "--trails", "3")
        self.assertEqual(plan[1:-3], ["plan", "walk.csv", "--fps", "25", *read])


@unittest.skipIf(ray is None, "ray is not installed")
@unittest.skipUnless(os.environ.get("POPULACE"), "POPULACE does not name the program")
@unittest.skipIf(skips_drawing(), "POPULACE_SKIP names gl")
class Farm(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.rows = str(self.folder / "walk.csv")
        # Ten rows at 8 a second are 1.125 s, which are 12 frames at 10.
        _table.write_rows(two_walkers(), 8, Path(self.rows))

    def run_farm(self, name, *arguments, program=None):
        out = self.folder / name
        # Ray keeps a token in the home folder.
        environment = {**os.environ, "HOME": str(self.folder), "RAY_USAGE_STATS_ENABLED": "0"}
        environment["POPULACE"] = str(program or os.environ["POPULACE"])
        command = [sys.executable, str(FARM), self.rows, "--fps", "10", "--out", str(out)]
        run = subprocess.run(
            [*command, *arguments, "--", *LOOK], env=environment, capture_output=True, text=True
        )
        return run, out

    def pictures(self, folder):
        return [(folder / f"frame_{frame:04}.png").read_bytes() for frame in range(FRAMES)]

    def test_any_number_of_workers_draws_the_frames_of_one_run(self):
        whole = self.folder / "whole"
        whole.mkdir()
        command = [os.environ["POPULACE"], "render", self.rows, "--fps", "10", *LOOK]
        frames = ["--frames", str(FRAMES), "--out", str(whole / "frame.png")]
        subprocess.run([*command, *frames], check=True, capture_output=True)
        films = []
        for workers, chunk in [("1", "5"), ("2", "4")]:
            program = write_program(
                self.folder,
                UNRELIABLE.format(folder=self.folder, program=os.environ["POPULACE"]),
            )
            name = f"film{workers}.mp4"
            run, film = self.run_farm(
                name, "--workers", workers, "--chunk", chunk, program=program
            )
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(self.pictures(film.with_suffix(".frames")), self.pictures(whole))
            films.append(film.read_bytes())
        self.assertEqual(films[0], films[1])
        self.assertTrue((self.folder / "failed").exists(), "no chunk was tried again")

    def test_wrong_usage_is_not_tried_again(self):
        program = write_program(
            self.folder,
            f"""#!/bin/sh
[ "$1" = render ] || exec '{os.environ["POPULACE"]}' "$@"
echo run >>'{self.folder}/runs'
echo 'populace: no such camera' >&2
exit 2
""",
        )
        run, film = self.run_farm("film.mp4", "--workers", "1", "--chunk", "50", program=program)
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("no such camera", run.stderr)
        self.assertEqual((self.folder / "runs").read_text(), "run\n")
        self.assertFalse(film.exists())


if __name__ == "__main__":
    unittest.main()
