#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the window tests: real Blender windows under Xvfb, driven by simulated events, one Blender for each test.

Usage: run.py --blender BLENDER --zip ZIP --screenshots DIR [--only NAME] [--time-limit S] [--files F] [--at-once N]

The zip is installed once, into a throw-away user folder, as a user would; each test has a copy of that. A test is a
generator function test_* in a test_*.py beside this file; see harness.py. It fails on an exception of its own, on any
traceback that Blender prints, and after its time is over. Exit code 1 where a test failed.
"""

from __future__ import annotations

import argparse
import ast
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).resolve().parent
WINDOW = (1280, 800)
TEST_TIME_LIMIT_S = 240
AT_ONCE = 2  # a test waits for its window's drawing most of the time
PASSED = "UI TEST PASSED"


def find_tests(files: str, only: str) -> list[tuple[str, str]]:
    """(file stem, function) of every test in these files whose name contains ``only``."""
    return [
        (path.stem, node.name)
        for path in sorted(HERE.glob(files))
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_") and only in node.name
    ]


@contextmanager
def display() -> Iterator[str]:
    """An X server of our own; yields its name."""
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", f"{WINDOW[0]}x{WINDOW[1]}x24", "-nolisten", "tcp"]
    server = subprocess.Popen(command, pass_fds=[write_end], stderr=subprocess.DEVNULL)
    os.close(write_end)
    try:
        with os.fdopen(read_end) as pipe:
            number = pipe.readline().strip()
        if not number:
            sys.exit("Xvfb did not start")
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()


def environment(user_folder: Path) -> dict[str, str]:
    """Software GL, and nothing of the user's own Blender."""
    return os.environ | {
        # Debian's Blender takes the libraries of the first python3 on PATH: not those of a virtual environment.
        "PATH": os.defpath,
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "LP_NUM_THREADS": "1",  # of software GL; a second test draws beside
        "BLENDER_USER_RESOURCES": str(user_folder),  # 4.2 and later; the others before
        "BLENDER_USER_CONFIG": str(user_folder / "config"),
        "BLENDER_USER_SCRIPTS": str(user_folder / "scripts"),
        "BLENDER_USER_DATAFILES": str(user_folder / "datafiles"),
        "TMPDIR": str(user_folder),
    }


def blender_command(blender: str, *arguments: str) -> list[str]:
    return [blender, "--factory-startup", "--python-exit-code", "1", "--python", str(HERE / "harness.py"), *arguments]


def install(blender: str, zip_path: Path, env: dict[str, str]) -> None:
    command = blender_command(blender, "--", "install", str(zip_path))
    command.insert(1, "--background")
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=TEST_TIME_LIMIT_S, check=False)
    if done.returncode != 0 or "Traceback" in done.stdout + done.stderr:
        sys.exit(f"The zip could not be installed:\n{done.stdout}{done.stderr}")


@contextmanager
def copied(folder: Path) -> Iterator[Path]:
    """A copy of a user folder: a test that disables the add-on takes its wheel away from who else uses the folder."""
    with tempfile.TemporaryDirectory(prefix="arap_ui_") as copy:
        yield Path(shutil.copytree(folder, copy, dirs_exist_ok=True))


def run_test(
    blender: str, module: str, function: str, env: dict[str, str], screenshots: Path, time_limit_s: int
) -> str:
    """What went wrong, '' where nothing did."""
    command = blender_command(blender, "--", "run", module, function, str(screenshots))
    command[1:1] = ["--enable-event-simulate", "--window-geometry", "0", "0", *map(str, WINDOW)]
    try:
        done = subprocess.run(
            command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            timeout=time_limit_s, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        said = error.stdout or b""
        return (said.decode() if isinstance(said, bytes) else said) + f"no end after {time_limit_s} s\n"
    has_passed = done.returncode == 0 and PASSED in done.stdout and "Traceback" not in done.stdout
    return "" if has_passed else f"{done.stdout}{crash_report(Path(env['TMPDIR']))}exit code {done.returncode}\n"


def crash_report(folder: Path) -> str:
    """What Blender wrote when it crashed, '' where it did not: the end of it tells where."""
    reports = sorted(folder.glob("*.crash.txt"), key=lambda path: path.stat().st_mtime)
    return reports[-1].read_text(encoding="utf-8", errors="replace")[-8000:] if reports else ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--blender", required=True, help="Blender 3.4 or later, with a window")
    parser.add_argument("--zip", required=True, type=Path, help="the legacy zip, or from 4.2 on the extension zip")
    parser.add_argument("--screenshots", required=True, type=Path, help="folder for the pictures")
    parser.add_argument("--only", default="", help="run the tests whose names contain this")
    parser.add_argument("--time-limit", type=int, default=TEST_TIME_LIMIT_S, help="seconds, of each test")
    parser.add_argument("--files", default="test_*.py", help="the files of the tests, for example bench_*.py")
    parser.add_argument("--at-once", type=int, default=AT_ONCE, help="tests at a time; 1 where time is measured")
    args = parser.parse_args()
    tests = find_tests(args.files, args.only)
    args.screenshots.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="arap_ui_") as folder:
        install(args.blender, args.zip.resolve(), environment(Path(folder)))

        def run_and_tell(test: tuple[str, str]) -> bool:
            start = time.monotonic()
            with display() as display_name, copied(Path(folder)) as user_folder:
                env = environment(user_folder) | {"DISPLAY": display_name}
                wrong = run_test(args.blender, *test, env, args.screenshots.resolve(), args.time_limit)
            print(
                f"{'FAIL' if wrong else 'ok  '} {test[1]} ({time.monotonic() - start:.1f} s)\n{wrong}",
                end="",
                flush=True,
            )
            return not wrong

        with ThreadPoolExecutor(args.at_once) as pool:
            n_passed = sum(pool.map(run_and_tell, tests))
    print(f"{n_passed} passed, {len(tests) - n_passed} failed")
    return 0 if n_passed == len(tests) > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
