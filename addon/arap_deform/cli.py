# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses and bakes the objects of a .blend without a window.

    blender --command arap bake creature.blend -o baked.blend --start 1 --end 48

Exit code 0 on success, else 1 (2 for a wrong command line) and one line with the reason.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NoReturn

import bpy

from .bake.cache import MeshCacheJob
from .bake.estimate import frames_of
from .bake.keys import BakeJob
from .bake.shapes_job import ShapesJob, depsgraph_of
from .bake.walk import FramesWalk
from .bake.whole_file import WholeFile, check_space
from .core import naming, native, sessions
from .core.job import Job, run_job
from .core.session_data import SolveStats
from .pose.result import bake_pose
from .pose.solve import begin_solve
from .poses.keys import PoseKeysJob
from .scene import pose_key, shape_keys
from .scene.console import say
from .scene.movers import order
from .scene.movers.still import why_missing

COMMAND = "arap"


@dataclass
class Task:
    """A job, and what makes the line to print of its result."""

    job: Job[Any]
    tell: Callable[[Any], str]


Maker = Callable[[bpy.types.Object, bpy.types.Scene, argparse.Namespace], Task]

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
    file = WholeFile(_checked_output(options))  # before any work: whether it can be written is known then
    try:
        _open(options.file, use_scripts=options.enable_scripts)
        problem = native.problem()
        if problem:
            raise RuntimeError(problem)
        _work(options, file.path)
        _save(file)
    finally:
        file.discard()
    say(f"Saved {file.path}")


def _work(options: argparse.Namespace, output: Path) -> None:
    scene = bpy.context.scene
    _leave_modes(bpy.context.view_layer)
    if any(Path(bpy.path.abspath(library.filepath)).resolve() == output for library in bpy.data.libraries):
        raise ValueError(f"{output} is a library of the file: give another file with -o")
    objects = _objects(scene, options.objects)
    if options.command == "keys" and not options.objects:
        objects = [obj for obj in objects if obj.arap.poses] or objects
    if getattr(options, "cache", None) is not None and len(objects) > 1:
        raise ValueError(f"--cache takes one object, but {len(objects)} have handles: name it with --object")
    if getattr(options, "frame", None) is not None:
        scene.frame_set(options.frame)
    tasks = _all_tasks(objects, scene, options)  # all are checked before any work
    try:
        _check_space(output, tasks)
        first, *later = order.waves(objects)
        tasks = _kept(tasks, first)
        while tasks:
            say(tasks[0].tell(run_job(tasks[0].job)))
            sessions.drop(tasks.pop(0).job.uid)  # a shot has many meshes
            if later and not tasks:  # these hang on the shapes that are there now
                tasks = _all_tasks(later.pop(0), scene, options)
    finally:
        for task in tasks:
            task.job.cancel()


def _kept(tasks: Sequence[Task], objects: Sequence[bpy.types.Object]) -> list[Task]:
    """The work on these objects; the other one is cancelled."""
    uids = {obj.session_uid for obj in objects}
    for task in tasks:
        if task.job.uid not in uids:
            task.job.cancel()
    return [task for task in tasks if task.job.uid in uids]


def _all_tasks(objects: Sequence[bpy.types.Object], scene: bpy.types.Scene, options: argparse.Namespace) -> list[Task]:
    """The work on all objects, checked. Raises ValueError with all that is wrong with any."""
    make = _maker(scene, options)
    tasks, problems = [], []
    for obj in objects:
        try:
            tasks.append(make(obj, scene, options))
        except native.ERRORS as error:
            problems.append(native.sentence_of(error))
    if problems:
        for task in tasks:
            task.job.cancel()
        raise ValueError(naming.sentences(problems))
    return tasks


def _maker(scene: bpy.types.Scene, options: argparse.Namespace) -> Maker:
    if options.command != "bake":
        return _pose if options.command == "pose" else _keys
    if options.frame is not None:
        return _bake_frame
    start = scene.frame_start if options.start is None else options.start
    end = scene.frame_end if options.end is None else options.end
    if options.cache is not None:
        return partial(_export, start, end)
    return partial(_bake_frames, FramesWalk(scene, frames_of(start, end, options.step)))  # one walk for all objects


def _open(path: Path | None, *, use_scripts: bool) -> None:
    """Opens the file to work on; None: the one that is open."""
    if path is None:
        return
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=use_scripts)
    except RuntimeError as error:
        raise ValueError(f"{path} cannot be opened ({_words_of(error)}): give a .blend of this Blender") from error


def _save(file: WholeFile) -> None:
    file.file.close()
    file.part.unlink()  # else Blender keeps it as the version before
    try:
        _write_blend(file.part)
    except RuntimeError as error:  # its folder could be written, so it is the disk; Blender may say "Success"
        raise file.failure(_words_of(error)) from error
    _keep_versions(file.path)
    file.finish()


def _keep_versions(path: Path) -> None:
    """Renames the file that is there, and versions before it, as Blender does when it saves over one: .blend1, ..."""
    n_versions = bpy.context.preferences.filepaths.save_version
    places = [path, *(path.with_name(f"{path.name}{n + 1}") for n in range(n_versions))]
    for newer, older in reversed(list(pairwise(places))):
        with suppress(FileNotFoundError):
            newer.replace(older)


def _write_blend(path: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, check_existing=False)


def _words_of(error: RuntimeError) -> str:
    """What Blender says of an error, in one line."""
    return " ".join(str(error).removeprefix("Error: ").split())


def _check_space(output: Path, tasks: Sequence[Task]) -> None:
    """Raises ValueError if the disk has no room for the new keys alone. Of compressed files nobody knows."""
    if not _is_compressed(Path(bpy.data.filepath)):
        n_bytes = sum(task.job.bytes_in_file for task in tasks if isinstance(task.job, BakeJob))
        check_space(output.parent, n_bytes, str(output))


def _is_compressed(path: Path) -> bool:
    """Whether a .blend is: it is saved again as it was."""
    with path.open("rb") as file:
        return file.read(7) != b"BLENDER"


def _check_bake(options: argparse.Namespace) -> None:
    if options.frame is not None and (options.start, options.end) != (None, None):
        raise ValueError("--frame bakes one frame, --start and --end a range: give one or the other")
    if options.frame is not None and (options.cache, options.fewest_keys) != (None, None):
        raise ValueError("--frame bakes one frame, --cache and --fewest-keys are for a range: leave one out")
    if options.cache is not None and (options.fewest_keys is not None or options.prefix):
        raise ValueError("--cache makes no shape keys: leave out --fewest-keys and --prefix")
    if options.cache is not None and options.cache.exists() and not options.overwrite:
        raise ValueError(f"{options.cache} exists already: give another file, or --overwrite to write over it")


def _checked_output(options: argparse.Namespace) -> Path:
    """The file to write. Raises ValueError if there is none, or if it must not be written."""
    given = options.file or (Path(bpy.data.filepath) if bpy.data.filepath else None)
    if given is None:
        raise ValueError("No .blend was given: name one")
    if not given.is_file():
        raise ValueError(f"{given} does not exist: check the path")
    output = options.output or given
    if not output.resolve().parent.is_dir():
        raise ValueError(f"{output.resolve().parent} is not a folder: make it first")
    if not options.overwrite and output.resolve() == given.resolve():
        raise ValueError(f"{output} is the input: give another file with -o, or --overwrite to write over it")
    if not options.overwrite and output.exists():
        raise ValueError(f"{output} exists already: give another file with -o, or --overwrite to write over it")
    return Path(output.resolve())


def _leave_modes(view_layer: bpy.types.ViewLayer) -> None:
    """Goes to Object Mode, as an artist would: files are saved in any mode. Pose Mode changes nothing."""
    active = view_layer.objects.active
    for obj in view_layer.objects:
        if obj.mode not in {"OBJECT", "POSE"}:
            view_layer.objects.active = obj
            bpy.ops.object.mode_set(mode="OBJECT")
    view_layer.objects.active = active


def _objects(scene: bpy.types.Scene, names: Sequence[str] | None) -> list[bpy.types.Object]:
    if not names:
        found = [
            obj for obj in scene.objects if obj.type == "MESH" and any(handle.is_enabled for handle in obj.arap.handles)
        ]
        if not found:
            lost = [library.filepath for library in bpy.data.libraries if library.is_missing]
            remedy = f"bring back {naming.listed(lost)}, which is missing" if lost else "add some in Blender first"
            raise ValueError(f"No mesh in scene '{scene.name}' has handles: {remedy}")
        return found
    for name in names:
        if name not in scene.objects:
            raise ValueError(f"There is no object '{name}' in scene '{scene.name}': check its name")
        if reason := why_missing(scene.objects[name]):
            raise ValueError(reason)
    return [scene.objects[name] for name in names]


def _pose(obj: bpy.types.Object, scene: bpy.types.Scene, _options: argparse.Namespace) -> Task:
    return Task(begin_solve(obj, depsgraph_of(scene)), partial(_solved, obj.name))


def _solved(name: str, done: SolveStats) -> str:
    return f"{name}: {done.vertices} vertices, {done.iterations} iterations, {done.stop_reason}, {done.last_ms:.0f} ms"


def _bake_frame(obj: bpy.types.Object, scene: bpy.types.Scene, options: argparse.Namespace) -> Task:
    name = shape_keys.frame_key_name(options.prefix or f"{pose_key.wanted_name(obj)}_", options.frame)

    def tell(done: SolveStats) -> str:
        return f"{_solved(obj.name, done)}, key '{bake_pose(obj, name).name}'"

    return Task(begin_solve(obj, depsgraph_of(scene)), tell)


def _bake_frames(walk: FramesWalk, obj: bpy.types.Object, scene: bpy.types.Scene, options: argparse.Namespace) -> Task:
    job = BakeJob(
        obj,
        walk.frames[0],
        walk.frames[-1],
        options.step,
        prefix=options.prefix,
        scene=scene,
        fewest_keys_percent=options.fewest_keys,
        walk=walk,
    )
    return Task(job, lambda names: f"{job.object_name}: {job.fit}, '{names[0]}' to '{names[-1]}'{_unsettled(job)}")


def _export(start: int, end: int, obj: bpy.types.Object, scene: bpy.types.Scene, options: argparse.Namespace) -> Task:
    job = MeshCacheJob(obj, options.cache.resolve(), start, end, options.step, scene=scene, add_modifier=True)
    return Task(job, lambda path: f"{job.object_name}: {job.n_shapes} frames in {path}{_unsettled(job)}")


def _keys(obj: bpy.types.Object, scene: bpy.types.Scene, _options: argparse.Namespace) -> Task:
    job = PoseKeysJob(obj, scene=scene)
    return Task(job, lambda names: f"{job.object_name}: keys {', '.join(map(repr, names))}{_unsettled(job)}")


def _unsettled(job: ShapesJob[Any]) -> str:
    return f", {job.n_unsettled} before the accuracy was reached" if job.n_unsettled else ""


def _failed(reason: str) -> int:
    say(f"{COMMAND}: {' '.join(reason.split())}", sys.stderr)
    return 1
