# SPDX-License-Identifier: GPL-3.0-or-later
"""One look before a task: is a pose seen at all, or do modifiers take the vertices from elsewhere?

The mesh is displaced as a key would do it, evaluated, and put back: no step of undo, no value that stays, and none of
our handlers hears of it. It costs two evaluations of this mesh, so it is made once a task, never once a frame.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

import bpy
import numpy as np

from ...core.arrays import Float32s, Ints
from ...core.naming import listed
from .. import known, meshes, versions
from ..registration import quiet

# Modifiers that always show what comes into them, and are on most meshes: with these alone nobody needs to look.
PASSING = {
    "ARMATURE", "ARRAY", "BEVEL", "CORRECTIVE_SMOOTH", "CURVE", "DISPLACE", "EDGE_SPLIT", "HOOK", "LATTICE", "MIRROR",
    "MULTIRES", "SMOOTH", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "WEIGHTED_NORMAL",
}  # fmt: skip
# These show what they have simulated before, until it is simulated again: a look says nothing, and would disturb them.
SIMULATED = {"CLOTH", "DYNAMIC_PAINT", "EXPLODE", "FLUID", "PARTICLE_SYSTEM", "SOFT_BODY"}

# Displacement, as a fraction of the mesh's size: what makes a new mesh of it, as Remesh, should have no more to do. And
# of the largest coordinate, for what single precision leaves of it far from the origin.
STEP = 0.01
LEAST_STEP = 1e-5
MOVED = 1e-3  # least displacement seen, as a fraction of that

Stack = tuple[tuple[Any, ...], ...]

_noted: dict[int, tuple[Stack, str]] = {}
"""By uid of the object: the modifiers when one was looked at last, and what look() said."""


def look(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    rows: Ints | None = None,
    *,
    shown: Mapping[str, bool] = MappingProxyType({}),
) -> str:
    """Why a pose would not be seen, one sentence without a full stop; '' if it would, or if a look cannot tell.

    Not to be called by a handler: evaluations would hide from later ones what has changed.

    Args:
        depsgraph: an evaluated scene with the object; it is evaluated again.
        rows: (k,) the vertices concerned; None: all.
        shown: whether modifiers of these names show meanwhile.
    """
    if obj.type != "MESH" or obj.mode in {"EDIT", "SCULPT"} or not meshes.is_evaluated(obj, depsgraph):
        return ""  # what is seen of it does not tell
    with quiet(), _showing(obj, depsgraph, shown):
        suspects = [modifier.name for modifier in obj.modifiers if _is_suspect(modifier)]
        is_seen = not suspects or _is_simulated(obj) or _is_seen(obj, depsgraph, rows)
    reason = "" if is_seen else _sentence(obj, suspects)
    if not shown:
        _noted[known.add(obj)] = (_stack(obj), reason)
    return reason


def noted(obj: bpy.types.Object) -> str:
    """What the last look said, for drawing; '' if the modifiers are others now."""
    return _noted[obj.session_uid][1] if is_noted(obj) else ""


def is_noted(obj: bpy.types.Object) -> bool:
    """Whether there was a look at these modifiers."""
    return obj.session_uid in _noted and _noted[obj.session_uid][0] == _stack(obj)


def forget_updated(update: known.Update) -> None:
    """After an evaluation: a pose that was not seen may be, if modifiers were updated and not the mesh alone."""
    if update.is_deformed and not update.has_new_data and _noted.get(update.uid, ("", ""))[1]:
        del _noted[update.uid]


def of_renders_alone(obj: bpy.types.Object) -> list[str]:
    """Names of the modifiers that may hide a pose in renders, where alone they are on."""
    return [m.name for m in obj.modifiers if m.show_render and not m.show_viewport and m.type not in PASSING]


def clear() -> None:
    _noted.clear()


def _stack(obj: bpy.types.Object) -> Stack:
    """What tells modifiers apart that may hide a pose from others, quick enough to be asked at each step."""
    sources = ("node_group", "cache_file")
    return tuple(
        (
            modifier.name,
            modifier.type,
            modifier.show_viewport,
            *(data.session_uid for data in (getattr(modifier, name, None) for name in sources) if data is not None),
        )
        for modifier in obj.modifiers
        if modifier.type not in PASSING
    )


def _is_suspect(modifier: bpy.types.Modifier) -> bool:
    return bool(modifier.show_viewport) and modifier.type not in PASSING


def _is_simulated(obj: bpy.types.Object) -> bool:
    return any(modifier.show_viewport and modifier.type in SIMULATED for modifier in obj.modifiers)


def _sentence(obj: bpy.types.Object, suspects: list[str]) -> str:
    named = listed([f"'{name}'" for name in suspects])
    one = len(suspects) == 1
    return (
        f"A pose of '{obj.name}' would not be seen: {'modifier' if one else 'one of the modifiers'} {named} "
        f"{'takes' if one else 'may take'} the vertices from elsewhere; switch it off in viewports and renders"
    )


def _is_seen(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, rows: Ints | None) -> bool:
    depsgraph.update()
    before = _evaluated(obj, depsgraph)
    if not len(before):
        return True  # nothing shows in this frame, as under Build: it may in others
    step = _step(meshes.read_rest(obj))
    with _displaced(obj, depsgraph, step):
        after = _evaluated(obj, depsgraph)
    if len(before) != len(after):
        return True
    if rows is not None and len(after) == len(obj.data.vertices):
        before, after = before[rows], after[rows]
    return bool(np.abs(after - before).max(initial=0.0) > MOVED * step)


def _step(rest: Float32s) -> float:
    size, largest = (float(np.max(values, initial=0.0)) for values in (np.abs(rest - rest[:1]), np.abs(rest)))
    return max(STEP * size, LEAST_STEP * largest) or STEP


def _evaluated(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Float32s:
    return versions.read_positions(obj.evaluated_get(depsgraph).data)


@contextmanager
def _displaced(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, step: float) -> Iterator[None]:
    """Displaces each vertex by about ``step``, each otherwise: a modifier may undo what all have in common."""
    n = len(obj.data.vertices)
    shift = (step * np.random.default_rng(0).uniform(0.5, 1.5, (n, 3))).astype(np.float32)
    places: list[bpy.types.ShapeKey | bpy.types.Mesh] = _keys_shown(obj) or [obj.data]
    former = [_read(place) for place in places]

    def write(positions: Iterable[Float32s]) -> None:
        for place, values in zip(places, positions, strict=True):
            is_key = isinstance(place, bpy.types.ShapeKey)
            (versions.write_key if is_key else versions.write_positions)(place, values)
        obj.data.update_tag()
        depsgraph.update()

    try:
        write(values + shift for values in former)
        yield
    finally:
        write(former)


def _read(place: bpy.types.ShapeKey | bpy.types.Mesh) -> Float32s:
    return versions.read_key(place) if isinstance(place, bpy.types.ShapeKey) else versions.read_positions(place)


def _keys_shown(obj: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    """The reference, and what shows besides with what that is relative to: moved alike, their differences stay."""
    keys = obj.data.shape_keys
    if keys is None:
        return []
    if obj.show_only_shape_key and obj.active_shape_key is not None:
        return [obj.active_shape_key]
    found = [keys.reference_key]
    for key in keys.key_blocks:
        found += [key, key.relative_key] if key.value and not key.mute else []
    return list(dict.fromkeys(found))


@contextmanager
def _showing(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, shown: Mapping[str, bool]) -> Iterator[None]:
    """Shows or hides some modifiers of these names meanwhile."""
    former = {name: obj.modifiers[name].show_viewport for name in shown if name in obj.modifiers}
    try:
        for name in former:
            obj.modifiers[name].show_viewport = shown[name]
        yield
    finally:
        for name, value in former.items():
            obj.modifiers[name].show_viewport = value
        if former:
            depsgraph.update()
