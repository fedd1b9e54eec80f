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
from ..engine.mesh import counts_problem
from ..scene import known, meshes, versions
from ..scene.snapshot import counts_of
from ..setup.made_objects import collection_for_made

CELLS = 5
"""Cubes along the longest side of the mesh: few vertices to move by hand."""


class CageJob(BackgroundJob["tuple[Floats, Ints]"]):
    """A Job that makes a cage, see make_cage(). It holds no Blender data."""

    noun = "cage"

    def __init__(self, obj: bpy.types.Object, cells: int) -> None:
        """Begins. Raises ValueError if the object has no mesh of this file, is disabled, or stands for others."""
        meshes.check_mesh(obj)
        meshes.check_local(obj)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        if reason := meshes.why_not_evaluated(obj, depsgraph):
            raise ValueError(reason)
        if obj.arap.is_stand_in:
            raise ValueError(
                f"'{obj.name}' stands for meshes that a cage would not move: make a cage around each of them"
            )
        self.uid = known.add(obj)
        self.object_name: str = obj.name  # for messages
        self.warning = f"What is attached to '{obj.name}' does not follow its cage" if obj.arap.attachments else ""
        self._counts = counts_of(obj)
        stretch = meshes.read_stretch(obj, depsgraph)
        self._space = SolverSpace(stretch)
        # What the cage is around is what comes into the modifier, see _bind().
        mirrors = meshes.read_mirrors(obj, depsgraph, stretch) if meshes.begins_mirrored(obj) else ()
        mesh, whole = completed(meshes.read_mesh(obj), mirrors, stretch)
        keyed = versions.read_shape_of_keys(obj).astype(np.float64)
        shown = self._space.to_solver(keyed if whole is None else whole.lifted(keyed))
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
        if reason := counts_problem(obj, self._counts):
            raise RuntimeError(f"{reason} while its cage was made: start again")
        cage = _new_object(obj, positions @ self._space.unstretch.T, quads)
        if not _bind(obj, cage):
            mesh = cage.data
            bpy.data.objects.remove(cage)
            bpy.data.meshes.remove(mesh)
            raise RuntimeError(f"Blender could not bind '{obj.name}' to its cage: make one with more Cells")
        return cage


def make_cage(obj: bpy.types.Object, cells: int = CELLS) -> bpy.types.Object:
    """Makes a coarse closed mesh around the mesh as its shape keys show it, and binds that by a modifier Mesh Deform.

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
    """Adds the modifier, before all others but a first Mirror that completes the mesh. False: not bound, and gone."""
    modifier = obj.modifiers.new(cage.name, "MESH_DEFORM")
    modifier.object = cage
    place = int(meshes.begins_mirrored(obj))
    obj.modifiers.move(len(obj.modifiers) - 1, place)
    with bpy.context.temp_override(object=obj):
        bpy.ops.object.meshdeform_bind(modifier=modifier.name)
    if modifier.is_bound:
        return True
    obj.modifiers.remove(modifier)
    return False
