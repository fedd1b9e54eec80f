# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins and handles of an object: making, removing, resetting, reading."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .properties import ArapHandle, ArapPin

VertexIndices = Sequence[int] | NDArray[np.integer]


def add_pin(obj: bpy.types.Object, vertices: VertexIndices, name: str = "Pin") -> ArapPin:
    """Makes a vertex group of ``vertices`` (weight 1) and pins it at rest."""
    raise NotImplementedError


def add_pin_group(obj: bpy.types.Object, vertex_group: str) -> ArapPin:
    """Pins an existing vertex group; where it is pinned already, returns that pin, enabled."""
    raise NotImplementedError


def remove_pin(obj: bpy.types.Object, index: int) -> None:
    """Removes a pin, and its vertex group where the pin made it and nothing else uses it."""
    raise NotImplementedError


def add_handle(
    obj: bpy.types.Object,
    vertices: VertexIndices,
    name: str = "Handle",
    location: Sequence[float] | None = None,
) -> ArapHandle:
    """Makes a vertex group of ``vertices`` (weight 1) and an empty that moves it.

    The empty stands at the group's centroid (or at ``location``, world space), sized to the group, in the object's
    collections. On a posed mesh it stands where the pose has taken the group, and the mesh does not move.
    """
    raise NotImplementedError


def add_handle_for(
    obj: bpy.types.Object, target: bpy.types.Object, bone: str = "", radius: float | None = None
) -> ArapHandle:
    """Makes a handle for an existing object, or a bone of an armature, with a vertex group of its own.

    Args:
        radius: world units; the group takes the vertices, as posed, within this distance of the target's origin
            (the bone's head), or the nearest one where there is none, or where ``radius`` is None.
    """
    raise NotImplementedError


def add_handles_for(
    obj: bpy.types.Object, targets: Sequence[bpy.types.Object], radius: float | None = None
) -> list[ArapHandle]:
    """add_handle_for() each of ``targets``; all or none."""
    raise NotImplementedError


def remove_handle(obj: bpy.types.Object, index: int) -> None:
    """Removes a handle, and the vertex group and the empty it made where nothing else uses them."""
    raise NotImplementedError


def set_handle_target(obj: bpy.types.Object, index: int, target: bpy.types.Object, bone: str = "") -> None:
    """Gives a handle another object or bone. The mesh does not move: the new one takes over where it stands."""
    raise NotImplementedError


def set_handle_group(obj: bpy.types.Object, index: int, vertex_group: str) -> None:
    """Gives a handle another vertex group of ``obj``; its target stays."""
    raise NotImplementedError


def reset_handles(obj: bpy.types.Object) -> list[str]:
    """Puts every handle's object or bone back to where it is at rest.

    Returns:
        Names of the handles that something else (animation, a constraint, a driver) holds away from there.
    """
    raise NotImplementedError


def handle_problem(obj: bpy.types.Object, index: int) -> str:
    """Why a handle cannot work (no object, object deleted, bone or group missing ...), one sentence; '' if it can."""
    raise NotImplementedError


def handle_matrices(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> NDArray[np.float64]:
    """(h, 4, 4) float64 object-space motion of each enabled pin (identity), then of each enabled handle.

    (O_now^-1 M_now)(O_rest^-1 M_rest)^-1, of evaluated matrices. The order is that of the session's handles.
    """
    raise NotImplementedError


def update_handle_display(obj: bpy.types.Object) -> None:
    """Gives the empties that the handles made the shape, size and colour of ``obj.arap``."""
    raise NotImplementedError
