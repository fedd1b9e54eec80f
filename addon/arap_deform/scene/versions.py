# SPDX-License-Identifier: GPL-3.0-or-later
"""Bulk access to the data of Blender, and the differences between 4.2 and 5.2 (of animation: fcurves)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Float32s
from .registration import quiet

# Below this many vertices for each tree a plain pass over the vertices' groups is faster than the node trees.
NODES_PAY_FROM = 10_000
MOST_IN_TREE = 16  # groups: to set up a tree takes time quadratic in its nodes
# 4.5: points have a shader of their own, which not every graphics API can do without.
POINT_SHADER = "POINT_UNIFORM_COLOR" if bpy.app.version >= (4, 5, 0) else "UNIFORM_COLOR"


def fields_of(points: Any) -> tuple[str, ...]:
    """Which coordinates the points of a spline or a shape key have. All have those of the first."""
    has_handles = len(points) > 0 and hasattr(points[0], "handle_left")
    return ("co", "handle_left", "handle_right") if has_handles else ("co",)


def read_key(key: bpy.types.ShapeKey) -> Float32s:
    """(n, 3) float32 coordinates of a shape key. Of a curve see points/curves."""
    points = _key_points(key)
    fields = fields_of(points)
    result = np.empty((len(fields), len(points), 3), dtype=np.float32)
    for values, field in zip(result, fields, strict=True):
        points.foreach_get(field, values.ravel())
    return result.reshape(-1, 3)


def read_key_at(key: bpy.types.ShapeKey, rows: Sequence[int]) -> Float32s:
    """(k, 3) float32 coordinates of some points: quicker than read_key(), if they are few."""
    points = key.data
    fields, n = fields_of(points), len(points)
    chosen = [getattr(points[row % n], fields[row // n]) for row in rows]
    return np.array(chosen, dtype=np.float32).reshape(-1, 3)


def key_size(key: bpy.types.ShapeKey) -> int:
    """How many rows read_key() has."""
    points = _key_points(key)
    return len(points) * len(fields_of(points))


def write_key(key: bpy.types.ShapeKey, positions: Float32s) -> None:
    """Writes (n, 3) contiguous float32 coordinates; the caller tags the mesh or curve."""
    points = _key_points(key)
    fields = fields_of(points)
    for values, field in zip(positions.reshape(len(fields), -1), fields, strict=True):
        points.foreach_set(field, values)


def _key_points(key: bpy.types.ShapeKey) -> Any:
    # key.points is empty if the key is of a curve. key.data goes through one wrapper for each point, 200 times slower.
    return key.points if len(key.points) else key.data


def read_positions(mesh: bpy.types.Mesh) -> Float32s:
    """(n, 3) float32 coordinates of the mesh itself, without shape keys."""
    result = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    items, field = _source(mesh, "position", "vector", mesh.vertices, "co")
    items.foreach_get(field, result.ravel())
    return result


def write_positions(mesh: bpy.types.Mesh, positions: Float32s) -> None:
    """Writes (n, 3) contiguous float32 coordinates to the mesh itself; the caller tags the mesh."""
    items, field = _source(mesh, "position", "vector", mesh.vertices, "co")
    items.foreach_set(field, positions.ravel())


def new_mesh(name: str, positions: Float32s, triangles: NDArray[np.int32]) -> bpy.types.Mesh:
    """A mesh of (n, 3) contiguous positions and (t, 3) triangles."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.loops.add(triangles.size)
    mesh.polygons.add(len(triangles))
    write_positions(mesh, positions)
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    return mesh


def read_corner_vertices(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    """(c,) int32 vertex of each face corner."""
    result = np.empty(len(mesh.loops), dtype=np.int32)
    items, field = _source(mesh, ".corner_vert", "value", mesh.loops, "vertex_index")
    items.foreach_get(field, result)
    return result


def read_edges(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    """(e, 2) int32 vertices of each edge."""
    result = np.empty((len(mesh.edges), 2), dtype=np.int32)
    items, field = _source(mesh, ".edge_verts", "value", mesh.edges, "vertices")
    items.foreach_get(field, result.ravel())
    return result


def _source(mesh: bpy.types.Mesh, attribute: str, value: str, items: Any, field: str) -> tuple[Any, str]:
    """An attribute and its field, or the slow way, through wrappers: a mesh in Edit Mode has no attributes."""
    found = mesh.attributes.get(attribute)
    return (items, field) if found is None else (found.data, value)


def read_group_weights(
    obj: bpy.types.Object, names: Sequence[str], use_nodes: bool | None = None
) -> dict[str, Float32s]:
    """(n,) float32 weight of every vertex in each of the groups; 0 if it is not in the group.

    Args:
        obj: a mesh object in Object Mode that has these groups.
        names: the groups.
        use_nodes: whether geometry nodes read them; None: the faster way. Both give the same.
    """
    if not names:
        return {}
    if use_nodes is None:
        n_trees = -(-len(names) // MOST_IN_TREE)
        use_nodes = len(obj.data.vertices) >= n_trees * NODES_PAY_FROM
    if not use_nodes:
        return _weights_by_pass(obj, names)
    result: dict[str, Float32s] = {}
    for start in range(0, len(names), MOST_IN_TREE):
        result.update(_weights_by_nodes(obj, names[start : start + MOST_IN_TREE]))
    return result


def _weights_by_pass(obj: bpy.types.Object, names: Sequence[str]) -> dict[str, Float32s]:
    """One pass over every vertex's groups: 30-110 ms for 100,000 vertices, most of it for vertices in no group."""
    entries = [(v.index, g.group, g.weight) for v in obj.data.vertices for g in v.groups]
    table = np.array(entries, dtype=np.float64).reshape(-1, 3)
    result: dict[str, Float32s] = {}
    for name in names:
        mine = table[table[:, 1] == obj.vertex_groups[name].index]
        weights = np.zeros(len(obj.data.vertices), dtype=np.float32)
        weights[mine[:, 0].astype(np.int64)] = mine[:, 2]
        result[name] = weights
    return result


def _weights_by_nodes(obj: bpy.types.Object, names: Sequence[str]) -> dict[str, Float32s]:
    """Geometry nodes copy the groups to attributes, which are read in bulk: 4 ms for 100,000 vertices.

    The nodes are on a second object with the same mesh, in a scene of its own. So nothing of the file is evaluated or
    changes.
    """
    tree = _group_reader([(name, f"arap_{i}") for i, name in enumerate(names)])
    reader = bpy.data.objects.new("arap_reader", obj.data)
    reader.show_only_shape_key = True  # the shape does not matter, and the first key alone is the least work
    reader.modifiers.new("groups", "NODES").node_group = tree
    try:
        with _evaluated_alone(reader) as mesh:
            result: dict[str, Float32s] = {}
            for i, name in enumerate(names):
                weights = np.empty(len(obj.data.vertices), dtype=np.float32)
                mesh.attributes[f"arap_{i}"].data.foreach_get("value", weights)
                result[name] = weights
            return result
    finally:
        bpy.data.node_groups.remove(tree)


def read_shape_of_keys(obj: bpy.types.Object) -> Float32s:
    """(n, 3) float32 the mesh with all its shape keys as they are shown, without modifiers."""
    reader = bpy.data.objects.new("arap_reader", obj.data)
    reader.show_only_shape_key = obj.show_only_shape_key
    reader.active_shape_key_index = obj.active_shape_key_index
    with _evaluated_alone(reader) as mesh:
        return read_positions(mesh)


@contextmanager
def _evaluated_alone(reader: bpy.types.Object) -> Iterator[bpy.types.Mesh]:
    """The evaluated mesh of an object that goes at the end, in a scene of its own: nothing else is evaluated."""
    scene = bpy.data.scenes.new("arap_reader")
    try:
        scene.collection.objects.link(reader)
        view_layer = scene.view_layers[0]
        with quiet():
            view_layer.update()
        yield reader.evaluated_get(view_layer.depsgraph).data
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(reader)


def _group_reader(names: Sequence[tuple[str, str]]) -> bpy.types.NodeTree:
    """A node group that stores each vertex group as a float attribute: (group, attribute) names."""
    tree = bpy.data.node_groups.new("arap_reader", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    geometry = tree.nodes.new("NodeGroupInput").outputs[0]
    for group, attribute in names:
        read = tree.nodes.new("GeometryNodeInputNamedAttribute")
        read.data_type = "FLOAT"
        read.inputs[0].default_value = group
        store = tree.nodes.new("GeometryNodeStoreNamedAttribute")
        store.data_type = "FLOAT"
        store.domain = "POINT"
        store.inputs["Name"].default_value = attribute
        tree.links.new(read.outputs["Attribute"], store.inputs["Value"])
        tree.links.new(geometry, store.inputs[0])
        geometry = store.outputs[0]
    tree.links.new(geometry, tree.nodes.new("NodeGroupOutput").inputs[0])
    return tree


def node_attributes(modifier: bpy.types.NodesModifier) -> list[str]:
    """Names of attributes, which may be vertex groups, in the fields of a Geometry Nodes modifier."""
    if hasattr(modifier, "properties"):  # 5.2
        if modifier.node_group is None:
            return []
        inputs = modifier.properties.inputs
        fields = (getattr(inputs, field.identifier) for field in inputs.bl_rna.properties)
        return [getattr(field, "attribute_name", "") for field in fields]
    return [str(value) for key, value in modifier.items() if key.endswith("_attribute_name")]


def is_painting() -> bool:
    """Whether a stroke of a brush is under way in some window."""
    operators = (operator for window in bpy.context.window_manager.windows for operator in window.modal_operators)
    return any(operator.bl_idname.startswith("PAINT_OT") for operator in operators)


def select_bone(armature: bpy.types.Object, name: str) -> None:
    """Selects one bone alone in Pose Mode, and makes it active."""
    for bone in armature.pose.bones:
        holder = bone if hasattr(bone, "select") else bone.bone  # of the pose since 5.0
        holder.select = bone.name == name
    armature.data.bones.active = armature.data.bones[name]


def length_text(scene: bpy.types.Scene, length: float) -> str:
    """A length in scene units as Blender's own fields show it."""
    units = scene.unit_settings
    return str(bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length, precision=3))
