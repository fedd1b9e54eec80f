# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages of an object: made around it, or chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core import naming, native
from ..core.arrays import Floats, Ints
from ..core.background import stage
from ..core.job import BackgroundJob, run_job
from ..core.transforms import SolverSpace
from ..scene import handle_motion, known, meshes, pose_key
from ..scene.cages import read
from ..setup.handle_changes import making, take_over
from ..setup.handles import all_or_none, new_handle
from ..setup.made_objects import collection_for_made

if TYPE_CHECKING:
    from ..props.handles import ArapHandle

CELLS = 5
"""Cubes along the longest side of the mesh: few vertices to move by hand."""


class CageJob(BackgroundJob["tuple[Floats, Ints]"]):
    """A Job that makes a cage, see make_cage(). It holds names, no Blender data."""

    noun = "cage"
    warning = ""

    def __init__(self, obj: bpy.types.Object, cells: int, coordinates: str = "mean_value") -> None:
        """Begins. Raises ValueError if the object has no mesh of this file."""
        meshes.check_mesh(obj)
        meshes.check_local(obj)
        self.uid = known.add(obj)
        self.object_name: str = obj.name  # for messages
        self._coordinates = coordinates
        self._space = SolverSpace(meshes.read_stretch(obj, bpy.context.evaluated_depsgraph_get()))
        shown = self._space.to_solver(pose_key.shown_positions(obj, meshes.read_rest(obj)).astype(np.float64))
        job = native.load().begin_make_cage(shown, *meshes.read_faces(obj.data), cells)
        super().__init__(stage(job, f"Making a cage for '{obj.name}' was cancelled; nothing has changed"))

    @property
    def status(self) -> str:
        return f"around {self.object_name}, {self.fraction:.0%}"

    def finish(self) -> ArapHandle:
        """Adds the cage. Raises as add_cage(), or RuntimeError if the object is gone."""
        positions, quads = self._result()
        obj = self.find_object()
        cage = _new_object(obj, positions @ self._space.unstretch.T, quads)
        try:
            handle = add_cage(obj, cage, self._coordinates)
        except BaseException:
            mesh = cage.data
            bpy.data.objects.remove(cage)
            bpy.data.meshes.remove(mesh)
            raise
        handle.has_made_target = True
        return handle

    def find_object(self) -> bpy.types.Object:
        """The mesh. Raises RuntimeError if it is gone."""
        obj = known.find(self.uid)
        if obj is None:
            raise RuntimeError(f"'{self.object_name}' is gone: its cage was not made")
        return obj


def make_cage(obj: bpy.types.Object, cells: int = CELLS, coordinates: str = "mean_value") -> ArapHandle:
    """Makes a coarse closed mesh around the mesh as it is shown, which moves all of it.

    It is a child of the object, in one of the object's enabled collections, drawn as wires and not rendered. Handles
    and pins rest, and a former cage is switched off.

    Args:
        cells: cubes along the longest side of the mesh, 2 to 50.
        coordinates: how the mesh hangs on it: "mean_value", "harmonic" or "green".

    Returns:
        Its handle; edit the mesh of its ``target``.
    """
    return run_job(CageJob(obj, cells, coordinates))


def add_cage(obj: bpy.types.Object, cage: bpy.types.Object, coordinates: str = "") -> ArapHandle:
    """Makes a closed mesh object around the mesh move all of it.

    Its present shape is its rest, at which the mesh stays as it is shown; of a cage that the mesh has already, too.
    Handles and pins rest, and a former cage is switched off.

    Args:
        cage: triangles and quads. With "mean_value" the mesh may be partly outside.
        coordinates: as for make_cage(); "": those that it has, or "mean_value".

    Returns:
        Its handle.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    read.flush(cage)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    reason = handle_motion.target_problem(obj, cage, "", depsgraph)
    reason = reason or read.why_no_cage(obj, cage, depsgraph)
    if reason:
        raise ValueError(f"'{obj.name}' cannot take the cage: {reason}")
    with all_or_none(obj):
        handle = next((h for h in obj.arap.handles if h.is_cage and h.target == cage), None) or _new(obj, cage)
        if handle_motion.other_owner(obj, handle) is not None:
            handle.has_made_target = False  # of the mesh that this is a copy of: now the artist has chosen it
        if coordinates:
            handle.coordinates = coordinates
        take_over(obj, handle)
    handle.is_enabled = True  # which switches off the others
    return handle


def _new(obj: bpy.types.Object, cage: bpy.types.Object) -> ArapHandle:
    with making():
        handle = new_handle(obj, "", cage.name)
        handle.is_cage = True
        handle.is_enabled = False  # until its rest is known: a mesh that follows looks at it at any time
        handle.target = cage
    return handle


def _new_object(obj: bpy.types.Object, positions: Floats, quads: Ints) -> bpy.types.Object:
    name = naming.cut(f"{obj.name} Cage")
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(positions.tolist(), [], quads.tolist())
    cage = bpy.data.objects.new(name, mesh)
    cage.parent = obj
    cage.display_type = "WIRE"
    cage.hide_render = True
    collection_for_made(obj).objects.link(cage)
    bpy.context.view_layer.update()
    return cage
