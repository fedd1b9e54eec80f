# SPDX-License-Identifier: GPL-3.0-or-later
"""In which order several meshes are posed: what moves one may hang on the shape of another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from graphlib import CycleError, TopologicalSorter

import bpy

from .chain import PLACE, SHAPE, Chain, Part, place_of
from .still import handles_of


def waves(objs: Sequence[bpy.types.Object]) -> list[list[bpy.types.Object]]:
    """Each is in a later wave than those on whose shapes it hangs. Those of a circle cannot be told apart: one wave."""
    sorter = TopologicalSorter({obj: [other for other in _shapes_of(obj) if other in objs] for obj in objs})
    try:
        sorter.prepare()
    except CycleError:
        return [list(objs)]
    found = []
    while sorter.is_active():
        ready = sorter.get_ready()
        sorter.done(*ready)
        found.append([obj for obj in objs if obj in ready])
    return found


def _shapes_of(obj: bpy.types.Object) -> Iterator[bpy.types.Object]:
    """The other objects on whose shapes it hangs, by its place or by its handles."""
    starts = [Part(obj, PLACE), *map(place_of, handles_of(obj))]
    yield from (part.owner for part in Chain().walk(starts) if part.kind == SHAPE and part.owner != obj)
