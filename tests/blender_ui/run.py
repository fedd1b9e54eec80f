#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the window tests: real Blender windows under Xvfb, driven by simulated events, one Blender for each file.

Usage: run.py --blender BLENDER --zip ZIP --screenshots DIR [--only NAME] [--files F] [--size WxH] ...

The zip is installed once, into a throw-away user folder, as a user would; each file has a copy of that. A test is a
generator function test_* in a test_*.py beside this file, or in the files of --files; see harness.py. It fails on an
exception of its own, on any traceback that Blender prints, if Blender crashes, and if it says nothing for long; then
the rest of its file runs in another Blender. Exit code 1 if a test failed.
"""

from __future__ import annotations

import argparse
import ast
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
WINDOW = "960x640"  # software OpenGL draws it in half of the time that 1280x800 takes
SILENCE_LIMIT_S = 900
AT_ONCE = 2
BEGINS, PASSED, FAILED = "UI TEST BEGINS", "UI TEST PASSED", "UI TEST FAILED"


def find_tests(files: str, only: str) -> dict[str, list[str]]:
    """The tests in these files whose names contain ``only``, by the module of the file."""
    found = {
        ".".join(path.relative_to(HERE).with_suffix("").parts): [
            node.name
            for node in ast.parse(path.read_text(encoding="utf-8")).body
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_") and only in node.name
        ]
        for path in sorted(HERE.glob(files), key=lambda path: -path.stat().st_size)  # the longest ones first
    }
    return {file: tests for file, tests in found.items() if tests}


@contextmanager
def display(size: str) -> Iterator[str]:
    """An X server of our own; yields its name."""
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", f"{size}x24", "-nolisten", "tcp"]
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
        "BLENDER_USER_RESOURCES": str(user_folder),
        "TMPDIR": str(user_folder),
    }


def blender_command(blender: str, *arguments: str) -> list[str]:
    return [blender, "--factory-startup", "--python-exit-code", "1", "--python", str(HERE / "harness.py"), *arguments]


def install(blender: str, zip_path: Path, env: dict[str, str]) -> None:
    command = blender_command(blender, "--", "install", str(zip_path))
    command.insert(1, "--background")
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    if done.returncode != 0 or "Traceback" in done.stdout + done.stderr:
        sys.exit(f"The zip could not be installed:\n{done.stdout}{done.stderr}")


@dataclass
class Outcome:
    """Of one test. ``wrong``: what went wrong, '' where nothing did."""

    test: str
    seconds: float
    wrong: str


def run_file(
    command: list[str], tests: list[str], env: dict[str, str], limit_s: float, *, alone: bool
) -> Iterator[Outcome]:
    """Runs all tests of a file, in as few Blenders as that takes; ``alone``: each in a Blender of its own."""
    left = tests
    while left:
        n_done = 0
        some = left[:1] if alone else left
        for outcome in run_blender([*command, *some], some, env, limit_s):
            yield outcome
            n_done += 1
        left = left[n_done:]


def run_blender(command: list[str], tests: list[str], env: dict[str, str], limit_s: float) -> Iterator[Outcome]:
    """Runs tests in one Blender, up to the first one that ends it: at least one."""
    process = subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    n_ended, has_failed, said, start = 0, False, "", time.monotonic()
    hang = begin_silence_limit(process, limit_s)
    assert process.stdout is not None
    for line in process.stdout:
        hang.cancel()
        hang = begin_silence_limit(process, limit_s)
        if line.startswith((PASSED, FAILED)):
            has_failed = line.startswith(FAILED)
            is_right = not has_failed and "Traceback" not in said
            yield Outcome(tests[n_ended], time.monotonic() - start, "" if is_right else said)
            n_ended, said, start = n_ended + 1, "", time.monotonic()
        elif not line.startswith(BEGINS):
            said += line
    code = process.wait()
    is_hanging = not hang.is_alive()
    hang.cancel()
    if has_failed:  # which ends Blender
        return
    if n_ended == len(tests):
        if code:
            yield Outcome(f"the end of Blender after {tests[-1]}", 0.0, f"{said}exit code {code}\n")
    else:
        said += f"ended after {limit_s:g} s without a line\n" if is_hanging else crash_report(Path(env["TMPDIR"]))
        yield Outcome(tests[n_ended], time.monotonic() - start, f"{said}exit code {code}\n")


def begin_silence_limit(process: subprocess.Popen[str], limit_s: float) -> threading.Timer:
    timer = threading.Timer(limit_s, process.kill)
    timer.start()
    return timer


def crash_report(folder: Path) -> str:
    """What Blender wrote when it crashed, '' where it did not: the end of it tells where."""
    reports = sorted(folder.glob("*.crash.txt"), key=lambda path: path.stat().st_mtime)
    return reports[-1].read_text(encoding="utf-8", errors="replace")[-8000:] if reports else ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--blender", required=True, help="Blender 4.2 or later, with a window")
    parser.add_argument("--zip", required=True, type=Path, help="the add-on")
    parser.add_argument("--screenshots", required=True, type=Path, help="folder for the pictures")
    parser.add_argument("--only", default="", help="run the tests whose names contain this")
    parser.add_argument("--silence-limit", type=float, default=SILENCE_LIMIT_S, help="seconds without a line of output")
    parser.add_argument("--files", default="test_*.py", help="the files of the tests, for example bench/bench_*.py")
    parser.add_argument("--size", default=WINDOW, help="of the window, in pixels")
    parser.add_argument("--at-once", type=int, default=AT_ONCE, help="files at a time; 1 where time is measured")
    parser.add_argument("--alone", action="store_true", help="a Blender for each test: pictures show all that is kept")
    args = parser.parse_args()
    tests = find_tests(args.files, args.only)
    args.screenshots.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="arap_ui_") as folder:
        install(args.blender, args.zip.resolve(), environment(Path(folder)))

        def run_and_tell(file: str) -> list[Outcome]:
            outcomes = []
            command = blender_command(args.blender, "--", "run", file, str(args.screenshots.resolve()))
            command[1:1] = ["--enable-event-simulate", "--window-geometry", "0", "0", *args.size.split("x")]
            # A copy: a test that disables the add-on takes its wheel away from who else uses the folder.
            with display(args.size) as display_name, tempfile.TemporaryDirectory(prefix="arap_ui_") as copy:
                shutil.copytree(folder, copy, dirs_exist_ok=True)
                env = environment(Path(copy)) | {"DISPLAY": display_name}
                for outcome in run_file(command, tests[file], env, args.silence_limit, alone=args.alone):
                    outcomes.append(outcome)
                    state = "FAIL" if outcome.wrong else "ok  "
                    print(f"{state} {outcome.test} ({outcome.seconds:.1f} s)\n{outcome.wrong}", end="", flush=True)
            return outcomes

        with ThreadPoolExecutor(args.at_once) as pool:
            outcomes = [outcome for done in pool.map(run_and_tell, tests) for outcome in done]
    n_failed = sum(bool(outcome.wrong) for outcome in outcomes)
    print(f"{len(outcomes) - n_failed} passed, {n_failed} failed")
    return 1 if n_failed or not outcomes else 0


if __name__ == "__main__":
    sys.exit(main())
