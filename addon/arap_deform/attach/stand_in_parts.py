# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes that are posed together: may they be, and read as one shape."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import bpy
import numpy as np

from ..core.arrays import Floats, check_places
from ..core.stand_in.shape import Shape, triangles_of
from ..core.transforms import transformed
from ..scene import handle_motion, meshes, pose_key
from ..scene.points import objects as points
from . import problems

VERTICES = 200_000
"""Of a stand-in, if nothing else is said."""
NAME = "Stand-in"


def pieces_of(objects: Iterable[bpy.types.Object]) -> list[bpy.types.Object]:
    """Without those that are attached to another one of them, directly or through others: they stay so."""
    chosen = dict.fromkeys(objects)
    return [obj for obj in chosen if chosen.keys().isdisjoint(problems.above(obj, problems.owner_of))]


def why_needless(pieces: Sequence[bpy.types.Object], vertices: int) -> str:
    """Why a stand-in of so many vertices is of no use, '' if it is: one mesh is posed itself, unless it is heavy."""
    if not pieces:
        return "Select the meshes to pose together first"
    if len(pieces) > 1 or pieces[0].type != "MESH" or len(pieces[0].data.vertices) > vertices:
        return ""
    name = pieces[0].name
    return f"Select other meshes, too: '{name}' alone has no more than {vertices:,} vertices and can be posed itself"


def why_not_local(piece: bpy.types.Object) -> str:
    """Why Blender would not save a pose of the mesh, '' if it would, and for what is no mesh."""
    try:
        if piece.type == "MESH":
            meshes.check_local(piece)
    except ValueError as error:
        return str(error)
    return ""


def check(pieces: Sequence[bpy.types.Object], vertices: int) -> None:
    """Raises ValueError if they cannot be posed together, and says what to do."""
    if vertices < 1:
        raise ValueError(f"vertices = {vertices}, must be >= 1")
    reason = why_needless(pieces, vertices)
    if reason:
        raise ValueError(reason)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    host = bpy.data.objects.new(NAME, None)  # has the name that the stand-in will have
    try:
        for piece in pieces:
            if points.has_points(piece) and piece.type != "MESH":
                raise ValueError(f"'{piece.name}' is no mesh: leave it out, and attach it to the stand-in")
            problems.check_new(host, piece, depsgraph)
    finally:
        bpy.data.objects.remove(host)


def read_shape(piece: bpy.types.Object, groups: Sequence[str]) -> Shape:
    """The mesh at rest, in the world. ``groups``: names, of which it need not have all.

    Raises:
        ValueError: a vertex is at no finite place.
    """
    world = handle_motion.object_matrix(piece, bpy.context.evaluated_depsgraph_get())
    rest = meshes.read_rest(piece)
    check_places(rest, piece.name)
    points: Floats = transformed(world, rest.astype(np.float64))
    weights = np.zeros((len(groups), len(points)), dtype=np.float32)
    own = [name for name in groups if name in piece.vertex_groups]
    for name, values in meshes.read_weights(piece, own).items():
        weights[groups.index(name)] = values
    triangles = triangles_of(*meshes.read_faces(piece.data))
    if np.linalg.det(world[:3, :3]) < 0.0:
        triangles = triangles[:, ::-1]  # mirrored, but its outside stays outside
    return Shape(points, triangles, weights)


def is_posed(piece: bpy.types.Object) -> bool:
    """Whether the mesh shows a pose of its own."""
    rest = meshes.read_rest(piece)
    return not np.array_equal(pose_key.shown_positions(piece, rest), rest)


def groups_of(pieces: Iterable[bpy.types.Object]) -> list[str]:
    """Names of the vertex groups of all, each once."""
    return list(dict.fromkeys(group.name for piece in pieces for group in piece.vertex_groups))


def pins_of(pieces: Iterable[bpy.types.Object]) -> list[str]:
    """Names of the vertex groups, of those that are there, that hold any of them."""
    pins = ((piece, pin) for piece in pieces for pin in piece.arap.pins)
    enabled = ((piece, pin.vertex_group) for piece, pin in pins if pin.is_enabled)
    return list(dict.fromkeys(group for piece, group in enabled if group in piece.vertex_groups))
