"""Tests of finding and running the program."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import populace
from populace import _program
from tests.frames import write_program

PACKAGE = Path(populace.__file__).parents[1]


def run_module(*arguments, **variables):
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE), **variables}
    command = [sys.executable, "-m", "populace", *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True)


class FindingTheProgram(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_the_variable_counts_first(self):
        named = write_program(self.folder)
        with mock.patch.dict(os.environ, POPULACE=str(named)):
            self.assertEqual(populace.program(), named)

    def test_a_variable_that_names_nothing_is_an_error(self):
        with mock.patch.dict(os.environ, POPULACE=str(self.folder / "none")):
            with self.assertRaisesRegex(populace.ProgramNotFound, "POPULACE is .*none"):
                populace.program()

    def test_a_program_beside_the_package_counts_before_the_path(self):
        write_program(self.folder).rename(self.folder / _program._NAME)
        places = mock.patch.object(_program, "_PACKAGE", self.folder)
        with mock.patch.dict(os.environ, POPULACE="", PATH=""), places:
            self.assertEqual(populace.program(), self.folder / _program._NAME)

    def test_the_path_is_searched_and_a_missing_program_is_named(self):
        empty = mock.patch.object(_program, "_PACKAGE", self.folder / "a" / "b" / "c")
        with mock.patch.dict(os.environ, POPULACE="", PATH=str(self.folder)), empty:
            with self.assertRaisesRegex(populace.ProgramNotFound, "make release"):
                populace.program()
            write_program(self.folder).rename(self.folder / _program._NAME)
            self.assertEqual(populace.program(), self.folder / _program._NAME)


class RunningTheModule(unittest.TestCase):
    def test_arguments_output_and_exit_code_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            text = '#!/bin/sh\necho "$1, $2"\necho "$3" >&2\nexit 7\n'
            run = run_module("a b", "--c", "", POPULACE=str(write_program(folder, text)))
        self.assertEqual((run.stdout, run.stderr, run.returncode), ("a b, --c\n", "\n", 7))

    def test_a_missing_program_is_an_exit_code_and_no_trace(self):
        run = run_module("--version", POPULACE="/none")
        self.assertEqual(run.returncode, 127)
        self.assertEqual(run.stderr, "populace: POPULACE is '/none', which is no program\n")


if __name__ == "__main__":
    unittest.main()
