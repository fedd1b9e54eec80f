# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways to look at the result, read the plain way."""

from __future__ import annotations

import bpy
import numpy as np
from support import module


def group_of(obj: bpy.types.Object, name: str) -> dict[int, float]:
    """Weights of a vertex group by vertex."""
    index = obj.vertex_groups[name].index
    return {v.index: g.weight for v in obj.data.vertices for g in v.groups if g.group == index}


def key_names(obj: bpy.types.Object) -> list[str]:
    return [key.name for key in obj.data.shape_keys.key_blocks] if obj.data.shape_keys else []


def key_positions(obj: bpy.types.Object, name: str = "ARAP") -> np.ndarray:
    """(n, 3) values of a key, read the plain way."""
    return np.array([point.co[:] for point in obj.data.shape_keys.key_blocks[name].data])


def unfit(obj: bpy.types.Object, *, is_thorough: bool = False) -> str:
    """Why the live session does not fit the scene, '' if it does."""
    frame, bound = module("engine.frame"), module("core.sessions").get(obj.session_uid)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    problem = frame.look(obj, depsgraph, bound)[1]
    return problem or (frame.look_closely(obj, depsgraph, bound) if is_thorough else "")


def rest_positions(obj: bpy.types.Object) -> np.ndarray:
    keys = obj.data.shape_keys
    points = keys.reference_key.data if keys else obj.data.vertices
    return np.array([point.co[:] for point in points])


def shown_positions(obj: bpy.types.Object) -> np.ndarray:
    """(n, 3) evaluated positions, object space: all keys and modifiers."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([vertex.co[:] for vertex in evaluated.data.vertices])


def in_world(obj: bpy.types.Object, positions: np.ndarray) -> np.ndarray:
    matrix = np.array(obj.matrix_world)
    return positions @ matrix[:3, :3].T + matrix[:3, 3]


def edge_lengths(obj: bpy.types.Object, positions: np.ndarray) -> np.ndarray:
    """Lengths of the mesh's edges in the world."""
    ends = np.array([edge.vertices[:] for edge in obj.data.edges])
    world = in_world(obj, positions)
    return np.linalg.norm(world[ends[:, 0]] - world[ends[:, 1]], axis=1)


def data_of(obj):
    """Everything a cancelled bake must not have changed."""
    keys = obj.data.shape_keys
    blocks = [(key.name, key.value, key.mute) for key in keys.key_blocks] if keys else []
    positions = [key_positions(obj, name).tolist() for name, _, _ in blocks]
    action = keys.animation_data.action if keys and keys.animation_data else None
    return blocks, positions, action, bpy.context.scene.frame_current
