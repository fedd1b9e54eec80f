# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads cages: where their vertices are now, and why one cannot be a cage, or cannot move its mesh."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bmesh
import bpy
import numpy as np

from ...core import native
from ...core.arrays import Floats, Ints
from ...core.cages.session import Cage
from ...core.session_data import SessionMesh
from ...core.session_input import CageHold
from ...core.transforms import inverted, transformed
from ...props.bounds import bounded
from ...props.cage import may_be_cage
from .. import meshes, pose_key, versions
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
    n_rest = len(saved.rest_of(handle))
    if may_be_cage(target) and n_rest:
        return _other_number(handle, n_rest, _count(target, depsgraph))
    unknown = f"the shape of '{target.name}' at rest is not known; press Add Cage again"
    return why_no_cage(obj, target, depsgraph) or unknown


def why_no_cage(obj: bpy.types.Object, cage: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> str:
    """Why an object that is evaluated cannot be a cage of the mesh, whatever its coordinates; '' if it can.

    For drawing, too, so nothing is changed: in Edit Mode it has the faces as of the last flush().
    """
    if not may_be_cage(cage):
        lack = "is not a mesh" if cage.type != "MESH" else "has no faces"
        return f"'{cage.name}' {lack}; choose a closed mesh around '{obj.name}'"
    try:
        meshes.read_stretch(obj, depsgraph)
        positions = evaluated_positions(cage, depsgraph, meshes.read_matrix(obj, depsgraph))
        if reason := _made_more(cage, _count_edited(cage), len(positions)):
            return reason
        shown = pose_key.shown_positions(obj, meshes.read_rest(obj))
        # The box of the cage is inside of that of the mesh: the two were mistaken for each other.
        if ((positions.min(axis=0) > shown.min(axis=0)) & (positions.max(axis=0) < shown.max(axis=0))).all():
            return f"'{cage.name}' is inside of '{obj.name}'; choose a closed mesh around it"
        # A bind of one vertex takes no time, and checks the faces.
        native.load().CageDeformation(shown[:1], positions, *meshes.read_faces(cage.data))
    except native.ERRORS as error:
        return native.sentence_of(error)
    return ""


def flush(cage: bpy.types.Object) -> None:
    """Brings a mesh that is being edited up to date."""
    if cage.type == "MESH" and cage.data.is_editmode:
        cage.update_from_editmode()


def why_wait(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> str:
    """Why the mesh cannot follow its cage until the artist mends that, or the next step of undo does; '' if it can."""
    cage = enabled_cage(obj)
    if cage is None or cage.target is None or not may_be_cage(cage.target):
        return ""
    return problem_of(obj, cage, depsgraph) if meshes.is_evaluated(cage.target, depsgraph) else ""


def _other_number(handle: ArapHandle, n_rest: int, n_now: int) -> str:
    """Why a cage with so many vertices cannot move the mesh, '' if it can."""
    cage = handle.target
    if n_now == n_rest:
        return ""
    if reason := _made_more(cage, _count_edited(cage), n_now):
        return reason
    return f"'{cage.name}' has {n_now} vertices now, but had {n_rest}; undo that, or press Add Cage again"


def _made_more(cage: bpy.types.Object, n: int, n_evaluated: int) -> str:
    """What to do about modifiers that make another number of vertices, '' if none does."""
    if n == n_evaluated:
        return ""
    return (
        f"'{cage.name}' has {n} vertices, but {n_evaluated} with its modifiers; switch off the modifier that does it, "
        "or apply it and press Add Cage"
    )


def _count(cage: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> int:
    """Vertices as evaluated, also in Edit Mode."""
    if cage.data.is_editmode and not _is_modified(cage):
        return _count_edited(cage)
    with _evaluated(cage, depsgraph) as mesh:
        return len(mesh.vertices)


def _count_edited(cage: bpy.types.Object) -> int:
    """Vertices before its modifiers; in Edit Mode those that are edited."""
    return len(bmesh.from_edit_mesh(cage.data).verts if cage.data.is_editmode else cage.data.vertices)


def _is_modified(cage: bpy.types.Object) -> bool:
    """Whether modifiers show in Edit Mode."""
    return any(modifier.show_viewport and modifier.show_in_editmode for modifier in cage.modifiers)


def positions_now(handle: ArapHandle, depsgraph: bpy.types.Depsgraph, world: Floats) -> Floats:
    """(c, 3) the evaluated vertices of a cage that works, also in Edit Mode, in the space of the mesh inside.

    Args:
        world: (4, 4) matrix of that mesh.

    Raises:
        ValueError: there are more vertices, or fewer, than at rest.
    """
    positions = evaluated_positions(handle.target, depsgraph, world)
    if reason := _other_number(handle, len(saved.rest_of(handle)), len(positions)):
        raise ValueError(f"Cage '{handle.name}': {reason}")
    return positions


def evaluated_positions(cage: bpy.types.Object, depsgraph: bpy.types.Depsgraph, world: Floats) -> Floats:
    """As positions_now(), of any mesh object."""
    with _evaluated(cage, depsgraph) as mesh:
        local = versions.read_positions(mesh).astype(np.float64)
    return transformed(np.asarray(inverted(world) @ meshes.read_matrix(cage, depsgraph)), local)


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
