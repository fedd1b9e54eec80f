# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that the window tests pose: a bar with a pinned and a held end."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

N_RINGS = 13
LENGTH = 4.0


def add_bar() -> bpy.types.Object:
    """An upright square bar of quads, closed, one unit wide, in place of the default cube; active and selected."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    heights = np.linspace(0.0, LENGTH, N_RINGS)
    vertices = [(x, y, float(z)) for z in heights for x, y in corners]
    sides = [
        (4 * ring + i, 4 * ring + (i + 1) % 4, 4 * ring + 4 + (i + 1) % 4, 4 * ring + 4 + i)
        for ring in range(N_RINGS - 1)
        for i in range(4)
    ]
    last = 4 * (N_RINGS - 1)
    mesh = bpy.data.meshes.new("Bar")
    mesh.from_pydata(vertices, [], [(3, 2, 1, 0), *sides, (last, last + 1, last + 2, last + 3)])
    bar = bpy.data.objects.new("Bar", mesh)
    bpy.context.scene.collection.objects.link(bar)
    bar.select_set(True)
    bpy.context.view_layer.objects.active = bar
    return bar


def add_grid(n: int) -> bpy.types.Object:
    """A flat grid of n x n vertices, two units wide, in place of the default cube."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=n - 1, y_subdivisions=n - 1)
    grid = bpy.context.object
    grid.name = "Grid"
    return grid


def add_held_grid(api: Any, n: int = 20) -> bpy.types.Object:
    """A grid whose first edge is pinned and whose opposite edge hangs on a handle."""
    grid = add_grid(n)
    hold(api, grid, n)
    return grid


def hold(api: Any, grid: bpy.types.Object, n: int) -> None:
    """Pins an edge of a grid of n x n vertices and gives the opposite one a handle."""
    api.add_pin(grid, list(range(n)), name="Edge")
    api.add_handle(grid, list(range(n * n - n, n * n)), name="Other Edge")


def add_bone() -> bpy.types.Object:
    """An armature of one bone that begins in the middle of the bar's top."""
    armature = bpy.data.objects.new("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("Bone")
    bone.head, bone.tail = (0.0, 0.0, LENGTH), (0.0, 0.0, LENGTH + 1.0)
    bone.select = bone.select_head = bone.select_tail = True
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def bottom() -> list[int]:
    return list(range(8))


def top() -> list[int]:
    return list(range(4 * (N_RINGS - 2), 4 * N_RINGS))


def add_bar_with_handle(api: Any) -> bpy.types.Object:
    """The bar, its bottom pinned and its top on a handle named Top."""
    bar = add_bar()
    api.add_pin(bar, bottom(), name="Bottom")
    api.add_handle(bar, top(), name="Top")
    return bar


def key_positions(obj: bpy.types.Object, name: str = "ARAP") -> np.ndarray:
    """(n, 3) of a shape key; of the mesh where there are no keys."""
    keys = obj.data.shape_keys
    data = keys.key_blocks[name].data if keys else obj.data.vertices
    positions = np.empty(3 * len(data), dtype=np.float32)
    data.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def shown_positions(obj: bpy.types.Object) -> np.ndarray:
    """(n, 3) as evaluated, object space."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", positions)
    evaluated.to_mesh_clear()
    return positions.reshape(-1, 3)


def rest_of(obj: bpy.types.Object) -> bytes:
    """Its rest shape, to be compared."""
    keys = obj.data.shape_keys
    return key_positions(obj, keys.reference_key.name if keys else "").tobytes()
