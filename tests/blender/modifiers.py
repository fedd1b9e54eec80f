# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers of the meshes that the tests pose."""

from __future__ import annotations

import bpy


def add_nodes(obj, *, takes_places: bool, name: str = "Nodes") -> bpy.types.Modifier:
    """Geometry Nodes that set the place of each vertex: to another one, or to its own."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    place = tree.nodes.new("GeometryNodeSetPosition")
    tree.links.new(start.outputs[0], place.inputs["Geometry"])
    tree.links.new(place.outputs[0], end.inputs[0])
    if takes_places:
        combined = tree.nodes.new("ShaderNodeCombineXYZ")
        tree.links.new(tree.nodes.new("GeometryNodeInputIndex").outputs[0], combined.inputs[0])
        tree.links.new(combined.outputs[0], place.inputs["Position"])
    modifier = obj.modifiers.new(name, "NODES")
    modifier.node_group = tree
    bpy.context.view_layer.update()
    return modifier
