# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads cages: where their vertices are now, and why one cannot move its mesh."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bmesh
import bpy
import numpy as np

from ...core.arrays import Floats, Ints
from ...core.cages.session import Cage
from ...core.session_data import SessionMesh
from ...core.session_input import CageHold
from ...core.transforms import transformed
from ...props.bounds import bounded
from .. import meshes, versions
from . import saved

if TYPE_CHECKING:
    from ...props.handles import ArapHandle


def enabled_cage(obj: bpy.types.Object) -> ArapHandle | None:
    """The cage that moves the mesh; None if handles and pins do."""
    return next((handle for handle in obj.arap.handles if handle.is_cage and handle.is_enabled), None)


def check_no_cage(obj: bpy.types.Object) -> None:
    """Raises ValueError if a cage moves the mesh, for what moves handles or the surface."""
    cage = enabled_cage(obj)
    if cage is not None:
        raise ValueError(f"Cage '{cage.name}' moves '{obj.name}', so handles rest: switch it off first")


def is_cage_of(cage: bpy.types.Object, obj: bpy.types.Object) -> bool:
    """Whether an object is one of the mesh's cages, enabled or not."""
    return any(handle.is_cage and handle.target == cage for handle in obj.arap.handles)


def problem_of(obj: bpy.types.Object, handle: ArapHandle, depsgraph: bpy.types.Depsgraph) -> str:
    """Why a cage whose object is evaluated cannot move the mesh, without its name; '' if it can."""
    target = handle.target
    if target.type != "MESH":
        return f"'{target.name}' is not a mesh; choose a closed mesh around '{obj.name}'"
    if not len(target.data.polygons):
        return f"'{target.name}' has no faces; choose a closed mesh around '{obj.name}'"
    others = [h.name for h in obj.arap.handles if h.is_cage and h.is_enabled and h != handle]
    if others and handle.is_enabled:
        return f"only one cage can move a mesh, and '{others[0]}' is on, too; switch one off"
    n_rest = len(saved.rest_of(handle))
    if not n_rest:
        return f"what is saved of '{target.name}' is damaged; press Add Cage again"
    return other_number(handle, n_rest, _count(target, depsgraph))


def why_wait(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> str:
    """What is wrong with the vertices of the cage, '' if nothing is: the next step of undo may bring them back."""
    cage = enabled_cage(obj)
    if cage is None or cage.target is None or cage.target.type != "MESH":
        return ""
    n_rest = len(saved.rest_of(cage))
    return other_number(cage, n_rest, _count(cage.target, depsgraph)) if n_rest else ""


def other_number(handle: ArapHandle, n_rest: int, n_now: int) -> str:
    """Why a cage with so many vertices cannot move the mesh, '' if it can."""
    if n_now == n_rest:
        return ""
    return (
        f"'{handle.target.name}' has {n_now} vertices now, but had {n_rest}; undo that, switch off the modifier that "
        "does it, or press Add Cage again"
    )


def _count(cage: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> int:
    """Vertices as evaluated; in Edit Mode those that are edited."""
    if cage.data.is_editmode:
        return len(bmesh.from_edit_mesh(cage.data).verts)
    return len(cage.evaluated_get(depsgraph).data.vertices)


def positions_now(handle: ArapHandle, depsgraph: bpy.types.Depsgraph, world: Floats) -> Floats:
    """(c, 3) the evaluated vertices of a cage that works, also in Edit Mode, in the space of the mesh inside.

    Args:
        world: (4, 4) matrix of that mesh.

    Raises:
        ValueError: there are more vertices, or fewer, than at rest.
    """
    positions = evaluated_positions(handle.target, depsgraph, world)
    if reason := other_number(handle, len(saved.rest_of(handle)), len(positions)):
        raise ValueError(f"Cage '{handle.name}': {reason}")
    return positions


def evaluated_positions(cage: bpy.types.Object, depsgraph: bpy.types.Depsgraph, world: Floats) -> Floats:
    """As positions_now(), of any mesh object."""
    with _evaluated(cage, depsgraph) as mesh:
        local = versions.read_positions(mesh).astype(np.float64)
    return transformed(np.asarray(np.linalg.inv(world) @ meshes.read_matrix(cage, depsgraph)), local)


@contextmanager
def _evaluated(cage: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Iterator[bpy.types.Mesh]:
    evaluated = cage.evaluated_get(depsgraph)
    if not cage.data.is_editmode:
        yield evaluated.data
        return
    try:  # the evaluated mesh has no vertices while it is edited, if no modifier makes some
        yield evaluated.to_mesh()
    finally:
        evaluated.to_mesh_clear()


def hold_of(handle: ArapHandle) -> CageHold:
    """What a frame compares with the session."""
    corners, sizes = _faces(handle)
    return CageHold(
        handle.name,
        bounded(handle, "coordinates"),
        handle.cage_rest_id,
        zlib.crc32(sizes.tobytes(), zlib.crc32(corners.tobytes())),
        handle.shape_id,
    )


def cage_of(handle: ArapHandle, rest: Floats) -> Cage:
    """A cage that works. ``rest``: (n, 3) the mesh inside, at rest.

    Raises:
        ValueError: the cage was added to a pose of a mesh with another number of vertices.
    """
    vertices, offsets, n = handle.shape
    base = None
    if len(vertices):
        if n != len(rest):
            raise ValueError(
                f"Cage '{handle.name}': '{handle.id_data.name}' has {len(rest)} vertices now, but had {n} when the "
                "cage was added to its pose; press Add Cage again"
            )
        base = rest.copy()
        base[vertices] += offsets
    return Cage(handle.name, SessionMesh(saved.rest_of(handle), *_faces(handle)), bounded(handle, "coordinates"), base)


def _faces(handle: ArapHandle) -> tuple[Ints, Ints]:
    """Corners and sizes, as when Edit Mode was left last; none if the object is gone."""
    if handle.target is None or handle.target.type != "MESH":
        return np.zeros(0, np.int32), np.zeros(0, np.int32)
    return meshes.read_faces(handle.target.data)
