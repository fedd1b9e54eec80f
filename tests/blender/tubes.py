# SPDX-License-Identifier: GPL-3.0-or-later
"""The tube that the tests pose, and what they do to it."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector
from support import module

# Of an object that stands somewhere, turned and stretched.
PLACED = Matrix.Translation((3.0, -2.0, 1.0)) @ Matrix.Rotation(0.7, 4, "Y") @ Matrix.Diagonal((1.0, 2.0, 0.5, 1.0))
RINGS, SEGMENTS, LENGTH = 17, 8, 4.0


def tube_arrays() -> tuple[np.ndarray, list[list[int]]]:
    """A closed tube along z from 0 to LENGTH, of quads, with a polygon at each end."""
    angle = np.arange(SEGMENTS) * (2.0 * np.pi / SEGMENTS)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(SEGMENTS)]) * 0.5
    height = np.linspace(0.0, LENGTH, RINGS)
    positions = (ring[None] + height[:, None, None] * np.array([0.0, 0.0, 1.0])).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(RINGS - 1), np.arange(SEGMENTS), indexing="ij")
    right = (j + 1) % SEGMENTS
    quads = np.stack([i, i, i + 1, i + 1], -1) * SEGMENTS + np.stack([j, right, right, j], -1)
    caps = [list(range(SEGMENTS))[::-1], list(range((RINGS - 1) * SEGMENTS, RINGS * SEGMENTS))]
    return positions, [*quads.reshape(-1, 4).tolist(), *caps]


BOTTOM = list(range(SEGMENTS))
TOP = list(range((RINGS - 1) * SEGMENTS, RINGS * SEGMENTS))
BALL = 42  # vertices of a ball
MIDDLE = list(range(8 * SEGMENTS, 9 * SEGMENTS))


def mesh_object(name: str = "Tube", matrix: Matrix | None = None) -> bpy.types.Object:
    """The tube as a new object in the scene."""
    positions, faces = tube_arrays()
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(positions.tolist(), [], faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    if matrix is not None:
        obj.matrix_world = matrix
    bpy.context.view_layer.update()
    return obj


def posable(name: str = "Tube", matrix: Matrix | None = None) -> bpy.types.Object:
    """The tube with its bottom pinned and a handle at its top; solved tightly."""
    api = module("api")
    obj = mesh_object(name, matrix)
    api.add_pin(obj, BOTTOM, name="Feet")
    api.add_handle(obj, TOP, name="Head")
    obj.arap.accuracy = 1e-7
    obj.arap.max_iterations = 5000
    return obj


def with_balls(*centres: tuple[float, float, float], matrix: Matrix | None = None) -> bpy.types.Object:
    """posable(), with balls in its mesh behind the tube's vertices, BALL vertices each."""
    obj = posable(matrix=matrix)
    mesh = bmesh.new()
    mesh.from_mesh(obj.data)
    for centre in centres:
        bmesh.ops.create_icosphere(mesh, subdivisions=2, radius=0.2, matrix=Matrix.Translation(centre))
    mesh.to_mesh(obj.data)
    mesh.free()
    bpy.context.view_layer.update()
    return obj


def empty_at(location, name: str = "Empty") -> bpy.types.Object:
    empty = bpy.data.objects.new(name, None)
    bpy.context.scene.collection.objects.link(empty)
    empty.location = location
    bpy.context.view_layer.update()
    return empty


def move(target: bpy.types.Object, shift=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0)) -> None:
    """Moves an object in the world, and turns it about its own origin."""
    matrix = target.matrix_world.copy()
    place = matrix.to_translation()
    matrix.translation = (0.0, 0.0, 0.0)
    target.matrix_world = Matrix.Translation(place + Vector(shift)) @ Euler(turn).to_matrix().to_4x4() @ matrix
    bpy.context.view_layer.update()


def bend(obj: bpy.types.Object) -> None:
    """A large move and turn of the first handle."""
    move(obj.arap.handles[0].target, (0.0, 1.0, -0.6), (-0.9, 0.0, 0.2))


def following_tube(name: str = "Tube") -> bpy.types.Object:
    """posable(), which follows."""
    obj = posable(name)
    obj.arap.use_follow = True
    bpy.context.view_layer.update()
    return obj


def solved(name: str = "Tube", matrix: Matrix | None = None) -> bpy.types.Object:
    """posable(), bent and solved."""
    obj = posable(name, matrix)
    bend(obj)
    module("api").solve(obj)
    return obj


def armature(matrix: Matrix | None = None) -> bpy.types.Object:
    """An active armature with two bones upwards, Lower to z = 2 and its child Upper to z = 4."""
    data = bpy.data.armatures.new("Rig")
    rig = bpy.data.objects.new("Rig", data)
    bpy.context.scene.collection.objects.link(rig)
    rig.matrix_world = matrix or Matrix()
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    lower, upper = data.edit_bones.new("Lower"), data.edit_bones.new("Upper")
    lower.tail = upper.head = (0.0, 0.0, 2.0)
    upper.tail, upper.parent = (0.0, 0.0, 4.0), lower
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    return rig


def copied(obj: bpy.types.Object) -> bpy.types.Object:
    """A copy of the object with a mesh of its own, in the scene."""
    copy = obj.copy()
    copy.data = obj.data.copy()
    bpy.context.scene.collection.objects.link(copy)
    bpy.context.view_layer.update()
    return copy


def select_in_edit_mode(obj: bpy.types.Object, vertices: list[int]) -> None:
    """Selects these vertices alone, and leaves the mesh in Edit Mode."""
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="OBJECT")
    module("scene.meshes").select_vertices(obj, np.asarray(vertices, dtype=np.int32), shows_hidden=True)
    bpy.ops.object.mode_set(mode="EDIT")


def own_key(obj: bpy.types.Object, name: str, shift: float = 0.25, value: float = 1.0) -> bpy.types.ShapeKey:
    """A key of the artist's own, shifted along x; with Basis if there are no keys."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name=name)
    for point in key.data:
        point.co.x += shift
    key.value = value
    return key


def animate(obj: bpy.types.Object) -> None:
    """Its handle moves, turns and comes half way back from frame 1 to 21, with Blender's own easing."""
    target = obj.arap.handles[0].target
    for frame, y, turn in ((1, 0.0, 0.0), (11, 1.5, -1.2), (21, 0.6, -0.3)):
        target.location.y, target.rotation_euler.x = y, turn
        target.keyframe_insert("location", frame=frame)
        target.keyframe_insert("rotation_euler", frame=frame)


def animated(matrix: Matrix | None = None) -> bpy.types.Object:
    """posable() and animate(), solved less tightly."""
    obj = posable(matrix=matrix)
    animate(obj)
    obj.arap.accuracy = 1e-4
    obj.arap.max_iterations = 200
    return obj
