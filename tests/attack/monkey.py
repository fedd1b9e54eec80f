# SPDX-License-Identifier: GPL-3.0-or-later
"""A monkey in Blender without a window: random acts of the add-on and of Blender, whatever the one before has left.

    python tests/attack/monkey.py -- ZIP [--seed 1] [--acts 300 | --minutes 20] [--control]      (a Python with bpy)
    blender -b --factory-startup --python-exit-code 1 --python tests/attack/monkey.py -- ZIP ...

After each act: every key has finite numbers, rest shapes are what they were, nothing of ours is left over, handlers do
not pile up, and no traceback was printed. Ends with 1 if one of these failed. The same seed makes the same acts; the
last of them are printed with each failure, and all stand in --trace. --control makes only the acts that need no add-on:
what crashes there, too, is not ours.
"""

from __future__ import annotations

import argparse
import faulthandler
import mmap
import os
import random
import sys
import tempfile
import time
import traceback
from collections import Counter, deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "blender")]

import run as installer  # noqa: E402

# What a script may meet; anything else out of the add-on is a finding.
USUAL = (ValueError, RuntimeError, MemoryError)
ERRORS = (*USUAL, TypeError, ReferenceError, KeyError, AttributeError, IndexError)
FRESH_AFTER = 150  # acts in one scene
PROCESS = Path("/proc/self")  # Windows has none, and memory and threads are not looked at there
HANG_S = 600  # no act takes so long, on the busiest machine
HANDLERS = (
    "depsgraph_update_post", "frame_change_post", "undo_post", "redo_post", "load_post", "render_init",
    "render_complete", "render_cancel", "save_pre", "save_post",
)  # fmt: skip


class Monkey:
    """One stream of acts, the same for the same seed."""

    def __init__(self, args: argparse.Namespace, zip_path: Path, folder: Path) -> None:
        self.random = random.Random(args.seed)
        self.folder = folder
        self.is_control = args.control
        self.step = 0
        self.last: deque[str] = deque(maxlen=8)
        self.failures: Counter[str] = Counter()
        self.errors: Counter[str] = Counter()
        self.later: list[tuple[int, Callable[[], None]]] = []
        self.handlers: dict[str, int] = {}
        self.printed = Printed(folder)
        self.trace = (args.trace or folder / "trace.txt").open("w", encoding="utf-8")
        import support
        import tubes

        self.tubes = tubes
        if not self.is_control:
            support.ZIP, support.PACKAGE = zip_path, installer.install(zip_path)
            self.api = support.module("api")
        self.acts = [
            act
            for act, weight in ACTS.items()
            if not (self.is_control and hasattr(act, "needs_add_on"))
            for _ in range(weight)
        ]

    # ------------------------------------------------------------------------------------------------ the stream

    def run(self, is_over: Callable[[int], bool]) -> int:
        self.fresh()
        self.handlers = handler_counts()
        while not is_over(self.step):
            self.step += 1
            self.one_step()
            if self.step % 100 == 0:
                self.printed.say(f"{self.step} acts, {resident_mb():.0f} MB, {n_threads()} threads, {self.failures}")
        for message, count in self.errors.most_common(200):
            self.printed.say(f"{count:6}  {message}")
        self.printed.say(f"{self.step} acts, {sum(self.failures.values())} failed: {dict(self.failures)}")
        return 1 if self.failures else 0

    def one_step(self) -> None:
        if self.random.random() < 0.85:
            self.to_object_mode()
        if self.step % FRESH_AFTER == 0 or not self.meshes():
            self.fresh()
        self.do_later()
        act = self.random.choice(self.acts)
        self.last.append(act.__name__)
        print(self.step, act.__name__, file=self.trace, flush=True)
        faulthandler.dump_traceback_later(HANG_S, exit=True, file=self.printed.terminal)
        rests = self.rests()
        try:
            act(self)
        except ERRORS as error:
            self.look_at(error)
        if act not in (undo, redo):
            push_undo(act.__name__)
        self.check(rests if not hasattr(act, "changes_rest") else {})

    def look_at(self, error: Exception) -> None:
        message = f"{type(error).__name__}: {error}"
        self.errors[f"{self.last[-1]}: {message[:120]}"] += 1
        ours = [frame for frame in traceback.extract_tb(error.__traceback__) if "arap_deform" in frame.filename]
        if ours and not isinstance(error, USUAL):
            self.fail("error of an unusual type", f"{message} at {ours[-1].filename}:{ours[-1].lineno}")
        if "Traceback" in message and "arap_deform" in message:
            self.fail("traceback out of an operator", message[-700:])

    def fail(self, what: str, detail: object = "") -> None:
        self.failures[what] += 1
        if self.failures[what] <= 3:
            self.printed.say(f"FAILED in act {self.step}: {what}: {str(detail)[:900]}\n  after {list(self.last)}")

    def do_later(self) -> None:
        due = [act for step, act in self.later if step <= self.step]
        self.later = [(step, act) for step, act in self.later if step > self.step]
        for act in due:
            try:
                act()
            except ERRORS:
                continue
            push_undo("later")

    def soon(self, act: Callable[[], None]) -> None:
        """Takes back what would end all sense, after a few acts."""
        self.later.append((self.step + self.random.randint(1, 3), act))

    def fresh(self) -> None:
        """A new, empty file with one mesh."""
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.later.clear()
        push_undo("empty")
        new_mesh(self)
        push_undo("fresh")

    # ------------------------------------------------------------------------------------------------ the scene

    def choice(self, items: Any) -> Any:
        """One of them; no items end the act."""
        items = list(items)
        if not items:
            raise ValueError("the monkey finds nothing to act on")
        return self.random.choice(items)

    def meshes(self) -> list[bpy.types.Object]:
        objects = bpy.context.view_layer.objects
        return [obj for obj in objects if obj and obj.type == "MESH" and obj.library is None and len(obj.data.vertices)]

    def mesh(self) -> bpy.types.Object:
        return self.choice(self.meshes())

    def moved_by(self, obj: bpy.types.Object) -> list[bpy.types.Object]:
        """Not of a library: an undo takes a new action away, but leaves it to a linked object, and Blender crashes."""
        if self.is_control:
            objects = [empty for empty in bpy.data.objects if empty.type == "EMPTY"]
        else:
            objects = [handle.target for handle in obj.arap.handles if handle.target]
        return [moved for moved in objects if moved.library is None]

    def handle(self) -> bpy.types.Object:
        return self.choice(self.moved_by(self.mesh()))

    def select(self, *objects: bpy.types.Object) -> None:
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in objects)
        bpy.context.view_layer.objects.active = objects[0]

    def to_object_mode(self) -> None:
        """Unless the object is hidden: Blender then leaves its mode to it."""
        obj = bpy.context.object
        if obj and obj.mode != "OBJECT" and bpy.ops.object.mode_set.poll():
            bpy.ops.object.mode_set(mode="OBJECT")

    def vector(self, reach: float) -> list[float]:
        return [self.random.uniform(-reach, reach) for _ in range(3)]

    # ------------------------------------------------------------------------------------------------ what must hold

    def rests(self) -> dict[str, np.ndarray]:
        return {obj.name: rest_of(obj) for obj in self.meshes() if obj.mode == "OBJECT"}

    def check(self, rests: dict[str, np.ndarray]) -> None:
        for obj in self.meshes():
            if obj.mode != "OBJECT":
                continue
            for key in obj.data.shape_keys.key_blocks if obj.data.shape_keys else ():
                if not np.isfinite(coordinates(key.data)).all():
                    self.fail("a key is not finite", f"{obj.name}, {key.name}")
            rest = rest_of(obj)
            if obj.name in rests and len(rests[obj.name]) == len(rest) and (rests[obj.name] != rest).any():
                self.fail("a rest shape changed", obj.name)
        for name, count in handler_counts().items():
            if count > self.handlers[name]:
                self.fail("handlers pile up", f"{name}: {count}")
        kept = [data.name for data in (*bpy.data.objects, *bpy.data.scenes, *bpy.data.node_groups)]
        if left := [name for name in kept if name.startswith("arap_")]:
            self.fail("data left over", left)
        said = self.printed.since()
        if "Traceback" in said:
            self.fail("a traceback was printed", said[said.find("Traceback") :])


class Printed:
    """What the process prints, kept from the terminal; say() still reaches it."""

    def __init__(self, folder: Path) -> None:
        self.terminal = os.fdopen(os.dup(1), "w", buffering=1, encoding="utf-8")
        self._file = (folder / "printed.txt").open("w+b")
        self._read = 0
        os.dup2(self._file.fileno(), 1)
        os.dup2(self._file.fileno(), 2)

    def say(self, text: str) -> None:
        self.terminal.write(text + "\n")

    def since(self) -> str:
        """What was printed since the last call."""
        sys.stdout.flush()
        sys.stderr.flush()
        self._file.seek(self._read)
        said = self._file.read()
        self._read += len(said)
        self._file.seek(0, os.SEEK_END)
        return said.decode(errors="replace")


def coordinates(points: Any) -> np.ndarray:
    values = np.empty(3 * len(points), np.float32)
    points.foreach_get("co", values)
    return values


def rest_of(obj: bpy.types.Object) -> np.ndarray:
    keys = obj.data.shape_keys
    return coordinates(keys.reference_key.data if keys else obj.data.vertices)


def handler_counts() -> dict[str, int]:
    return {name: len(getattr(bpy.app.handlers, name)) for name in HANDLERS}


def push_undo(message: str) -> None:
    """After each act: Blender itself crashes in undo if data changed since the last push."""
    try:
        bpy.ops.ed.undo_push(message=message)
    except RuntimeError:
        return


def resident_mb() -> float:
    return int(PROCESS.joinpath("statm").read_text().split()[1]) * mmap.PAGESIZE / 1e6 if PROCESS.exists() else 0.0


def n_threads() -> int:
    return len(list(PROCESS.joinpath("task").iterdir())) if PROCESS.exists() else 0


def main() -> None:
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("zip", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--acts", type=int, default=300, help="without --minutes")
    parser.add_argument("--minutes", type=float, help="in place of a number of acts")
    parser.add_argument("--control", action="store_true", help="only acts that need no add-on")
    parser.add_argument("--trace", type=Path, help="file for the names of all acts")
    args = parser.parse_args(arguments)
    end = time.monotonic() + 60 * (args.minutes or 0)
    with tempfile.TemporaryDirectory(prefix="arap-monkey-") as folder:
        code = 1
        monkey = Monkey(args, args.zip.resolve(), Path(folder))
        faulthandler.enable(monkey.printed.terminal)
        try:
            code = monkey.run(lambda step: time.monotonic() > end if args.minutes else step >= args.acts)
        except BaseException:  # noqa: BLE001 - whatever it is, the exit code must say that it failed
            monkey.printed.say(traceback.format_exc())
    os._exit(code)


if installer.USER_FOLDER not in os.environ:
    installer.start_again()

import bpy  # noqa: E402 - after the user folder is set
import numpy as np  # noqa: E402
from monkey_acts import ACTS, new_mesh, redo, undo  # noqa: E402

if __name__ == "__main__":
    main()
