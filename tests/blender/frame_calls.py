# SPDX-License-Identifier: GPL-3.0-or-later
"""How simple a frame of Follow is, in counts: calls of the add-on's functions, its files, and returns to a file.

python tests/blender/frame_calls.py -- ZIP [OUT.json]           (a Python with bpy)
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bench_in_blender import in_blender
from frame_times import DRAGS, PINS, creature_object


class Calls:
    """Counts while it is entered."""

    def __init__(self, folder: Path) -> None:
        self._folder = str(folder)
        self.files: list[str] = []
        """Of each call, in order."""

    def __enter__(self) -> None:
        sys.setprofile(self._note)

    def __exit__(self, *_: object) -> None:
        sys.setprofile(None)

    def _note(self, frame, event: str, _arg: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(self._folder):
            self.files.append(frame.f_code.co_filename)

    def counts(self) -> dict[str, int]:
        entered: set[str] = set()
        returns, last = 0, ""
        for file in self.files:
            returns += file != last and file in entered
            entered.add(file)
            last = file
        return {"calls": len(self.files), "files": len(entered), "returns": returns}


def frame_of_follow(package: str) -> dict[str, int]:
    """The handler's part of a frame in a window, in which a handle has moved."""
    import bpy

    api = importlib.import_module(f"{package}.api")
    runs, run = importlib.import_module(f"{package}.follow.runs"), importlib.import_module(f"{package}.follow.run")
    known = importlib.import_module(f"{package}.scene.known")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    obj, groups = creature_object(10_000)
    for name in PINS:
        api.add_pin(obj, groups[name], name=name)
    for name in DRAGS:
        api.add_handle(obj, groups[name], name=name)
    obj.arap.use_follow = True
    bpy.context.view_layer.update()  # binds and settles
    calls = Calls(Path(api.__file__).parent)
    live = runs.run_of(obj)

    def follow(scene, depsgraph) -> None:
        with calls, live.scene.evaluated(depsgraph, known.updates(depsgraph)):
            live.scene_changed(run.When.UPDATE)

    handlers = bpy.app.handlers.depsgraph_update_post
    handlers[:] = [follow]  # without a window ours would settle it
    obj.arap.handles[0].target.location.x += 0.1
    bpy.context.view_layer.update()
    handlers.clear()
    return calls.counts()


def main(package: str, more: list[str]) -> None:
    result = frame_of_follow(package)
    print("a frame of Follow: " + ", ".join(f"{n} {what}" for what, n in result.items()), flush=True)
    if more:
        Path(more[0]).write_text(json.dumps(result) + "\n", encoding="utf-8")


if __name__ == "__main__":
    in_blender(main)
