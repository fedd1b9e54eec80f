# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh objects to arrays, and where curves are. Nothing in Blender is changed, except what is selected and hidden."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.mirror import Mirror, used_mirrors
from ..core.session_data import SessionMesh
from ..core.transforms import inverted, stretch_of
from . import versions
from .points import objects as points


def check_mesh(obj: bpy.types.Object) -> None:
    """Raises ValueError with why_not_posable()."""
    if reason := why_not_posable(obj):
        raise ValueError(reason)


def why_not_posable(obj: bpy.types.Object | None) -> str:
    """Why an object has no mesh that can be posed, and what to do; '' if it has."""
    if obj is None or obj.type != "MESH":
        return f"'{obj.name if obj else 'Nothing'}' is not a mesh: choose a mesh object"
    if obj.data.is_editmode or obj.mode in {"EDIT", "SCULPT"}:
        mode = "Sculpt Mode" if obj.mode == "SCULPT" else "Edit Mode"
        return f"'{obj.name}' is in {mode}: go back to Object Mode first"
    return "" if len(obj.data.polygons) else f"'{obj.name}' has no faces: there is nothing to deform"


def check_local(obj: bpy.types.Object) -> None:
    """Raises ValueError if Blender would not save what is written to the object or its mesh or curve."""
    data = obj.data
    if obj.library is not None or data.library is not None:
        whose = f"'{obj.name}'" if obj.library is not None else f"The {obj.type.lower()} of '{obj.name}'"
        raise ValueError(f"{whose} is linked from another file: make it local (Object > Relations > Make Local)")
    if obj.override_library is not None or data.override_library is not None:  # see is_override()
        raise ValueError(
            f"'{obj.name}' is a library override, in which a pose is not saved: make it local "
            "(Object > Relations > Make Local)"
        )


def is_override(data: bpy.types.ID) -> bool:
    """Whether it is a library override. What Blender does not save of an override is lost with the next load."""
    return data.override_library is not None


def read_rest(obj: bpy.types.Object) -> NDArray[np.float32]:
    """(n, 3) float32 rest positions, object space: the reference key, or the mesh or curve if there are no keys."""
    keys = obj.data.shape_keys
    # mesh.vertices is not kept in step with the reference key.
    return versions.read_key(keys.reference_key) if keys else points.read_positions(obj.data)


def read_rest_at(obj: bpy.types.Object, rows: Sequence[int]) -> NDArray[np.float32]:
    """(k, 3) float32 some rows of read_rest(), quicker."""
    keys = obj.data.shape_keys
    return versions.read_key_at(keys.reference_key, rows) if keys else points.read_positions_at(obj.data, rows)


def read_mesh(obj: bpy.types.Object) -> SessionMesh:
    """The mesh at rest. Call check_mesh() before."""
    return SessionMesh(read_rest(obj).astype(np.float64), *read_faces(obj.data))


def read_faces(mesh: bpy.types.Mesh) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """(c,) int32 vertices of all faces, one face after the other, and (f,) int32 sizes of these."""
    sizes = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", sizes)
    return versions.read_corner_vertices(mesh), sizes


def read_weights(
    obj: bpy.types.Object, names: Sequence[str], *, use_nodes: bool | None = None
) -> dict[str, NDArray[np.float64]]:
    """(n,) float64 weights of each of the groups, which must exist. See versions.read_group_weights()."""
    weights = versions.read_group_weights(obj, names, use_nodes)
    return {name: values.astype(np.float64) for name, values in weights.items()}


def groups_at(obj: bpy.types.Object, vertices: NDArray[np.integer]) -> set[str]:
    """Names of the groups that these vertices have weight in. Quick if they are few."""
    every = obj.data.vertices
    found = {group.group for vertex in vertices.tolist() for group in every[vertex].groups if group.weight > 0.0}
    return {group.name for group in obj.vertex_groups if group.index in found}


def read_matrix(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> NDArray[np.float64]:
    """(4, 4) float64 evaluated world matrix: parents, constraints, drivers and animation count."""
    # The original's matrix_world is a step behind, and zero after an undo until it is evaluated.
    return np.array(obj.evaluated_get(depsgraph).matrix_world, dtype=np.float64)


def drawn_depsgraph(context: bpy.types.Context) -> bpy.types.Depsgraph:
    """As last evaluated, for what draws: an evaluation would call handlers, and these must not write then."""
    return context.view_layer.depsgraph or context.evaluated_depsgraph_get()  # there is none before the first


def depsgraph_with(obj: bpy.types.Object) -> bpy.types.Depsgraph:
    """One in which the object is where it is now. As last evaluated, if the object's own fields say that it is there.

    For what adds many objects, one by one: after each new one an evaluation begins with the graph of all objects.
    """
    depsgraph = bpy.context.view_layer.depsgraph
    world = _plain_matrix(obj) if depsgraph is not None else None
    if world is not None and np.allclose(read_matrix(obj, depsgraph), world, rtol=1e-6, atol=0.0):
        return depsgraph
    return bpy.context.evaluated_depsgraph_get()


def _plain_matrix(obj: bpy.types.Object) -> NDArray[np.float64] | None:
    """(4, 4) world matrix by its location, rotation, scale and parents; None if more may move it."""
    more = obj.constraints, obj.animation_data, obj.rigid_body, obj.parent and obj.parent_type != "OBJECT"
    if any(more) or (obj.type == "CURVE" and obj.data.use_path) or any(m.type == "MIRROR" for m in obj.modifiers):
        return None
    own = np.array(obj.matrix_basis, dtype=np.float64)
    if obj.parent is None:
        return own
    above = _plain_matrix(obj.parent)
    return None if above is None else above @ np.array(obj.matrix_parent_inverse, dtype=np.float64) @ own


def is_evaluated(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether Blender keeps the evaluated object up to date: if it is hidden by the eye, but not if it is disabled."""
    view_layer = depsgraph.view_layer
    if obj.visible_get(view_layer=view_layer):
        return True
    if obj.hide_viewport or view_layer.objects.get(obj.name) != obj:
        return False
    enabled = set(enabled_collections(view_layer.layer_collection))
    return any(collection in enabled for collection in obj.users_collection)


def why_not_evaluated(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> str:
    """What to do about a mesh that is not is_evaluated(), '' if it is."""
    if is_evaluated(obj, depsgraph):
        return ""
    return f"'{obj.name}' is disabled in viewports or excluded from the view layer: enable it, or hide it with the eye"


def enabled_collections(layer: bpy.types.LayerCollection) -> Iterator[bpy.types.Collection]:
    """The collections below ``layer``, and itself, whose objects Blender evaluates in its view layer."""
    if not layer.exclude and not layer.collection.hide_viewport:
        yield layer.collection
        for child in layer.children:
            yield from enabled_collections(child)


def is_switched_on(modifier: bpy.types.Modifier) -> bool:
    """Whether it counts in viewports or in renders: an artist often has one off in viewports, where it is slow."""
    return bool(modifier.show_viewport or modifier.show_render)


def read_stretch(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> NDArray[np.float64]:
    """(3, 3) float64 stretch of the object's world matrix. Raises ValueError if it is singular."""
    return stretch_in(obj, read_matrix(obj, depsgraph))


def stretch_in(obj: bpy.types.Object, world: NDArray[np.float64]) -> NDArray[np.float64]:
    """As read_stretch(), for a (4, 4) world matrix that is known."""
    try:
        return stretch_of(world)
    except ValueError as error:
        raise ValueError(f"'{obj.name}' {error}") from None


def read_mirrors(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    stretch: NDArray[np.float64],
    rest: NDArray[np.floating] | None = None,
) -> tuple[Mirror, ...]:
    """The planes of the Mirror modifier that complete the mesh. ``rest``: (n, 3), or None to read it if need be."""
    mirrors = _read_planes(obj, depsgraph)
    return used_mirrors(mirrors, read_rest(obj) if rest is None else rest, stretch) if mirrors else ()


def begins_mirrored(obj: bpy.types.Object) -> bool:
    """Whether the Mirror of read_mirrors() is the first modifier, and on in viewports and in renders."""
    modifier = _mirror_of(obj)
    return modifier is not None and modifier == obj.modifiers[0] and modifier.show_viewport and modifier.show_render


def _mirror_of(obj: bpy.types.Object) -> bpy.types.MirrorModifier | None:
    """The first Mirror modifier that is on, if it merges the halves or clips them."""
    modifier = next((m for m in obj.modifiers if m.type == "MIRROR" and is_switched_on(m)), None)
    return modifier if modifier is not None and (modifier.use_mirror_merge or modifier.use_clip) else None


def _read_planes(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> list[Mirror]:
    """The planes of _mirror_of()."""
    modifier = _mirror_of(obj)
    if modifier is None:
        return []
    centre, size = np.eye(4), 0.0
    if modifier.mirror_object is not None:
        world, of_centre = read_matrix(obj, depsgraph), read_matrix(modifier.mirror_object, depsgraph)
        try:
            centre = np.asarray(inverted(of_centre) @ world)
            size = float(np.abs([world, of_centre]).max() * np.abs(inverted(world)[:3, :3]).max())
        except np.linalg.LinAlgError:  # scaled to nothing
            return []
    mirrors = []
    for axis, (is_on, is_bisected) in enumerate(zip(modifier.use_axis, modifier.use_bisect_axis, strict=True)):
        if is_on and not is_bisected:
            flip = np.eye(4)
            flip[axis, axis] = -1.0
            matrix = np.asarray(inverted(centre) @ flip @ centre)
            mirrors.append(Mirror(matrix, modifier.merge_threshold, size))
    return mirrors


def selected_vertices(obj: bpy.types.Object) -> NDArray[np.int32]:
    """(k,) int32 vertices selected in Edit Mode, now or when it was left."""
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    is_selected = np.empty(len(obj.data.vertices), dtype=bool)
    obj.data.vertices.foreach_get("select", is_selected)
    return np.flatnonzero(is_selected).astype(np.int32)


def select_vertices(obj: bpy.types.Object, vertices: NDArray[np.int32], *, shows_hidden: bool) -> None:
    """Selects only these vertices, outside of Edit Mode. Hidden ones are shown, or left out."""
    mesh = obj.data
    is_selected = np.zeros(len(mesh.vertices), dtype=bool)
    is_selected[vertices] = True
    is_hidden = np.empty(len(mesh.vertices), dtype=bool)
    mesh.vertices.foreach_get("hide", is_hidden)
    if shows_hidden:
        mesh.vertices.foreach_set("hide", is_hidden & ~is_selected)
    else:
        is_selected &= ~is_hidden
    mesh.vertices.foreach_set("select", is_selected)
    # In vertex mode Blender selects edges and faces by their vertices when it enters Edit Mode. An older selection of
    # edges and faces would stay.
    for items in (mesh.edges, mesh.polygons):
        items.foreach_set("select", np.zeros(len(items), dtype=bool))
    mesh.update()
