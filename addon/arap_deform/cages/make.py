# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a coarse closed mesh around a mesh, which moves it by Blender's modifier Mesh Deform."""

from __future__ import annotations

import bpy
import numpy as np

from ..core import naming, native
from ..core.arrays import Floats, Ints
from ..core.background import stage
from ..core.job import BackgroundJob, run_job
from ..core.mirror import completed
from ..core.transforms import SolverSpace
from ..scene import known, meshes, pose_key
from ..setup.made_objects import collection_for_made

CELLS = 5
"""Cubes along the longest side of the mesh: few vertices to move by hand."""


class CageJob(BackgroundJob["tuple[Floats, Ints]"]):
    """A Job that makes a cage, see make_cage(). It holds no Blender data."""

    noun = "cage"
    warning = ""

    def __init__(self, obj: bpy.types.Object, cells: int) -> None:
        """Begins. Raises ValueError if the object has no mesh of this file, or is disabled."""
        meshes.check_mesh(obj)
        meshes.check_local(obj)
        self.uid = known.add(obj)
        self.object_name: str = obj.name  # for messages
        depsgraph = bpy.context.evaluated_depsgraph_get()
        if reason := meshes.why_not_evaluated(obj, depsgraph):
            raise ValueError(reason)
        stretch = meshes.read_stretch(obj, depsgraph)
        self._space = SolverSpace(stretch)
        mesh, whole = completed(meshes.read_mesh(obj), meshes.read_mirrors(obj, depsgraph, stretch), stretch)
        shown = pose_key.shown_positions(obj, meshes.read_rest(obj)).astype(np.float64)
        shown = self._space.to_solver(shown if whole is None else whole.lifted(shown))
        job = native.load().begin_make_cage(shown, mesh.corner_vertices, mesh.face_sizes, cells)
        super().__init__(stage(job, f"Making a cage for '{obj.name}' was cancelled; nothing has changed"))

    @property
    def status(self) -> str:
        return f"around {self.object_name}, {self.fraction:.0%}"

    def finish(self) -> bpy.types.Object:
        """Makes the cage and binds the mesh to it. Raises RuntimeError if the object is gone or Blender cannot bind."""
        positions, quads = self._result()
        obj = known.find(self.uid)
        if obj is None:
            raise RuntimeError(f"'{self.object_name}' is gone: its cage was not made")
        cage = _new_object(obj, positions @ self._space.unstretch.T, quads)
        if not _bind(obj, cage):
            mesh = cage.data
            bpy.data.objects.remove(cage)
            bpy.data.meshes.remove(mesh)
            raise RuntimeError(f"Blender could not bind '{obj.name}' to its cage: make one with more Cells")
        return cage


def make_cage(obj: bpy.types.Object, cells: int = CELLS) -> bpy.types.Object:
    """Makes a coarse closed mesh around the mesh as it is posed, and binds the mesh to it by a modifier Mesh Deform.

    The cage is a child of the object, in one of the object's enabled collections, drawn as wires and not rendered. Its
    place is locked: Blender takes the mesh along with the vertices of the cage, not with the cage as an object.

    Args:
        cells: cubes along the longest side of the mesh, 2 to 50.

    Returns:
        The cage.
    """
    return run_job(CageJob(obj, cells))


def _new_object(obj: bpy.types.Object, positions: Floats, quads: Ints) -> bpy.types.Object:
    name = naming.cut(f"{obj.name} Cage")
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(positions.tolist(), [], quads.tolist())
    cage = bpy.data.objects.new(name, mesh)
    cage.parent = obj
    cage.display_type = "WIRE"
    cage.hide_render = True
    # Blender takes the mesh along with the vertices of the cage, not with the cage as an object.
    cage.lock_location = cage.lock_rotation = cage.lock_scale = (True, True, True)
    collection_for_made(obj).objects.link(cage)
    bpy.context.view_layer.update()
    return cage


def _bind(obj: bpy.types.Object, cage: bpy.types.Object) -> bool:
    """Adds the modifier, before all others but a Mirror that completes the mesh. False: it is not bound, and gone."""
    modifier = obj.modifiers.new(cage.name, "MESH_DEFORM")
    modifier.object = cage
    obj.modifiers.move(len(obj.modifiers) - 1, meshes.first_after_mirror(obj))
    with bpy.context.temp_override(object=obj):
        bpy.ops.object.meshdeform_bind(modifier=modifier.name)
    if modifier.is_bound:
        return True
    obj.modifiers.remove(modifier)
    return False
