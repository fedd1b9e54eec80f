# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses and bakes the objects of a .blend without a window.

    blender --command arap bake creature.blend -o baked.blend --start 1 --end 48

Exit code 0 on success, else 1 (2 for a wrong command line) and one line with the reason.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

import bpy

from .bake.cache import MeshCacheJob
from .bake.keys import BakeJob
from .bake.shapes_job import ShapesJob
from .core import native, sessions
from .core.job import run_job
from .pose.result import bake_pose
from .pose.solve import solve
from .poses.keys import PoseKeysJob
from .scene import pose_key, shape_keys
from .scene.console import say

COMMAND = "arap"

Act = Callable[[bpy.types.Object, bpy.types.Scene, argparse.Namespace], str]  # returns the line to print

_command: Any = None


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{COMMAND}: {message}\n")


def main(arguments: Sequence[str]) -> int:
    """Runs one command and returns its exit code.

    Args:
        arguments: as on the command line, without ``blender --command arap``.
    """
    try:
        options = _parser().parse_args(list(arguments))
    except SystemExit as end:
        return int(end.code or 0)
    try:
        _run(options)
    except (*native.ERRORS, OSError) as error:
        return _failed(native.sentence_of(error))
    except Exception as error:  # noqa: BLE001 - a script that calls us must see a reason and a code, whatever it is
        return _failed(f"internal error, please report it: {type(error).__name__}: {error}")
    return 0


def register() -> None:
    """Registers ``blender --command arap``."""
    global _command  # noqa: PLW0603 - Blender asks for it back to unregister
    _command = bpy.utils.register_cli_command(COMMAND, main)


def unregister() -> None:
    global _command  # noqa: PLW0603
    bpy.utils.unregister_cli_command(_command)
    _command = None


def _parser() -> argparse.ArgumentParser:
    common = _Parser(add_help=False)
    common.add_argument("file", nargs="?", type=Path, help="the .blend to work on; default: the one that is open")
    common.add_argument(
        "--enable-autoexec",
        dest="enable_scripts",
        action="store_true",
        help="run the scripts and Python drivers of the .blend; not by default, even if the preferences allow it",
    )
    common.add_argument("-o", "--output", type=Path, help="the .blend to write")
    common.add_argument("--overwrite", action="store_true", help="write over an existing file, the input too")
    common.add_argument(
        "--object", action="append", dest="objects", metavar="NAME", help="default: every mesh that has handles"
    )

    parser = _Parser(prog=COMMAND, description="Pose and bake meshes as rigidly as possible")
    commands = parser.add_subparsers(dest="command", required=True, parser_class=_Parser)
    pose = commands.add_parser("pose", parents=[common], help="solve for the handles at a frame")
    pose.add_argument("--frame", type=int, help="default: the file's current frame")
    bake = commands.add_parser("bake", parents=[common], help="bake a frame, or a range, to shape keys")
    bake.add_argument("--frame", type=int, help="bake this frame alone to a key")
    bake.add_argument("--start", type=int, help="first frame; default: the scene's")
    bake.add_argument("--end", type=int, help="last frame; default: the scene's")
    bake.add_argument("--step", type=int, default=1, help="frames from one solved frame to the next")
    bake.add_argument(
        "--prefix", default="", help="first part of the keys' names; default: the name of the pose's key, '_'"
    )
    bake.add_argument(
        "--fewest-keys",
        type=float,
        metavar="PERCENT",
        help="make the fewest keys that keep every vertex of every solved frame within this part of the mesh's size",
    )
    bake.add_argument(
        "--cache",
        type=Path,
        metavar="FILE",
        help="write the frames to this .mdd or .pc2 and add a Mesh Cache modifier that plays it, instead of keys",
    )
    commands.add_parser("keys", parents=[common], help="make shape keys of the stored poses")
    return parser


def _run(options: argparse.Namespace) -> None:
    if options.command == "bake":
        _check_bake(options)
    _check_output(options)
    if options.file is not None:
        if not options.file.is_file():
            raise ValueError(f"{options.file} does not exist: check the path")
        path = str(options.file.resolve())
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=options.enable_scripts)
    elif not bpy.data.filepath:
        raise ValueError("No .blend was given: name one")
    problem = native.problem()
    if problem:
        raise RuntimeError(problem)
    scene = bpy.context.scene
    objects = _objects(scene, options.objects)
    if options.command == "keys" and not options.objects:
        objects = [obj for obj in objects if obj.arap.poses] or objects
    if getattr(options, "cache", None) is not None and len(objects) > 1:
        raise ValueError(f"--cache takes one object, but {len(objects)} have handles: name it with --object")
    if getattr(options, "frame", None) is not None:
        scene.frame_set(options.frame)
    acts: dict[str, Act] = {"pose": _pose, "bake": _bake, "keys": _keys}
    act = acts[options.command]
    for obj in objects:
        say(act(obj, scene, options))
        sessions.drop(obj.name)  # a shot has many meshes
    output = (options.output or Path(bpy.data.filepath)).resolve()
    bpy.ops.wm.save_as_mainfile(filepath=str(output), copy=True, check_existing=False)
    say(f"Saved {output}")


def _check_bake(options: argparse.Namespace) -> None:
    if options.frame is not None and (options.start, options.end) != (None, None):
        raise ValueError("--frame bakes one frame, --start and --end a range: give one or the other")
    if options.frame is not None and (options.cache, options.fewest_keys) != (None, None):
        raise ValueError("--frame bakes one frame, --cache and --fewest-keys are for a range: leave one out")
    if options.cache is not None and (options.fewest_keys is not None or options.prefix):
        raise ValueError("--cache makes no shape keys: leave out --fewest-keys and --prefix")
    if options.cache is not None and options.cache.exists() and not options.overwrite:
        raise ValueError(f"{options.cache} exists already: give another file, or --overwrite to write over it")


def _check_output(options: argparse.Namespace) -> None:
    """Raises ValueError if the output must not be written. Called before any work."""
    given = options.file or (Path(bpy.data.filepath) if bpy.data.filepath else None)
    output = options.output or given
    if options.output is not None and not options.output.resolve().parent.is_dir():
        raise ValueError(f"{options.output.resolve().parent} is not a folder: make it first")
    if output is None or options.overwrite:
        return
    if given is not None and output.resolve() == given.resolve():
        raise ValueError(f"{output} is the input: give another file with -o, or --overwrite to write over it")
    if output.exists():
        raise ValueError(f"{output} exists already: give another file with -o, or --overwrite to write over it")


def _objects(scene: bpy.types.Scene, names: Sequence[str] | None) -> list[bpy.types.Object]:
    if not names:
        found = [
            obj for obj in scene.objects if obj.type == "MESH" and any(handle.is_enabled for handle in obj.arap.handles)
        ]
        if not found:
            raise ValueError(f"No mesh in scene '{scene.name}' has handles: add some in Blender first")
        return found
    for name in names:
        if name not in scene.objects:
            raise ValueError(f"There is no object '{name}' in scene '{scene.name}': check its name")
    return [scene.objects[name] for name in names]


def _pose(obj: bpy.types.Object, _scene: bpy.types.Scene, _options: argparse.Namespace) -> str:
    done = solve(obj)
    return (
        f"{obj.name}: {done.vertices} vertices, {done.iterations} iterations, {done.stop_reason}, {done.last_ms:.0f} ms"
    )


def _bake(obj: bpy.types.Object, scene: bpy.types.Scene, options: argparse.Namespace) -> str:
    if options.frame is not None:
        line = _pose(obj, scene, options)
        prefix = options.prefix or f"{pose_key.wanted_name(obj)}_"
        return f"{line}, key '{bake_pose(obj, shape_keys.frame_key_name(prefix, options.frame)).name}'"
    start = scene.frame_start if options.start is None else options.start
    end = scene.frame_end if options.end is None else options.end
    if options.cache is not None:
        export = MeshCacheJob(obj, options.cache.resolve(), start, end, options.step, scene=scene, add_modifier=True)
        path = run_job(export)
        return f"{obj.name}: {export.n_shapes} frames in {path}{_unsettled(export)}"
    job = BakeJob(
        obj, start, end, options.step, prefix=options.prefix, scene=scene, fewest_keys_percent=options.fewest_keys
    )
    names = run_job(job)
    return f"{obj.name}: {job.fit}, '{names[0]}' to '{names[-1]}'{_unsettled(job)}"


def _keys(obj: bpy.types.Object, scene: bpy.types.Scene, _options: argparse.Namespace) -> str:
    job = PoseKeysJob(obj, scene=scene)
    names = run_job(job)
    return f"{obj.name}: keys {', '.join(repr(name) for name in names)}{_unsettled(job)}"


def _unsettled(job: ShapesJob[Any]) -> str:
    return f", {job.n_unsettled} before the accuracy was reached" if job.n_unsettled else ""


def _failed(reason: str) -> int:
    say(f"{COMMAND}: {' '.join(reason.split())}", sys.stderr)
    return 1
