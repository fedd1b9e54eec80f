# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's modifiers, with Blender as a module of Python. Times are those of its evaluation of the whole scene."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix
from measure.base.contender import BONE, HANDLE, PIN, Floats, Ints, Make, PosedTask
from measure.base.workers import NotRun

from .bones import bones_of
from .driven_cage import ACTS as CAGE_ACTS
from .driven_cage import DrivenCage


REPEAT = 10  # of Laplacian Deform, iterations


class Modified:
    """A mesh in an empty scene, with a modifier."""

    version = bpy.app.version_string
    acts: Sequence[str] = ()

    def __init__(self, task: PosedTask) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._task, self._now = task, task.positions
        self._object = new_object("Mesh", task.positions, task.corner_vertices, task.face_sizes)

    def positions(self) -> Floats:
        return self._now

    def _evaluate(self) -> None:
        graph = bpy.context.evaluated_depsgraph_get()
        vertices = self._object.evaluated_get(graph).data.vertices
        if len(vertices) != len(self._task.positions):
            raise RuntimeError(f"Blender gives {len(vertices)} vertices for {len(self._task.positions)}")
        found = np.empty(3 * len(vertices), dtype=np.float32)
        vertices.foreach_get("co", found)
        self._now = found.reshape(-1, 3).astype(np.float64)


class LaplacianDeform(Modified):
    acts = (PIN, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        super().__init__(task)
        anchors = self._object.vertex_groups.new(name="Anchors")
        anchors.add(task.constrained.tolist(), 1.0, "REPLACE")
        modifier = self._object.modifiers.new("Laplacian Deform", "LAPLACIANDEFORM")
        modifier.vertex_group, modifier.iterations = anchors.name, REPEAT
        bind(self._object, "laplaciandeform_bind", modifier.name)
        if not modifier.is_bind:
            raise NotRun("Laplacian Deform does not bind")

    def pose(self, step: int) -> None:
        places = self._task.positions.copy()
        places[self._task.constrained] = self._task.targets[step]
        move_vertices(self._object, places)
        self._evaluate()


class ByCage(Modified):
    """A modifier that a cage moves."""

    acts = CAGE_ACTS

    def __init__(self, task: PosedTask, kind: str, operator: str) -> None:
        super().__init__(task)
        self._cage = DrivenCage(task)
        cage = new_object("Cage", self._cage.rest, self._cage.corner_vertices, self._cage.face_sizes)
        modifier = self._object.modifiers.new(kind, kind)
        setattr(modifier, "target" if kind == "SURFACE_DEFORM" else "object", cage)
        bind(self._object, operator, modifier.name)
        if not modifier.is_bound:
            raise NotRun("the modifier does not bind to the cage")
        self._cage_object = cage

    def pose(self, step: int) -> None:
        move_vertices(self._cage_object, self._cage.pose(step))
        self._evaluate()


class Armature(Modified):
    def __init__(self, task: PosedTask, keeps_volume: bool) -> None:
        super().__init__(task)
        self._bones = task.bones or bones_of(task)
        self.acts = (BONE,) * len(self._bones.rest)
        self._armature = new_armature(self._bones.rest)
        bpy.context.view_layer.objects.active = self._armature
        for chosen in (self._object, self._armature):
            chosen.select_set(True)
        bpy.ops.object.parent_set(type="ARMATURE_AUTO")
        modifier = self._object.modifiers[0]
        modifier.use_deform_preserve_volume = keeps_volume
        if not any(len(vertex.groups) for vertex in self._object.data.vertices):
            raise NotRun("Blender finds no automatic weights: Bone Heat Weighting failed")

    def pose(self, step: int) -> None:
        for k, bone in enumerate(self._armature.pose.bones):
            turn, rest = np.eye(4), np.array(bone.bone.matrix_local)
            turn[:3, :3] = self._bones.rotations[step, k]
            turn[:3, 3] = self._bones.moved(step, k, np.zeros((1, 3)))[0]
            bone.matrix_basis = Matrix((np.linalg.inv(rest) @ turn @ rest).tolist())
        self._evaluate()


def new_object(name: str, positions: Floats, corner_vertices: Ints, face_sizes: Ints) -> bpy.types.Object:
    """A mesh object in the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.astype(np.float32).ravel())
    mesh.loops.add(len(corner_vertices))
    mesh.loops.foreach_set("vertex_index", corner_vertices)
    mesh.polygons.add(len(face_sizes))
    mesh.polygons.foreach_set("loop_start", np.cumsum(face_sizes) - face_sizes)
    mesh.update(calc_edges=True)
    mesh.validate()
    return linked(name, mesh)


def new_armature(bones: Floats) -> bpy.types.Object:
    """With bones (b, 2, 3) that have no parents, in this order."""
    armature = linked("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for k, (head, tail) in enumerate(bones):
        bone = armature.data.edit_bones.new(f"Bone {k:04d}")
        bone.head, bone.tail = head, tail
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def linked(name: str, data: bpy.types.ID) -> bpy.types.Object:
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def bind(modified: bpy.types.Object, operator: str, modifier: str) -> None:
    bpy.context.view_layer.objects.active = modified
    bpy.context.view_layer.update()
    getattr(bpy.ops.object, operator)(modifier=modifier)


def move_vertices(moved: bpy.types.Object, places: Floats) -> None:
    moved.data.vertices.foreach_set("co", places.astype(np.float32).ravel())
    moved.data.update()


MODELS: dict[str, Make] = {
    "Blender: Laplacian Deform": LaplacianDeform,
    "Blender: Mesh Deform": lambda task: ByCage(task, "MESH_DEFORM", "meshdeform_bind"),
    "Blender: Surface Deform": lambda task: ByCage(task, "SURFACE_DEFORM", "surfacedeform_bind"),
    "Blender: Armature": lambda task: Armature(task, keeps_volume=False),
    "Blender: Armature, Preserve Volume": lambda task: Armature(task, keeps_volume=True),
}
