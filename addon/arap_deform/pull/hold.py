# SPDX-License-Identifier: GPL-3.0-or-later
"""Pulling: which vertices a session holds while a piece of the surface is dragged, and how they move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import bpy
import numpy as np

from ..core.arrays import Float32s, Floats, Ints
from ..core.session_input import Constraint, SessionInput, VertexConstraint
from ..core.targets import HandleSpec
from ..core.transforms import best_rigid_fit, inverted, transformed
from ..scene import handle_motion, meshes, pose_key, shape_keys, versions
from ..scene.inputs import read_input
from ..scene.seen.look import look
from . import evaluated_mesh, pins
from .drag import Lever
from .region import Joint, PulledPatch, fine_of, hold_of_rest, joint_of, with_root


@dataclass(frozen=True)
class Pull:
    """The input of a session for one drag, and how the drag moves it; no Blender data.

    Attributes:
        inputs: pins and handles of the object, temporary pins, ``grabs`` and, if the object has no pin, the rest of the
            mesh; all of them hold the place that is shown.
        grabs: the piece under the mouse, then its mirror images.
        rest: what holds the rest of the mesh, None if the object has a pin; one of ``inputs``.
        joint: of the piece under the mouse; None if it is on no limb, or if the object has a pin.
        shown: (n, 3) float32 the pose when the drag began.
        to_seen: (4, 4) object-space motion of the piece by modifiers and other shape keys, from the pose to what is
            seen.
    """

    inputs: SessionInput
    grabs: tuple[PulledPatch, ...]
    rest: HandleSpec | None
    joint: Joint | None
    shown: Float32s
    to_seen: Floats

    @property
    def holds(self) -> tuple[Constraint, ...]:
        return self.inputs.constraints

    def matrices(self, motion: Floats, world: Floats) -> Floats:
        """(h, 4, 4) object-space motions of everything that is held.

        Args:
            motion: (4, 4) world-space motion of the visible piece under the mouse.
            world: (4, 4) world matrix of the object.
        """
        result: Floats = np.tile(np.eye(4), (len(self.inputs.specs), 1, 1))
        to_world = world @ self.to_seen
        grabbed = inverted(to_world) @ motion @ to_world
        first = next(i for i, spec in enumerate(self.inputs.specs) if spec.vertices is self.grabs[0].vertices)
        for i, grab in enumerate(self.grabs):
            result[first + i] = grab.motion(grabbed, self._centre, self.inputs.stretch)
        return result

    def lever(self, world: Floats) -> Lever | None:
        """What the piece under the mouse hangs on, as seen; None if it is on no limb."""
        if self.joint is None:
            return None
        middle = self.shown[self.joint.vertices].mean(axis=0, dtype=np.float64)
        return Lever(transformed(world @ self.to_seen, middle), self.joint.length)

    @cached_property
    def _centre(self) -> Floats:
        """(3,) centre of the piece under the mouse."""
        centre: Floats = self.shown[self.grabs[0].vertices].mean(axis=0, dtype=np.float64)
        return centre


def begin_pull(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, grabs: Sequence[PulledPatch], begun: Pull | None = None
) -> Pull:
    """Reads the input of a drag of ``grabs``. Main thread only.

    Args:
        depsgraph: evaluates modifiers and other shape keys.
        grabs: the piece under the mouse, then its mirror images.
        begun: the drag that goes on with these grabs; None: a new drag.

    Raises:
        ValueError: as read_input(), but pins and handles may be missing; the key would not show the pose; or a pin
            or handle holds one of ``grabs``.
    """
    inputs = read_input(obj, depsgraph, needs_holds=False)
    key = pose_key.find(obj)
    if key is not None:
        shape_keys.check_shown(obj, key)
    grabs = _without_held(obj, grabs, inputs.specs)
    grabbed = np.concatenate([grab.vertices for grab in grabs])
    if begun is None and (reason := look(obj, depsgraph, grabbed)):
        raise ValueError(reason)
    shown = begun.shown if begun else pose_key.shown_positions(obj, inputs.mesh.rest_positions.astype(np.float32))
    others = _without(pins.grabs_of(obj), grabbed)
    added = [
        *(_spec_of(f"Pull Pin {i + 1}", pin) for i, pin in enumerate(others)),
        *(_spec_of(f"Pull {i + 1}", grab) for i, grab in enumerate(grabs)),
    ]
    rest = joint = None
    if not pins.has_set_pins(obj) and all(grab.reach > 0.0 for grab in grabs):
        fine = fine_of(inputs.mesh, inputs.stretch, versions.read_edges(obj.data))
        grabs = with_root(fine, grabs)
        rest = hold_of_rest(fine, [*others, *grabs], use_loose_parts=inputs.settings.use_loose_parts)
        joint = joint_of(fine, grabs[0])
        added.append(rest)
    holds = (*inputs.constraints, *(VertexConstraint(spec.name, spec.use_exact) for spec in added))
    motions = handle_motion.handle_matrices(obj, depsgraph) if inputs.specs else ()
    based = (
        *(_held_as_shown(spec, shown, motion) for spec, motion in zip(inputs.specs, motions, strict=True)),
        *(replace(spec, base=shown) for spec in added),
    )
    to_seen = begun.to_seen if begun else _to_seen(obj, depsgraph, grabs[0], shown)
    return Pull(replace(inputs, specs=based, constraints=holds, shown=shown), grabs, rest, joint, shown, to_seen)


def _spec_of(name: str, grab: PulledPatch) -> HandleSpec:
    return HandleSpec(name, grab.vertices, np.ones(len(grab.vertices)), use_exact=False)


def _held_as_shown(spec: HandleSpec, shown: Float32s, motion: Floats) -> HandleSpec:
    if spec.segment is None:
        return replace(spec, base=shown)
    return replace(spec, segment=replace(spec.segment, motion=motion))


def _without(grabs: Sequence[PulledPatch], vertices: Ints) -> tuple[PulledPatch, ...]:
    """The grabs without these vertices; empty ones are left out."""
    left = (replace(grab, vertices=np.setdiff1d(grab.vertices, vertices)) for grab in grabs)
    return tuple(grab for grab in left if len(grab.vertices))


def _without_held(
    obj: bpy.types.Object, grabs: Sequence[PulledPatch], specs: Sequence[HandleSpec]
) -> tuple[PulledPatch, ...]:
    held = [spec.vertices[spec.weights >= 1.0] for spec in specs]
    left = _without(grabs, np.concatenate([np.empty(0, dtype=np.int32), *held]))
    if len(left) < len(grabs):
        raise ValueError(f"This part of '{obj.name}' is held by a pin or handle: pull another part, or move the handle")
    return left


def _to_seen(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, grab: PulledPatch, shown: Float32s) -> Floats:
    world = meshes.read_matrix(obj, depsgraph)
    seen = evaluated_mesh.read(obj, depsgraph).positions[grab.vertices]
    in_object = transformed(inverted(world), seen)
    posed = shown[grab.vertices].astype(np.float64)
    size = np.abs(shown).max()
    if np.abs(in_object - posed).max() <= 1e-6 * size:
        return np.eye(4)
    return best_rigid_fit(posed, in_object, meshes.read_stretch(obj, depsgraph))
