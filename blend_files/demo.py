# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the product at work: installs the add-on into a throw-away Blender, bakes creature.blend, renders pictures.

Usage: demo.py --blender PATH --zip ZIP --out DIR

PATH is a Blender, or a Python with bpy. Writes creature_posed.blend, before.png, after.png, before_after.png, strip.png
and summary.json into DIR, and prints the summary. Blender's own messages go to DIR/blender.log, and are shown when it
fails.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCENE = HERE / "creature.blend"
RESULTS = ("creature_posed.blend", "before.png", "after.png", "before_after.png", "strip.png", "summary.json")
ABORTED = (-6, -11, 134, 139)  # by a signal: abort, segmentation fault
LOG_LINES = 60  # shown if Blender fails


def main() -> int:
    parser = argparse.ArgumentParser(prog="demo.py", description="Bakes and renders the sample creature.")
    parser.add_argument("--blender", required=True, help="a Blender, or a Python with bpy")
    parser.add_argument("--zip", required=True, type=Path, help="the add-on's zip for that Blender")
    parser.add_argument("--out", type=Path, default=Path("build/demo"), help="folder for the results")
    args = parser.parse_args()

    if shutil.which(args.blender) is None:
        parser.error(f"there is no program {args.blender}: name a Blender, or a Python with bpy")
    if not args.zip.is_file():
        parser.error(f"there is no file {args.zip}: make it with make zip")
    out = args.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    for name in RESULTS:
        (out / name).unlink(missing_ok=True)
    start = time.perf_counter()
    code = run_blender(args.blender, args.zip.resolve(), out)
    if code in ABORTED:
        print("demo: Blender aborted, as it does if it finds no OpenGL; trying again without", flush=True)
        code = run_blender(args.blender, args.zip.resolve(), out, "--without-opengl")
    missing = [name for name in RESULTS if not (out / name).exists()]
    if code or missing:
        print(last_lines(out / "blender.log"), file=sys.stderr)
        reason = f"ended with exit code {code}" if code else f"did not write {', '.join(missing)}"
        print(f"demo: {args.blender} {reason}; its messages are above and in {out / 'blender.log'}", file=sys.stderr)
        return 1
    print_summary(out, time.perf_counter() - start)
    return 0


def run_blender(blender: str, zip_path: Path, out: Path, *options: str) -> int:
    """Runs the part of the demo that is in Blender; prints its progress, keeps the rest for the log; its exit code."""
    inside = [str(HERE / "demo_in_blender.py")]
    if Path(blender).name.startswith("python"):
        command = [blender, *inside]
    else:
        command = [blender, "-b", "--factory-startup", "--python-exit-code", "1", "--python", *inside, "--"]
    command += [str(zip_path), str(SCENE), str(out), *options]
    with tempfile.TemporaryDirectory(prefix="arap_demo_") as folder, (out / "blender.log").open("w") as log:
        process = subprocess.Popen(
            command,
            env=environment(blender, folder),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("demo: "):
                print(line, end="", flush=True)
            log.write(line)
        return process.wait()


def environment(blender: str, folder: str) -> dict[str, str]:
    """The environment with Blender's user folder ``folder``: the user's own add-ons and settings stay out of it."""
    beside = str(Path(shutil.which(blender) or blender).resolve().parent)
    return os.environ | {
        # Debian's Blender takes the libraries of the first python3 on PATH: it must be the one beside it.
        "PATH": os.pathsep.join((beside, os.environ.get("PATH", ""))),
        "BLENDER_USER_RESOURCES": folder,
    }


def last_lines(log: Path) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-LOG_LINES:])


def print_summary(out: Path, seconds: float) -> None:
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    summary["seconds_of_the_demo"] = round(seconds, 1)
    rows = [(name.replace("_", " "), f"{x:.6g}" if isinstance(x, float) else str(x)) for name, x in summary.items()]
    width = max(len(label) for label, _ in rows)
    print()
    for label, value in rows:
        print(f"  {label:<{width}}  {value}")
    print()
    for name in RESULTS:
        path = out / name
        print(f"  {path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path}")


if __name__ == "__main__":
    sys.exit(main())
