# SPDX-License-Identifier: GPL-3.0-or-later
"""The temporary pins of ARAP Pull: pieces that were pulled or clicked. The object saves them, so undo restores them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core.arrays import Float32s, Ints
from ..core.patches import diagonal_of
from ..core.targets import HandleSpec
from ..props.bounds import bounded
from ..scene import groups, known, meshes, pose_key, preserve_shape, versions
from ..setup.handles import add_handle
from ..setup.names import name_for
from ..setup.pins import add_pin
from .region import PulledPatch, fine_of, hold_of_rest

if TYPE_CHECKING:
    from ..props.controls import ArapControl
    from ..props.pull import ArapPullPin

MOVED = 1e-4  # a vertex this far from rest has moved, as a fraction of the diagonal


def grabs_of(obj: bpy.types.Object) -> list[PulledPatch]:
    """The pieces that the temporary pins hold."""
    return [PulledPatch(pin.vertices, bounded(pin, "reach"), bounded(pin, "root")) for pin in obj.arap.pull_pins]


def has_set_pins(obj: bpy.types.Object) -> bool:
    """Whether the object has an enabled pin or handle, or a pin that was set by a click."""
    settings = obj.arap
    return any(pin.reach == 0.0 for pin in settings.pull_pins) or any(c.is_enabled for c in settings.controls)


def find(obj: bpy.types.Object, vertices: Ints) -> list[int]:
    """Indices of the temporary pins that hold one of these vertices."""
    return [i for i, pin in enumerate(obj.arap.pull_pins) if np.isin(pin.vertices, vertices).any()]


def add(obj: bpy.types.Object, grabs: Sequence[PulledPatch]) -> None:
    """Makes temporary pins. A new pin takes its vertices from older ones, and removes a pin that becomes empty."""
    pins = obj.arap.pull_pins
    for grab in grabs:
        for i in reversed(find(obj, grab.vertices)):
            left = np.setdiff1d(pins[i].vertices, grab.vertices)
            if len(left):
                pins[i].vertices = left
            else:
                pins.remove(i)
        pin: ArapPullPin = pins.add()
        pin.vertices = grab.vertices
        pin.reach = grab.reach
        pin.root = grab.root or 0.0
        pin.n_vertices = len(obj.data.vertices)


def remove(obj: bpy.types.Object, indices: Sequence[int]) -> None:
    for i in sorted(indices, reverse=True):
        obj.arap.pull_pins.remove(i)


def forget_stale(obj: bpy.types.Object) -> None:
    """Removes pins whose mesh had another number of vertices, so their indices are wrong, and damaged ones."""
    n = len(obj.data.vertices)
    remove(obj, [i for i, pin in enumerate(obj.arap.pull_pins) if pin.n_vertices != n or not len(pin.vertices)])


def objects_with_pins() -> list[bpy.types.Object]:
    """Objects of this file; linked ones are left out."""
    return [obj for obj in known.all_objects() if obj.type == "MESH" and obj.library is None and obj.arap.pull_pins]


def make_real(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple[int, int]:
    """Turns the temporary pins into handles and pins of the object; the mesh does not move.

    A piece at rest becomes a pin. A piece that has moved becomes a handle, with an empty at its present place. If the
    object has no pin, the rest of the mesh, which the pull held, becomes a pin too. Solved again, the mesh stays.

    Returns:
        Counts of the new handles and of the new pins.

    Raises:
        ValueError: there are no temporary pins, or as add_pin() and add_handle().
    """
    meshes.check_mesh(obj)
    forget_stale(obj)
    grabs = grabs_of(obj)
    if not grabs:
        raise ValueError(f"Nothing of '{obj.name}' has been pulled or pinned with the tool: drag or click it first")
    rest = meshes.read_rest(obj)
    shown = pose_key.shown_positions(obj, rest)
    has_moved = np.abs(shown - rest).max(axis=1) > MOVED * diagonal_of(rest)
    hold = None
    if not has_set_pins(obj):
        stretch = meshes.read_stretch(obj, depsgraph)
        fine = fine_of(meshes.read_mesh(obj), stretch, versions.read_edges(obj.data))
        hold = hold_of_rest(fine, grabs, use_loose_parts=obj.arap.use_loose_parts)
    first = len(obj.arap.controls)
    for grab in grabs:
        if has_moved[grab.vertices].any():
            add_handle(obj, grab.vertices, name=name_for(obj, grab.vertices))
        else:
            add_pin(obj, grab.vertices, name=name_for(obj, grab.vertices))
    if hold is not None and len(hold.vertices):
        rest_pin = obj.arap.controls[add_pin(obj, hold.vertices, name=hold.name)]
        groups.write(obj, rest_pin.vertex_group, hold.vertices, hold.weights)
    # All at once: each of them was added beside the ones before, but in the pull all of them held the mesh.
    made = obj.arap.controls[first:]
    preserve_shape.keep_shown_shape(obj, None, *made)
    if hold is not None and len(hold.vertices):
        _hold_as_pulled(obj, made[-1], hold, shown - rest)
    obj.arap.pull_pins.clear()
    n_pins = sum(control.is_pin for control in made)
    return len(made) - n_pins, n_pins


def remember_rest(obj: bpy.types.Object, hold: HandleSpec | None, start: Float32s) -> None:
    """Keeps where a drag pulled the softly held vertices to, for make_real().

    Args:
        hold: of the rest of the mesh, None if there was none.
        start: (n, 3) the pose when the drag began.
    """
    obj.arap.pull_rest.forget_base()
    if hold is not None:
        soft = hold.vertices[hold.weights < 1.0]
        obj.arap.pull_rest.set_base(soft, start[soft] - meshes.read_rest(obj)[soft])


def _hold_as_pulled(obj: bpy.types.Object, pin: ArapControl, hold: HandleSpec, offsets: Float32s) -> None:
    """Lets the pin of the rest pull as the last drag did: a softly held vertex is not where it is pulled to.

    Args:
        offsets: (n, 3) from rest to what is shown.
    """
    soft, pulled = obj.arap.pull_rest.base
    offsets[soft] = pulled
    pin.set_base(hold.vertices, offsets[hold.vertices])
