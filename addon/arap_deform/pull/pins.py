# SPDX-License-Identifier: GPL-3.0-or-later
"""The temporary pins of ARAP Pull: what was pulled or clicked, saved with the object so that undo knows it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Ints
from ..core.patches import diagonal_of
from ..scene import groups, handle_motion, meshes
from ..setup.handles import add_handle
from ..setup.pins import add_pin
from .region import Grab, hold_of_rest

if TYPE_CHECKING:
    from ..props.pull import ArapPullPin

MOVED = 1e-4  # how far a piece at rest may be from its rest shape, as a fraction of the diagonal


def grabs_of(obj: bpy.types.Object) -> list[Grab]:
    """What the temporary pins hold."""
    return [Grab(pin.vertices, pin.reach) for pin in obj.arap.pull_pins]


def has_set_pins(obj: bpy.types.Object) -> bool:
    """Whether somebody has said what stays: a pin or handle of the object, or a pin by a click."""
    settings = obj.arap
    return (
        any(pin.reach == 0.0 for pin in settings.pull_pins)
        or any(pin.is_enabled for pin in settings.pins)
        or any(handle.is_enabled for handle in settings.handles)
    )


def find(obj: bpy.types.Object, vertices: Ints) -> list[int]:
    """Indices of the temporary pins that hold one of these vertices."""
    return [i for i, pin in enumerate(obj.arap.pull_pins) if np.isin(pin.vertices, vertices).any()]


def add(obj: bpy.types.Object, grabs: Sequence[Grab]) -> None:
    """Makes temporary pins; of vertices that others hold, the new one has them."""
    for grab in grabs:
        remove_vertices(obj, grab.vertices)
        pin: ArapPullPin = obj.arap.pull_pins.add()
        pin.vertices = grab.vertices
        pin.reach = grab.reach
        pin.n_vertices = len(obj.data.vertices)


def remove_vertices(obj: bpy.types.Object, vertices: Ints) -> None:
    """Takes vertices from all temporary pins; one without any is gone."""
    pins = obj.arap.pull_pins
    for i in reversed(find(obj, vertices)):
        left = np.setdiff1d(pins[i].vertices, vertices)
        if len(left):
            pins[i].vertices = left
        else:
            pins.remove(i)


def remove(obj: bpy.types.Object, indices: Sequence[int]) -> None:
    """Lets go."""
    for i in sorted(indices, reverse=True):
        obj.arap.pull_pins.remove(i)


def forget_stale(obj: bpy.types.Object) -> None:
    """Lets go of those whose mesh has got another number of vertices: theirs are gone, or others by now."""
    pins = obj.arap.pull_pins
    remove(obj, [i for i, pin in enumerate(pins) if pin.n_vertices != len(obj.data.vertices)])


def objects_with_pins() -> list[bpy.types.Object]:
    """Of this file, not linked."""
    return [obj for obj in bpy.data.objects if obj.type == "MESH" and obj.library is None and obj.arap.pull_pins]


def make_real(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple[int, int]:
    """Turns the temporary pins into handles and pins of the object; the mesh does not move.

    A piece that is at rest becomes a pin, one that has moved a handle with an empty where the pose has taken it. Where
    nobody has set a pin, the rest of the mesh that was held becomes a pin too.

    Returns:
        How many handles and how many pins were made.

    Raises:
        ValueError: there are no temporary pins, or as add_pin() and add_handle().
    """
    meshes.check_mesh(obj)
    forget_stale(obj)
    grabs = grabs_of(obj)
    if not grabs:
        raise ValueError(f"Nothing of '{obj.name}' has been pulled or pinned with the tool: drag or click it first")
    rest = meshes.read_rest(obj)
    shown = handle_motion.shown_positions(obj, rest)
    has_moved = np.abs(shown - rest).max(axis=1) > MOVED * diagonal_of(rest)
    hold = None
    if not has_set_pins(obj):
        hold = _hold_at_rest(obj, depsgraph, grabs, rest, has_moved)
    n_handles = 0
    for grab in grabs:
        if has_moved[grab.vertices].any():
            add_handle(obj, grab.vertices, name="Pull")
            n_handles += 1
        else:
            add_pin(obj, grab.vertices, name="Hold")
    if hold is not None:
        pin = add_pin(obj, hold[0], name="Rest")
        groups.write(obj, pin.name, *hold)
    obj.arap.pull_pins.clear()
    return n_handles, len(grabs) - n_handles + (hold is not None)


def _hold_at_rest(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    grabs: Sequence[Grab],
    rest: NDArray[np.float32],
    has_moved: NDArray[np.bool_],
) -> tuple[Ints, NDArray[np.float64]] | None:
    """Vertices and weights of what is held beyond the falloff, as far as a pin can: what is at rest."""
    seen = rest.astype(np.float64) @ meshes.read_stretch(obj, depsgraph).T
    hold = hold_of_rest(seen, meshes.read_edges(obj), grabs)
    # What is held softly has moved in the pull itself, and a pin holds it as softly.
    was_posed = has_moved[hold.vertices[hold.weights >= 1.0]].any()
    is_pinned = ~has_moved[hold.vertices] | ~was_posed
    return (hold.vertices[is_pinned], hold.weights[is_pinned]) if is_pinned.any() else None
