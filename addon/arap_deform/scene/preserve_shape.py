# SPDX-License-Identifier: GPL-3.0-or-later
"""A posed mesh stays where it is when pins and handles are added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core.arrays import Floats, Ints
from ..core.patches import Point, diagonal_of, without_points
from ..core.targets import HandleSpec, Patch
from ..core.transforms import has_no_inverse, inverted, transformed
from ..core.unbound import Pulls
from ..props import base_shape
from . import handle_motion, meshes, pose_key
from .constraint_preview import ConstraintPreview
from .registration import postponed

if TYPE_CHECKING:
    from ..props.controls import ArapControl

AT_PLACE = 1e-5  # a shape that is this near to that at rest is the one at rest, as a fraction of the diagonal


@dataclass
class _Entry:
    """A pin or handle, or a mirror image of one, in the whole mesh. ``entry`` is None for an image."""

    entry: ArapControl | None
    spec: HandleSpec
    matrix: Floats
    is_new: bool
    is_enabled: bool


def evaluated_within(obj: bpy.types.Object) -> bpy.types.Depsgraph:
    """The evaluated scene, in the middle of a change: a mesh that follows is solved with the next evaluation."""
    with postponed():
        depsgraph = bpy.context.evaluated_depsgraph_get()
    obj.update_tag()
    return depsgraph


def keep_shown_shape(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None, *added: ArapControl, use_nodes: bool | None = None
) -> None:
    """Lets new pins and handles hold what is shown, so that the mesh stays where it is when it is solved again.

    The new ones hold their vertices as they are shown. Point handles that they come near to keep their reach, without
    the vertices that the new ones hold. A new one that is disabled holds what is shown for when it is enabled.

    Args:
        depsgraph: for matrices; None: evaluated, if the mesh is posed.
        added: in their lists, with their groups and, for handles, their rest matrices.
        use_nodes: see versions.read_group_weights().
    """
    for entry in added:
        entry.forget_base()
    rest = meshes.read_rest(obj)
    shown = pose_key.shown_positions(obj, rest)
    if not np.array_equal(shown, rest):
        depsgraph = depsgraph or evaluated_within(obj)
        held = ConstraintPreview(obj, depsgraph, use_nodes=use_nodes)
        entries = _entries(obj, depsgraph, held, set(added))
        _keep_points(held, [entry for entry in entries if entry.is_enabled])
        _hold_shown(held, entries)


@dataclass(frozen=True)
class Bases:
    """What pins and handles hold. No Blender data.

    Attributes:
        entries: numbers of their bases, and reaches; by what says which entry it is.
        layers: the bases, see base_shape.capture().
    """

    entries: dict[tuple[str | int, ...], tuple[int, float]]
    layers: list[base_shape.Layer] | None


def capture_bases(obj: bpy.types.Object) -> Bases:
    """What restore_bases() restores."""
    entries = {place: (control.base_id, control.reach) for place, control in _places(obj).items()}
    return Bases(entries, base_shape.capture(obj.data))


def restore_bases(obj: bpy.types.Object, former: Bases) -> list[ArapControl]:
    """Restores what capture_bases() returned; returns the pins and handles that are new since then."""
    places = _places(obj)
    for place in places.keys() & former.entries.keys():
        places[place].base_id, places[place].reach = former.entries[place]
    base_shape.restore(obj.data, former.layers)
    return [entry for place, entry in places.items() if place not in former.entries]


def _places(obj: bpy.types.Object) -> dict[tuple[str | int, ...], ArapControl]:
    """By what says which entry it is: another one of the same name, or with another group or object, is new."""
    return {(control.number, *_choices_of(control)): control for control in obj.arap.controls}


def _choices_of(control: ArapControl) -> tuple[str | int, ...]:
    """The group, the object and the bone that the artist has chosen. What was made for the handle may be another."""
    group = "" if control.has_made_group else control.vertex_group
    target = None if control.has_made_target else control.target
    return (group, 0, "") if target is None else (group, target.session_uid, control.bone)


def _entries(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, held: ConstraintPreview, added: set[ArapControl]
) -> list[_Entry]:
    made: handle_motion.Made = {}
    entries = [
        entry
        for entry in obj.arap.controls
        if (entry.is_enabled or entry in added) and not handle_motion.problem_of(obj, entry, depsgraph, made)
    ]
    specs, copies = held.completed_specs(held.specs_of(entries))
    world = handle_motion.object_matrix(obj, depsgraph)
    motions = [np.eye(4) if entry.is_pin else handle_motion.motion_of(entry, depsgraph, world) for entry in entries]
    matrices = held.motions(np.array(motions), copies)
    return [
        _Entry(None if copy.image else entry, spec, matrix, entry in added, entry.is_enabled)
        for spec, matrix, copy in zip(specs, matrices, copies, strict=True)
        for entry in (entries[copy.handle],)
    ]


def _keep_points(held: ConstraintPreview, entries: Sequence[_Entry]) -> None:
    """Lets point handles near new entries pull the surface as before, and as far."""
    specs_before = [_empty(e.spec) if e.is_new else e.spec for e in entries]
    before, after = held.points(specs_before), held.points([e.spec for e in entries])
    near = [i for i in before if _reaches(before[i]) != _reaches(after.get(i, ()))]
    for i in near:
        if len(before[i]) == 1:  # else each piece has another reach
            reach = before[i][0].reach / held.surface.radius
            entries[i].spec = replace(entries[i].spec, reach=reach)
            if (entry := entries[i].entry) is not None:
                entry.reach = reach
    specs = [e.spec for e in entries]
    after = held.points(specs)
    was_held, is_held = held.is_held(specs_before, before), held.is_held(specs, after)
    for i in near:
        former, present = held.patches(before[i], was_held), held.patches(after.get(i, ()), is_held)
        if [len(patch.vertices) for patch in former] == [len(patch.vertices) for patch in present]:
            continue
        # If the mesh has not followed yet, it is still pulled as far.
        base = specs[i].base_or(held.mesh.rest_positions).astype(np.float64)
        averages = np.array([patch.weights @ base[patch.vertices] for patch in former])
        pulls = transformed(entries[i].matrix, averages) - [p.weights @ held.shown[p.vertices] for p in former]
        vertices = np.unique(np.concatenate([specs[i].vertices, *(patch.vertices for patch in present)]))
        _set_base(held, entries[i], vertices, held.shown[vertices] + pulls.mean(axis=0))


def _hold_shown(held: ConstraintPreview, entries: Sequence[_Entry]) -> None:
    """Lets new entries pull what they hold to where it is shown."""
    specs = [e.spec for e in entries]
    points = held.points(specs)
    is_held = held.is_held(specs, points)
    alone = [without_points(spec, points.get(i, ())) for i, spec in enumerate(specs)]
    pulls = Pulls(len(held.shown))
    for spec, entry in zip(alone, entries, strict=True):
        if not entry.is_new:
            base = spec.base_or(held.mesh.rest_positions)[spec.vertices].astype(np.float64)
            pulls.add(spec.vertices, spec.weights, transformed(entry.matrix, base))
    for i, entry in enumerate(entries):
        if not entry.is_new or entry.entry is None:
            continue
        patches = held.patches(points.get(i, ()), is_held)
        spec = alone[i]
        if len(patches) == 1 and not len(spec.vertices) and _is_shown(held, entry, patches[0]):
            continue  # it stands at the average that is shown
        targets = pulls.staying_targets(spec.vertices, spec.weights, held.shown[spec.vertices])
        vertices = np.unique(np.concatenate([specs[i].vertices, *(patch.vertices for patch in patches)]))
        places = held.shown[vertices]
        places[np.searchsorted(vertices, spec.vertices)] = targets
        _set_base(held, entry, vertices, places)
        if entry.is_enabled:
            pulls.add(spec.vertices, spec.weights, targets)


def _is_shown(held: ConstraintPreview, entry: _Entry, patch: Patch) -> bool:
    """Whether the average of the patch at rest, moved by the handle, is the one that is shown."""
    average = transformed(entry.matrix, patch.weights @ held.mesh.rest_positions[patch.vertices])
    off = held.stretch @ (average - patch.weights @ held.shown[patch.vertices])
    return bool(np.linalg.norm(off) <= AT_PLACE * diagonal_of(held.surface.seen))


def _set_base(held: ConstraintPreview, entry: _Entry, vertices: Ints, targets: Floats) -> None:
    """Lets an entry hold the vertices so that it pulls them to (k, 3) ``targets`` where it is now."""
    is_own = vertices < held.n_own
    vertices, targets = vertices[is_own], targets[is_own]
    # A group may be empty until it is painted, and a handle may be scaled to nothing.
    if entry.entry is None or not len(vertices) or has_no_inverse(entry.matrix):
        return
    back: Floats = inverted(entry.matrix)
    offsets = transformed(back, targets) - held.mesh.rest_positions[vertices]
    if np.abs(offsets @ held.stretch.T).max() > AT_PLACE * diagonal_of(held.surface.seen):
        entry.entry.set_base(vertices, offsets)


def _empty(spec: HandleSpec) -> HandleSpec:
    return replace(spec, vertices=spec.vertices[:0], weights=spec.weights[:0])


def _reaches(points: Sequence[Point]) -> list[float]:
    return [point.reach for point in points]
