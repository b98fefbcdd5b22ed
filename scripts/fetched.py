"""Fetches tools by package manager into a folder of their own, and installs nothing.

Packages lie unpacked below the target folder, or below the folder that POPULACE_TOOLS names. They
are fetched once; remove the folder to fetch them again.
"""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
TOOLS = Path(os.environ.get("POPULACE_TOOLS", TARGET / "tools"))


def _fetched(name, fill):
    """Returns the folder of a set of packages, which `fill` fills if it is not there yet."""
    folder = TOOLS / name
    if not folder.is_dir():
        print(f"fetching {name} to {folder}", file=sys.stderr)
        partial = folder.with_suffix(".part")
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        fill(partial)
        partial.rename(folder)
    return folder


def debian(name, packages):
    """Unpacks packages of Debian or Ubuntu and those that they need and this system lacks."""

    def fill(folder):
        archives = folder / "archives"
        (archives / "partial").mkdir(parents=True)
        command = ["apt-get", "install", "--download-only", "--no-install-recommends", "-qq", "-y"]
        options = ["-o", f"Dir::Cache::archives={archives}", "-o", "Debug::NoLocking=true"]
        # Without a terminal apt writes its progress to stdout.
        subprocess.run([*command, *options, *packages], check=True, stdout=sys.stderr)
        for archive in sorted(archives.glob("*.deb")):
            subprocess.run(["dpkg-deb", "-x", archive, folder], check=True)
        shutil.rmtree(archives)

    return _fetched(name, fill)


def wheels(name, packages):
    """Unpacks packages of PyPI, which name their versions."""

    def fill(folder):
        archives = folder / "archives"
        command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", archives]
        subprocess.run([*command, *packages], check=True, stdout=sys.stderr)
        for archive in sorted(archives.glob("*.whl")):
            zipfile.ZipFile(archive).extractall(folder)
        shutil.rmtree(archives)

    return _fetched(name, fill)


def only(folder, pattern):
    """Returns the one path in a folder that matches a pattern."""
    found = sorted(folder.glob(pattern))
    if not found:
        sys.exit(f"no {pattern} in {folder}")
    return found[0]


def with_libraries(*folders):
    """Returns the environment in which programs find the libraries in these folders first."""
    before = os.environ.get("LD_LIBRARY_PATH")
    paths = [str(folder) for folder in folders] + ([before] if before else [])
    return {**os.environ, "LD_LIBRARY_PATH": ":".join(paths)}
