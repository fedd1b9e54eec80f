# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The base of a pin or handle: the places from which it holds its vertices, as they were shown when it was added.

Offsets from rest are attributes of the mesh, so Blender keeps them through edits, undo and copies. Entries share a
layer, which is a pair of attributes: the offsets, and the number of the entry to which each belongs. An entry that has
vertices in common with others in a layer takes the next one.
"""

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

import bmesh
import bpy
import numpy as np
from bpy.props import IntProperty
from numpy.typing import NDArray

OFFSETS, OWNERS = ".arap_base", ".arap_base_of"  # Blender shows no attribute with a dot
MOST_ID = 2**22  # where Edit Mode subdivides, it means whole numbers in single precision, which is exact up to here

Ints = NDArray[np.int32]
Float32s = NDArray[np.float32]
Layer = tuple[Ints, Float32s]
"""(n,) number of the entry that each offset belongs to, and (n, 3) the offsets."""


class BaseShape:
    """A mixin for what was added to a posed mesh."""

    base_id: IntProperty(options={"HIDDEN"}, description="Number of its base; 0: the mesh at rest")

    @property
    def base(self) -> tuple[Ints, Float32s]:
        """(k,) vertices and (k, 3) their offsets from rest; none if its base is the mesh at rest, or is damaged."""
        nothing = np.zeros(0, np.int32), np.zeros((0, 3), np.float32)
        if not self.base_id:
            return nothing
        with _stored(self.id_data.data) as mesh:  # type: ignore[attr-defined]
            for layer in _layers(mesh):
                vertices = np.flatnonzero(_owners(mesh, layer) == self.base_id).astype(np.int32)
                if len(vertices):
                    offsets = _offsets(mesh, layer)[vertices]
                    return (vertices, offsets) if np.isfinite(offsets).all() else nothing
        return nothing

    def set_base(self, vertices: Ints, offsets: NDArray[np.floating]) -> None:
        """See base."""
        BaseShape.forget_base(self)
        if len(vertices):
            mesh = self.id_data.data  # type: ignore[attr-defined]
            self.base_id = _new_id(mesh)
            write = _write_edited if mesh.is_editmode else _write
            write(mesh, vertices, offsets.astype(np.float32), self.base_id)

    def forget_base(self) -> None:
        """Its base is the mesh at rest from now on."""
        if self.base_id:
            mesh = self.id_data.data  # type: ignore[attr-defined]
            if mesh.users == 1:  # else a twin may have an entry of the same number
                (_forget_edited if mesh.is_editmode else _forget)(mesh, self.base_id)
            self.base_id = 0


@contextmanager
def _stored(mesh: bpy.types.Mesh) -> Iterator[bpy.types.Mesh]:
    """The mesh, or in Edit Mode a copy of what is edited, which has attributes."""
    if not mesh.is_editmode:
        yield mesh
        return
    copy = bpy.data.meshes.new(mesh.name)
    try:
        bmesh.from_edit_mesh(mesh).to_mesh(copy)
        yield copy
    finally:
        bpy.data.meshes.remove(copy)


def _names(layer: int) -> tuple[str, str]:
    end = f"_{layer}" if layer else ""
    return OFFSETS + end, OWNERS + end


def _is_taken(mesh: bpy.types.Mesh, layer: int) -> bool:
    return any(name in mesh.attributes for name in _names(layer))


def _layers(mesh: bpy.types.Mesh) -> Iterator[int]:
    """Of those that are sound: a file may have anything under these names."""
    layer = 0
    while _is_taken(mesh, layer):
        if _is_sound(mesh, layer):
            yield layer
        layer += 1


def _is_sound(mesh: bpy.types.Mesh, layer: int) -> bool:
    found = [mesh.attributes.get(name) for name in _names(layer)]
    kinds = [(attribute.domain, attribute.data_type) for attribute in found if attribute is not None]
    return kinds == [("POINT", "FLOAT_VECTOR"), ("POINT", "INT")]


def _owners(mesh: bpy.types.Mesh, layer: int) -> Ints:
    result = np.empty(len(mesh.vertices), dtype=np.int32)
    mesh.attributes[_names(layer)[1]].data.foreach_get("value", result)
    return result


def _offsets(mesh: bpy.types.Mesh, layer: int) -> Float32s:
    result = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    mesh.attributes[_names(layer)[0]].data.foreach_get("vector", result.ravel())
    return result


def _put(mesh: bpy.types.Mesh, layer: int, owners: Ints, offsets: Float32s) -> None:
    of_offsets, of_owners = _names(layer)
    mesh.attributes[of_owners].data.foreach_set("value", owners)
    mesh.attributes[of_offsets].data.foreach_set("vector", offsets.ravel())


def _free_layer(mesh: bpy.types.Mesh) -> int:
    return next(layer for layer in count() if not _is_taken(mesh, layer))


def _new_layer(mesh: bpy.types.Mesh) -> int:
    layer = _free_layer(mesh)
    for name, kind in zip(_names(layer), ("FLOAT_VECTOR", "INT"), strict=True):
        mesh.attributes.new(name, kind, "POINT")
    return layer


def _new_id(mesh: bpy.types.Mesh) -> int:
    with _stored(mesh) as stored:
        owners = [_owners(stored, layer) for layer in _layers(stored)]
    while True:
        number = 1 + secrets.randbelow(MOST_ID)
        if not any((of_layer == number).any() for of_layer in owners):
            return number


def _layer_for(mesh: bpy.types.Mesh, vertices: Ints) -> int | None:
    """The first layer in which no entry has these vertices."""
    return next((layer for layer in _layers(mesh) if not _owners(mesh, layer)[vertices].any()), None)


def _write(mesh: bpy.types.Mesh, vertices: Ints, offsets: Float32s, base_id: int) -> None:
    layer = _layer_for(mesh, vertices)
    if layer is None:
        layer = _new_layer(mesh)
    owners, places = _owners(mesh, layer), _offsets(mesh, layer)
    owners[vertices], places[vertices] = base_id, offsets
    _put(mesh, layer, owners, places)


def _write_edited(mesh: bpy.types.Mesh, vertices: Ints, offsets: Float32s, base_id: int) -> None:
    """In Edit Mode, where Blender lets nobody at attributes but vertex by vertex: only those that are held."""
    with _stored(mesh) as stored:
        layer = _layer_for(stored, vertices)
        of_offsets, of_owners = _names(_free_layer(stored) if layer is None else layer)
    edited = bmesh.from_edit_mesh(mesh)
    if layer is None:
        edited.verts.layers.int.new(of_owners)
        edited.verts.layers.float_vector.new(of_offsets)
    owner, place = edited.verts.layers.int[of_owners], edited.verts.layers.float_vector[of_offsets]
    edited.verts.ensure_lookup_table()
    for vertex, offset in zip(vertices.tolist(), offsets.tolist(), strict=True):
        edited.verts[vertex][owner], edited.verts[vertex][place] = base_id, offset


def _forget_edited(mesh: bpy.types.Mesh, base_id: int) -> None:
    with _stored(mesh) as stored:
        owned = {layer: np.flatnonzero(_owners(stored, layer) == base_id).tolist() for layer in _layers(stored)}
    edited = bmesh.from_edit_mesh(mesh)
    edited.verts.ensure_lookup_table()
    for layer, vertices in owned.items():
        owner = edited.verts.layers.int[_names(layer)[1]]
        for vertex in vertices:
            edited.verts[vertex][owner] = 0


def _forget(mesh: bpy.types.Mesh, base_id: int) -> None:
    for layer in list(_layers(mesh)):
        owners = _owners(mesh, layer)
        is_owned = owners == base_id
        if is_owned.any():
            owners[is_owned] = 0
            mesh.attributes[_names(layer)[1]].data.foreach_set("value", owners)


def capture(mesh: bpy.types.Mesh) -> list[Layer] | None:
    """What restore() restores; None of a mesh in Edit Mode."""
    return None if mesh.is_editmode else [(_owners(mesh, layer), _offsets(mesh, layer)) for layer in _layers(mesh)]


def restore(mesh: bpy.types.Mesh, layers: list[Layer] | None) -> None:
    """Restores what capture() returned, unless the mesh has another number of vertices now, or is edited."""
    if layers is None or mesh.is_editmode or any(len(owners) != len(mesh.vertices) for owners, _ in layers):
        return
    there = list(_layers(mesh))
    while len(there) < len(layers):
        there.append(_new_layer(mesh))
    for layer in there[len(layers) :]:
        _put(mesh, layer, np.zeros(len(mesh.vertices), np.int32), _offsets(mesh, layer))
    for layer, (owners, offsets) in zip(there, layers, strict=False):
        _put(mesh, layer, owners, offsets)


def turn_bases(mesh: bpy.types.Mesh, linear: NDArray[np.floating]) -> None:
    """The offsets of all entries in other coordinates of the mesh: (3, 3) ``linear`` @ offset."""
    for layer in _layers(mesh):
        _put(mesh, layer, _owners(mesh, layer), (_offsets(mesh, layer) @ linear.T).astype(np.float32))
