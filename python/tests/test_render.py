"""Tests of render: what the program is given, and what comes back."""

import base64
import datetime
import gc
import os
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import populace
from populace._render import flags
from tests.frames import Frame, Point, Trajectory, skips_drawing, two_walkers, write_program

SQUARE = "POLYGON ((-2 -2, 3 -2, 3 3, -2 3, -2 -2))"


class WhatTheProgramIsGiven(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        variable = mock.patch.dict(os.environ, POPULACE=str(write_program(folder.name)))
        variable.start()
        self.addCleanup(variable.stop)

    def rows(self, *arguments, **options):
        return populace.render(*arguments, no_draw=True, **options).measures["rows"]

    def test_all_columns_but_geometries_become_text(self):
        frame = Frame(id=[1, 2], t=[0.5, None], x=[float("nan"), 2.5], point=[Point(), Point()])
        text = '# framerate: 25.0\n"id","t","x"\n1,0.5,""\n2,"",2.5\n'
        self.assertEqual(self.rows(frame), text)
        self.assertEqual(
            self.rows({"id": [1], "a, b": ["two\nlines"]}, fps="30000/1001").splitlines()[1:],
            ['"id","a, b"', '1,"two lines"'],
        )

    def test_names_that_begin_like_a_remark_are_no_remarks(self):
        rows = self.rows({"#id": ["#a", "b"], "x": [0.5, 1]}).splitlines()[1:]
        self.assertEqual(rows, ['"#id","x"', '"#a",0.5', '"b",1'])

    def test_frames_count_at_the_rate_of_the_data(self):
        frame = Frame(id=[1], frame=[0])
        self.assertIn("framerate: 10.0", self.rows(Trajectory(frame, 10), fps=50))
        self.assertIn("framerate: 50.0", self.rows(frame, fps=50))
        self.assertIn("framerate: 29.97", self.rows(frame, fps="30000/1001"))

    def test_areas_are_texts_geometries_or_hold_one(self):
        for area in (SQUARE, mock.Mock(spec=["wkt"], wkt=SQUARE),
                     mock.Mock(spec=["polygon"], polygon=mock.Mock(wkt=SQUARE))):
            given = populace.render(two_walkers(), area=area, no_draw=True).measures
            self.assertEqual(given["area"], SQUARE)
        with self.assertRaisesRegex(TypeError, "not list"):
            populace.render(two_walkers(), area=[1, 2])

    def test_data_without_columns_is_refused(self):
        with self.assertRaisesRegex(TypeError, "list is neither"):
            populace.render([1, 2])
        with self.assertRaisesRegex(ValueError, "id, frame or t"):
            populace.render({})

    def test_columns_of_different_lengths_are_refused(self):
        columns = {"id": [1, 2, 3, 4], "frame": [0, 1, 2], "x": [0] * 4, "y": [0] * 4}
        with self.assertRaisesRegex(ValueError, "id: 4, frame: 3, x: 4, y: 4"):
            populace.render(columns)

    def test_columns_of_one_name_are_refused(self):
        columns = mock.Mock(spec=["columns"], columns=["id", "x", "x"])
        with self.assertRaisesRegex(ValueError, "several columns are named x; rename"):
            populace.render(columns)

    def test_names_of_an_index_are_columns(self):
        frame = Frame(x=[1, 2])
        levels = {"id": ["a", "b"], "x": [3, 4]}
        frame.index = mock.Mock(names=["id", None, "x"], get_level_values=levels.get)
        rows = self.rows(frame).splitlines()[1:]
        self.assertEqual(rows, ['"id","x"', '"a",1', '"b",2'])

    def test_dates_and_lengths_of_time_are_seconds(self):
        first, step = datetime.datetime(2024, 5, 1, 12), datetime.timedelta(milliseconds=250)
        for times in ([first + step, first, None], [step, 0 * step, None]):
            rows = self.rows({"t": times, "born": [first] * 3}).splitlines()[2:]
            born = '"2024-05-01 12:00:00"'
            self.assertEqual(rows, [f"0.25,{born}", f"0.0,{born}", f'"",{born}'])

    def test_messages_name_rows_of_the_frame(self):
        said = "rows were left out (line 8); $2, line 3: no; $(dirname $2)/area.wkt, line 3"
        write_program(self.folder, f"#!/bin/sh\necho \"{said}\" >&2\nexit 1\n")
        wanted = "left out .row 5.; the data frame, row 0: no; the walkable area, line 3"
        with self.assertRaisesRegex(populace.Error, wanted):
            populace.render(two_walkers(), area=SQUARE)

    def test_rates_that_are_none_are_refused(self):
        for rate in (None, "fast", 0, -1, "1/0"):
            with self.assertRaisesRegex(ValueError, "fps is a number above 0"):
                populace.render(two_walkers(), fps=rate)

    def test_sizes_and_ranges_are_one_value(self):
        options = {"size": (640, 360), "frames": range(2, 5)}
        self.assertEqual(flags(options), ["--size=640x360", "--frames=2..4"])
        for frames in (range(0), range(0, 5, 2)):
            with self.assertRaisesRegex(ValueError, "step of 1"):
                flags({"frames": frames})

    def test_options_are_flags(self):
        options = {"skip_existing": True, "json": False, "seed": None, "cast": ["a", Path("b")]}
        options["camera"] = "-1,2,3,0,0,0"
        wanted = ["--skip-existing", "--cast=a", "--cast=b", "--camera=-1,2,3,0,0,0"]
        self.assertEqual(flags(options), wanted)
        out = self.folder / "out.gif"
        given = populace.render(two_walkers(), fps=12.5, out=out, size="64x36")
        arguments = given.measures["arguments"]
        self.assertEqual(arguments[0], "render")
        self.assertEqual(arguments[2:], ["--fps=12.5", "--json", "--size=64x36", f"--out={out}"])

    def test_results_are_shown_by_notebooks(self):
        data = base64.b64encode(b"picture").decode()
        film = populace.render(two_walkers())
        self.assertIn(f'<video controls loop src="data:video/mp4;base64,{data}"',
                      film._repr_html_())
        self.assertIsNone(film._repr_png_())
        self.assertEqual(film.messages, "assumed nothing\n")
        picture = populace.render(two_walkers(), at=0.2)
        self.assertEqual((picture._repr_html_(), picture._repr_png_()), (None, b"picture"))
        nothing = populace.render(two_walkers(), no_draw=True)
        self.assertEqual((nothing.path, nothing._repr_html_(), nothing._repr_png_()), (None,) * 3)

    def test_a_temporary_film_goes_with_its_result(self):
        film = populace.render(two_walkers())
        path, given = film.path, Path(film.measures["arguments"][1])
        self.assertTrue(path.exists())
        self.assertFalse(given.exists(), "the data remain")
        del film
        gc.collect()
        self.assertFalse(path.parent.exists())

    def test_failures_have_the_messages_and_the_code(self):
        write_program(self.folder, "#!/bin/sh\necho 'populace: no column x' >&2\nexit 1\n")
        with self.assertRaisesRegex(populace.Error, "no column x") as caught:
            populace.render(two_walkers())
        self.assertEqual(caught.exception.code, 1)


@unittest.skipUnless(os.environ.get("POPULACE"), "POPULACE does not name the program")
class TheProgram(unittest.TestCase):
    def test_data_frames_are_understood(self):
        walkers, options = two_walkers(), {"no_draw": True, "cast": "@child", "device": "native"}
        measured = populace.render(walkers, fps=10, area=SQUARE, **options)
        self.assertIn("2 people, 0.9 s, 10 rows a second,", measured.messages)
        self.assertLess(measured.measures["position_error"]["max_m"], 0.05)
        slow = populace.render(Trajectory(walkers, 5.0), fps=10, **options)
        self.assertIn("2 people, 1.8 s, 5 rows a second,", slow.messages)

    def test_a_frame_without_positions_is_refused_by_the_program(self):
        with self.assertRaises(populace.Error) as caught:
            populace.render(Frame(id=[1, 1], frame=[0, 1], y=[0, 1]))
        self.assertEqual(caught.exception.code, 1, caught.exception)

    @unittest.skipIf(skips_drawing(), "POPULACE_SKIP names gl")
    def test_films_and_pictures_are_drawn(self):
        options = {"size": "64x36", "cast": "@child", "device": "native"}
        film = populace.render(two_walkers(), fps=10, frames=2, **options)
        self.assertEqual(film.path.read_bytes()[4:8], b"ftyp")
        self.assertEqual(film.measures["frames"], 2)
        self.assertIn("max_raw_m", film.measures["position_error"])
        picture = populace.render(two_walkers(), fps=10, at=0.3, **options)
        self.assertTrue(picture._repr_png_().startswith(b"\x89PNG"))

    @unittest.skipIf(skips_drawing(), "POPULACE_SKIP names gl")
    def test_pandas_and_pedpy_are_understood(self):
        try:
            import pandas
            import pedpy
        except ImportError:
            self.skipTest("pandas or pedpy is not installed")
        walkers = two_walkers()
        frame = pandas.DataFrame({name: list(walkers[name]) for name in walkers.columns})
        options = {"size": "64x36", "cast": "@child", "device": "native", "frames": 2}
        trajectory = pedpy.TrajectoryData(data=frame, frame_rate=10.0)
        area = pedpy.WalkableArea(SQUARE)
        for data in (frame, trajectory):
            film = populace.render(data, fps=10, area=area, **options)
            self.assertIn("2 people, 0.9 s, 10 rows a second,", film.messages)
            self.assertNotIn("warning", film.messages)


if __name__ == "__main__":
    unittest.main()
