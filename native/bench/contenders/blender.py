# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's modifiers, with Blender as a module of Python. A step is the evaluation of the whole scene."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix
from measure.base.contender import BONE, CAGE, CAGE_GROUP, HANDLE, PIN, Floats, Make, PosedTask
from measure.base.workers import NotRun

from . import scene
from .bones import bones_of
from .carriers import Carrier, automatic_cage
from .ours import arrays
from .steps import diagonal

REPEAT = 10  # of Laplacian Deform, iterations
VOXEL = 0.03  # of the diagonal, of the copy for Surface Deform


class Modified:
    """A mesh in an empty scene, with a modifier."""

    version = bpy.app.version_string
    acts: Sequence[str] = ()

    def __init__(self, task: PosedTask) -> None:
        scene.clear()
        self._task, self._now = task, task.positions
        self._object = scene.new_mesh("Mesh", *arrays(task))

    def positions(self) -> Floats:
        return self._now


class LaplacianDeform(Modified):
    acts = (PIN, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        super().__init__(task)
        anchors = self._object.vertex_groups.new(name="Anchors")
        anchors.add(task.constrained.tolist(), 1.0, "REPLACE")
        modifier = self._object.modifiers.new("Laplacian Deform", "LAPLACIANDEFORM")
        modifier.vertex_group, modifier.iterations = anchors.name, REPEAT
        scene.bind(self._object, modifier, bpy.ops.object.laplaciandeform_bind, "is_bind")

    def pose(self, step: int) -> None:
        places = self._task.positions.copy()
        places[self._task.constrained] = self._task.targets[step]
        scene.move_vertices(self._object, places)
        self._now = scene.evaluated(self._object)


class Carried(Modified):
    """A modifier that hangs the mesh on another one."""

    def __init__(self, task: PosedTask, carrier: Carrier) -> None:
        super().__init__(task)
        self._carrier = carrier
        self._carrier_object = scene.new_mesh("Carrier", *carrier.arrays)

    def pose(self, step: int) -> None:
        scene.move_vertices(self._carrier_object, self._carrier.pose(step))
        self._now = scene.evaluated(self._object)


class MeshDeform(Carried):
    acts = (CAGE, CAGE_GROUP, CAGE_GROUP, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        super().__init__(task, automatic_cage(task))
        modifier = self._object.modifiers.new("Mesh Deform", "MESH_DEFORM")
        modifier.object = self._carrier_object
        scene.bind(self._object, modifier, bpy.ops.object.meshdeform_bind, "is_bound")


class SurfaceDeform(Carried):
    acts = ("a coarse copy", "the copy's vertices of a handle", "the copy's vertices of a handle", HANDLE)

    def __init__(self, task: PosedTask) -> None:
        super().__init__(task, coarse_copy(task))
        modifier = self._object.modifiers.new("Surface Deform", "SURFACE_DEFORM")
        modifier.target = self._carrier_object
        scene.bind(self._object, modifier, bpy.ops.object.surfacedeform_bind, "is_bound")


class Armature(Modified):
    def __init__(self, task: PosedTask, keeps_volume: bool) -> None:
        super().__init__(task)
        self._bones = task.bones or bones_of(task)
        self.acts = (BONE,) * len(self._bones.rest)
        self._armature = scene.new_armature(self._bones.rest)
        for chosen in (self._object, self._armature):
            chosen.select_set(True)
        bpy.context.view_layer.objects.active = self._armature
        bpy.ops.object.parent_set(type="ARMATURE_AUTO")
        self._object.modifiers[0].use_deform_preserve_volume = keeps_volume
        if not any(len(vertex.groups) for vertex in self._object.data.vertices):
            raise NotRun("Bone Heat Weighting finds no weights")

    def pose(self, step: int) -> None:
        for k, bone in enumerate(self._armature.pose.bones):
            moved, rest = np.eye(4), np.array(bone.bone.matrix_local)
            moved[:3, :3] = self._bones.rotations[step, k]
            moved[:3, 3] = self._bones.moved(step, k, np.zeros((1, 3)))[0]
            bone.matrix_basis = Matrix((np.linalg.inv(rest) @ moved @ rest).tolist())
        self._now = scene.evaluated(self._object)


def coarse_copy(task: PosedTask) -> Carrier:
    """The mesh in even quads, as Blender's Remesh makes it."""
    scene.clear()
    whole = scene.new_mesh("Whole", *arrays(task))
    remesh = whole.modifiers.new("Remesh", "REMESH")
    remesh.mode, remesh.voxel_size = "VOXEL", VOXEL * diagonal(task)
    positions, corner_vertices, face_sizes = scene.arrays(whole)
    if len(face_sizes) == 0:
        raise NotRun("Remesh makes no faces of the mesh")
    return Carrier(task, positions, corner_vertices, face_sizes)


MODELS: dict[str, Make] = {
    "Blender: Laplacian Deform": LaplacianDeform,
    "Blender: Mesh Deform": MeshDeform,
    "Blender: Surface Deform": SurfaceDeform,
    "Blender: Armature": lambda task: Armature(task, keeps_volume=False),
    "Blender: Armature, Preserve Volume": lambda task: Armature(task, keeps_volume=True),
}
INPUTS = {
    "Blender: Laplacian Deform": "Held and moved vertices are its anchors, moved as by hooks; Repeat is 10.",
    "Blender: Mesh Deform": "The cage of the cage models, moved as theirs, with the modifier's own harmonic weights.",
    "Blender: Surface Deform": "A copy in quads by Remesh at 3 % of the diagonal, posed by surface ARAP of this "
    "library: the modifier carries a shape, it makes none.",
    "Blender: Armature": "Automatic weights of the task's bones; where it has none, of a bone along each piece of what "
    "is held and of what is moved.",
    "Blender: Armature, Preserve Volume": "The same bones and weights, blended as dual quaternions.",
}
