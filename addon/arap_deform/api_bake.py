# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking an animation of the handles to keyframed shape keys."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import bpy
import numpy as np
from numpy.typing import NDArray

from . import frame_state, handle_io, live_key, mesh_io, sessions, shape_key
from .api_pose import adopt_session, build_session, fitting_session, session_input, solve_from_rest
from .binding import Binding
from .handle_map import Floats
from .session import Cancelled, Progress, Session
from .session_data import Readout, readout_of_whole
from .sessions import SessionInput
from .texts import iface_

BYTES_PER_VERTEX = 12  # of a shape key
CHUNK_S = 0.1


@dataclass(frozen=True)
class BakeEstimate:
    """What a bake would make. In memory keys are held twice: the data, and Blender's evaluated copy."""

    n_keys: int
    n_vertices: int

    @property
    def bytes_in_file(self) -> int:
        return self.n_keys * self.n_vertices * BYTES_PER_VERTEX

    @property
    def bytes_in_memory(self) -> int:
        return 2 * self.bytes_in_file

    def __str__(self) -> str:
        """For the panel: '48 keys, 7 MB in the file, 14 MB in memory'."""
        keys = "1 key" if self.n_keys == 1 else f"{self.n_keys} keys"
        return f"{keys}, {_size(self.bytes_in_file)} in the file, {_size(self.bytes_in_memory)} in memory"


class BakeJob:
    """A bake that is done in steps, so that an operator can show progress and take Esc in between.

    First the mesh is bound, in a thread of its own, where no live session fits. Nothing in the file changes before
    finish(), except the current frame; cancel() brings that back. Where step() or finish() raises, call cancel(). Holds
    names, no Blender data.
    """

    def __init__(self, obj: bpy.types.Object, scene: bpy.types.Scene, frames: list[int], prefix: str) -> None:
        """Of a checked object: see begin_bake()."""
        self._object_name: str = obj.name
        self._scene_name = scene.name
        self._frames = frames
        self._prefix = prefix
        self._frame_before = (scene.frame_current, scene.frame_subframe)
        self._values_before = frame_state.capture()
        self._shapes: list[NDArray[np.float32]] = []
        self._parts: list[Readout] = []  # of the frame being solved
        self._matrices: Floats | None = None
        self._live_session: Session | None = None
        self._session: Session | None = None
        self._bind: Binding[Session] | None = None
        self.readouts: list[Readout] = []
        """One for each frame done."""
        self._inputs = session_input(obj, _depsgraph_of(scene))
        session = fitting_session(obj, self._inputs)
        if session is None:
            self._begin_bind(self._inputs)
        else:
            self._take_live(session)
        sessions.claim(obj.name, "it is baked")

    @property
    def fraction(self) -> float:
        """Fraction done, 0 to 1."""
        return len(self._shapes) / len(self._frames)

    @property
    def frame(self) -> int:
        """The frame being solved."""
        return self._frames[min(len(self._shapes), len(self._frames) - 1)]

    @property
    def object_name(self) -> str:
        return self._object_name

    @property
    def n_unsettled(self) -> int:
        """How many of the frames done have met the limit of iterations before the tolerance."""
        return sum(readout.stop_reason != "converged" for readout in self.readouts)

    @property
    def bind_fraction(self) -> float | None:
        """How far the mesh is bound, None while frames are solved."""
        return None if self._bind is None else self._bind.fraction

    @property
    def status(self) -> str:
        """What is being done, for the status bar."""
        if self._bind is not None:
            return iface_("preparing the mesh, {:.0%}").format(self._bind.fraction)
        return iface_("frame {}, {:.0%} done").format(self.frame, self.fraction)

    def step(self, time_limit_s: float = CHUNK_S) -> bool:
        """Works for about ``time_limit_s`` seconds; True while there is more to do. Call finish() after the last.

        Raises:
            ValueError, RuntimeError: a handle, the object or the scene went missing, the mesh changed or cannot be
                used, or the solver failed.
        """
        if self._bind is None and self._matrices is None:
            self._begin_frame()
        if self._bind is None:
            self._solve(time_limit_s)
        else:
            self._bind.start()  # not when the job is made: that may be within an operator, see Binding
            self._bind.wait(time_limit_s)
            if self._bind.is_done:
                self._end_bind(self._bind.result())
        return len(self._shapes) < len(self._frames)

    def finish(self) -> list[str]:
        """Writes the keys and their keyframes, goes back to the frame at the start, returns the keys' names.

        Raises:
            ValueError, RuntimeError: as step(), or the mesh must not be written any more; nothing is written then.
        """
        if len(self._shapes) < len(self._frames):
            raise RuntimeError(f"The bake of '{self._object_name}' is not done: call step() until it returns False")
        obj = self._object()
        shape_key.check_writable(obj)
        names = shape_key.write_animation(obj, self._prefix, self._frames, self._shapes)
        key = live_key.find(obj)
        if key is not None:
            key.mute = True  # or its pose would be added to every baked one
        # A key of the former bake may have had the name of a new one.
        keys = obj.data.shape_keys
        frame_state.drop(self._values_before, keys, {shape_key.value_path(keys.key_blocks[name]) for name in names})
        sessions.set_readout(obj.name, self.readouts[-1])
        self._go_back()
        return names

    def cancel(self) -> None:
        """Everything as before the bake."""
        if self._bind is not None:
            self._bind.drop()
        self._shapes.clear()
        self._go_back()

    def _begin_bind(self, inputs: SessionInput) -> None:
        self._bind = Binding(lambda progress: build_session(inputs, progress))

    def _end_bind(self, session: Session) -> None:
        if self._session is None:
            self._scene()
            adopt_session(self._object(), self._inputs, session)
            self._take_live(session)
        else:
            session.set_positions(self._session.positions)
            self._session = session
        self._bind = None

    def _take_live(self, session: Session) -> None:
        self._session = self._live_session = session
        self._live_positions = session.positions.copy()

    def _begin_frame(self) -> None:
        """Goes to the frame and reads the handles, or begins a bind where the mesh needs one for this frame."""
        assert self._session is not None
        scene = self._scene()
        scene.frame_set(self.frame)
        obj = self._object()
        depsgraph = _depsgraph_of(scene)
        stretch = mesh_io.read_stretch(obj, depsgraph)
        if not sessions.is_same_stretch(self._session.stretch, stretch):
            # An animated scale: what is rigid as seen is another thing in this frame.
            self._begin_bind(replace(self._inputs, stretch=stretch))
        else:
            self._matrices = handle_io.handle_matrices(obj, depsgraph)

    def _solve(self, time_limit_s: float) -> None:
        assert self._session is not None
        assert self._matrices is not None
        left = self._inputs.settings.max_iterations - sum(part.iterations for part in self._parts)
        if not self._shapes and not self._parts:
            part = solve_from_rest(self._session, self._matrices, time_limit_s=time_limit_s)
        else:
            part = self._session.update(
                self._matrices, iterations=left, initial_guess="previous", time_limit_s=time_limit_s
            )
        self._parts.append(part)
        if part.stop_reason != "time_limit" or part.iterations >= left:
            self._end_frame()

    def _end_frame(self) -> None:
        assert self._session is not None
        self._shapes.append(self._session.positions.copy())
        self.readouts.append(readout_of_whole(self._parts))
        self._parts = []
        self._matrices = None

    def _go_back(self) -> None:
        if self._live_session is not None:
            self._live_session.set_positions(self._live_positions)
        scene = bpy.data.scenes.get(self._scene_name)
        if scene is not None:
            frame, subframe = self._frame_before
            scene.frame_set(frame, subframe=subframe)
            frame_state.restore(self._values_before)
        sessions.release(self._object_name)

    def _scene(self) -> bpy.types.Scene:
        scene = bpy.data.scenes.get(self._scene_name)
        if scene is None:
            raise RuntimeError(f"Scene '{self._scene_name}' is not there any more: the bake has ended")
        return scene

    def _object(self) -> bpy.types.Object:
        obj = bpy.data.objects.get(self._object_name)
        if obj is None:
            raise RuntimeError(f"'{self._object_name}' is not there any more: the bake has ended")
        mesh_io.check_mesh(obj)
        n = len(obj.data.vertices)
        if n != self._inputs.signature.counts[0]:
            raise RuntimeError(
                f"The mesh of '{obj.name}' has changed ({self._inputs.signature.counts[0]} vertices, now {n}): "
                "the bake has ended"
            )
        return obj


def estimate_bake(obj: bpy.types.Object, start: int, end: int, step: int = 1) -> BakeEstimate:
    """How many keys and bytes bake_animation() of the same arguments would make."""
    mesh_io.check_mesh(obj)
    return BakeEstimate(len(frames_of(start, end, step)), len(obj.data.vertices))


def begin_bake(
    obj: bpy.types.Object,
    start: int,
    end: int,
    step: int = 1,
    prefix: str = "",
    scene: bpy.types.Scene | None = None,
) -> BakeJob:
    """Checks everything and returns the job, which begins to bind where needed. Arguments as bake_animation()."""
    scene = scene or bpy.context.scene
    frames = frames_of(start, end, step)
    if obj is None or scene.objects.get(obj.name) != obj:
        raise ValueError(f"'{obj.name if obj else 'Nothing'}' is not in scene '{scene.name}': choose an object of it")
    prefix = prefix or f"{obj.arap.key_name}_"
    mesh_io.check_mesh(obj)
    _check_prefix(obj, prefix, frames)
    shape_key.check_animatable(obj)
    return BakeJob(obj, scene, frames, prefix)


def bake_animation(
    obj: bpy.types.Object,
    start: int,
    end: int,
    step: int = 1,
    progress: Progress | None = None,
    prefix: str = "",
    scene: bpy.types.Scene | None = None,
) -> list[str]:
    """Bakes frames start, start + step, ... and end to one shape key each.

    At each baked frame exactly that frame's pose shows; in between neighbours blend linearly. Keys of an earlier
    bake with the same prefix are replaced. The live key is muted so that it does not add to them.

    Args:
        obj: the mesh.
        start: first frame.
        end: last frame, always baked.
        step: frames from one key to the next.
        progress: see the module's text.
        prefix: keys are named prefix + frame; '' takes the live key's name and '_'.
        scene: whose frames; None takes the current scene.

    Returns:
        The names of the keys.

    Raises:
        ValueError: end before start, step below 1, absolute keys, linked or shared mesh data, and as solve() does.
        Cancelled: ``progress`` returned False; nothing has changed.
    """
    return run_bake(begin_bake(obj, start, end, step, prefix, scene), progress)


def run_bake(job: BakeJob, progress: Progress | None = None) -> list[str]:
    """All steps of a job that begin_bake() has made; returns and raises as bake_animation()."""
    try:
        while job.step():
            if progress is not None and progress(job.fraction) is False:
                raise Cancelled(f"The bake of '{job.object_name}' was cancelled; nothing has changed")
        return job.finish()
    except BaseException:
        job.cancel()
        raise


def frames_of(start: int, end: int, step: int) -> list[int]:
    """The frames that a bake makes. Raises ValueError."""
    if step < 1:
        raise ValueError(f"step = {step}, must be 1 or more")
    if end < start:
        raise ValueError(f"The last frame {end} is before the first, {start}: swap them")
    return [*range(start, end, step), end]


def _check_prefix(obj: bpy.types.Object, prefix: str, frames: list[int]) -> None:
    if any(len(shape_key.frame_key_name(prefix, frame).encode()) > shape_key.NAME_BYTES for frame in frames):
        raise ValueError(f"Prefix '{prefix}' is too long for the names of shape keys: take a shorter one")
    taken = {obj.arap.key_name}
    if obj.data.shape_keys is not None:
        taken.add(obj.data.shape_keys.reference_key.name)
    for name in taken:
        if re.fullmatch(re.escape(prefix) + shape_key.FRAME_PATTERN, name):
            raise ValueError(f"A bake with prefix '{prefix}' would replace shape key '{name}': take another prefix")
    baked = set(shape_key.frame_keys(obj, prefix))
    for frame in frames:
        name = shape_key.frame_key_name(prefix, frame)
        if name not in baked and shape_key.find(obj, name) is not None:
            raise ValueError(f"There is a shape key '{name}' that no bake has made: rename it, or take another prefix")


def _depsgraph_of(scene: bpy.types.Scene) -> bpy.types.Depsgraph:
    if scene == bpy.context.scene:
        return bpy.context.evaluated_depsgraph_get()
    view_layer = scene.view_layers[0]
    view_layer.update()
    return view_layer.depsgraph


def _size(n_bytes: int) -> str:
    for unit in ("bytes", "kB", "MB"):
        if n_bytes < 1000:
            return f"{n_bytes:.0f} {unit}"
        n_bytes = n_bytes / 1000  # type: ignore[assignment]
    return f"{n_bytes:.1f} GB"
