# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object hangs on: parents, bones, constraints, drivers, and for its shape modifiers; and what these hang on.

A ``Part`` is what something else can hang on: the place of an object, or of one of its bones; all its bones; its
shape; a property that a driver reads.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

from .. import meshes

if TYPE_CHECKING:
    from ...props.controls import ArapControl

PLACE, BONE, POSE, SHAPE, VALUE = "place", "bone", "pose", "shape", "value"

# The drivers that move an object or bone, by what follows its path; others drive colours, and whether it is shown.
MOVING = re.compile(r"(delta_)?(location|rotation_\w+|scale)\b|constraints\[|ik_")
BONE_PATH = re.compile(r'pose\.bones\["((?:[^"\\]|\\.)*)"\]\.?')
SHAPING = re.compile(r"modifiers\[|key_blocks\[|eval_time")
READ_AS_SHAPE = {"SHRINKWRAP", "FOLLOW_PATH", "CLAMP_TO"}  # constraints to the shape of their target


class Part(NamedTuple):
    """Something of a data-block that others hang on. ``name``: of the bone, or the path of the property."""

    owner: bpy.types.ID
    kind: str
    name: str = ""


def place_of(handle: ArapControl) -> Part:
    """What the motion of a handle with an object is read from."""
    return _place_of(handle.target, handle.bone)


def transform_sources(obj: bpy.types.Object, controls: Iterable[ArapControl]) -> list[bpy.types.Object]:
    """The objects that move handles, each with all its bones and its shape. The mesh itself is left out."""
    found: dict[bpy.types.Object, None] = {}  # a set in the order of finding
    chain = Chain()
    todo = [control.target for control in controls if control.target is not None]
    while todo:
        item = todo.pop()
        if item != obj and item not in found:
            found[item] = None
            whole = [Part(item, kind) for kind in (PLACE, POSE, SHAPE)]
            todo += [part.owner for part in chain.walk(whole) if isinstance(part.owner, bpy.types.Object)]
    return list(found)


class Chain:
    """Walks along all that parts hang on, and passes each once in all its walks: many handles hang on one rig.

    It holds Blender data: keep it no longer than the scene stays as it is.
    """

    def __init__(self) -> None:
        self._passed: set[Part] = set()
        self._drivers: dict[bpy.types.ID, dict[str, list[bpy.types.FCurve]]] = {}
        self._pulled: dict[bpy.types.Object, dict[str, list[str]]] = {}

    def walk(self, starts: Iterable[Part]) -> Iterator[Part]:
        """The parts, and what they hang on; those near the start first."""
        todo = list(starts)
        for part in todo:  # which grows
            is_within = part.kind == BONE and Part(part.owner, POSE) in self._passed
            if part not in self._passed and not is_within:
                self._passed.add(part)
                yield part
                todo += self._hung_on(part)

    def drivers_of(self, part: Part) -> Iterator[bpy.types.FCurve]:
        """The drivers that are on, and set what the part is."""
        by_bone = self._drivers_by_bone(part.owner)
        if part.kind == POSE:
            yield from (fcurve for bone, fcurves in by_bone.items() if bone for fcurve in fcurves)
        elif part.kind == BONE:
            yield from by_bone.get(part.name, ())
        elif part.kind == VALUE:
            of_all = (fcurve for fcurves in by_bone.values() for fcurve in fcurves)
            yield from (fcurve for fcurve in of_all if part.name.startswith(fcurve.data_path))
        else:
            keys = getattr(part.owner.data, "shape_keys", None) if part.kind == SHAPE else None
            pattern = MOVING if part.kind == PLACE else SHAPING
            for owner in filter(None, (part.owner, keys)):
                yield from (f for f in self._drivers_by_bone(owner).get("", ()) if pattern.match(f.data_path))

    def _drivers_by_bone(self, owner: bpy.types.ID) -> dict[str, list[bpy.types.FCurve]]:
        """Those that are on; of a bone those that move it, the others under ''."""
        found = self._drivers.get(owner)
        if found is None:
            found = self._drivers[owner] = {}
            animation = getattr(owner, "animation_data", None)
            for fcurve in animation.drivers if animation is not None else ():
                of_bone = BONE_PATH.match(fcurve.data_path)
                is_moving = of_bone is not None and MOVING.match(fcurve.data_path[of_bone.end() :])
                if not fcurve.mute:
                    bone = bpy.utils.unescape_identifier(of_bone[1]) if of_bone is not None and is_moving else ""
                    found.setdefault(bone, []).append(fcurve)
        return found

    def _hung_on(self, part: Part) -> Iterator[Part]:
        if part.kind == PLACE:
            yield from _of_place(part.owner)
        elif part.kind == BONE:
            yield from self._of_bone(part.owner, part.name)
        elif part.kind == POSE and part.owner.pose is not None:
            for bone in part.owner.pose.bones:
                yield from _of_constraints(bone)
        elif part.kind == SHAPE:
            yield from _of_shape(part.owner)
        for fcurve in self.drivers_of(part):
            for variable in fcurve.driver.variables:
                yield from _of_variable(variable)

    def _of_bone(self, rig: bpy.types.Object, name: str) -> Iterator[Part]:
        yield Part(rig, PLACE)
        bone = rig.pose.bones.get(name) if rig.pose is not None else None
        if bone is None:
            return
        if bone.parent is not None:
            yield Part(rig, BONE, bone.parent.name)
        yield from _of_constraints(bone)
        yield from (Part(rig, BONE, end) for end in self._ends_by_bone(rig).get(name, ()))

    def _ends_by_bone(self, rig: bpy.types.Object) -> dict[str, list[str]]:
        """The bones from whose ends a chain is moved, by the bones of these chains."""
        found = self._pulled.get(rig)
        if found is None:
            found = self._pulled[rig] = {}
            for end in rig.pose.bones:
                for constraint in end.constraints:
                    if constraint.type in {"IK", "SPLINE_IK"} and not constraint.mute:
                        for bone in _pulled_by(end, constraint):
                            found.setdefault(bone.name, []).append(end.name)
        return found


def _pulled_by(end: bpy.types.PoseBone, constraint: bpy.types.Constraint) -> list[bpy.types.PoseBone]:
    """The bones that IK at the end of this one moves."""
    bones = [end, *end.parent_recursive]
    if constraint.type == "IK" and not constraint.use_tail:
        bones = bones[1:]
    return bones[: constraint.chain_count] if constraint.chain_count else bones


def _of_place(obj: bpy.types.Object) -> Iterator[Part]:
    parent = obj.parent
    if parent is not None:
        yield _place_of(parent, obj.parent_bone if obj.parent_type == "BONE" else "")
        if obj.parent_type in {"VERTEX", "VERTEX_3"}:
            yield Part(parent, SHAPE)
    yield from _of_constraints(obj)


def _of_shape(obj: bpy.types.Object) -> Iterator[Part]:
    if obj.data is not None:
        yield Part(obj.data, VALUE)
    if obj.parent is not None and obj.parent_type == "ARMATURE":
        yield Part(obj.parent, POSE)
    for modifier in obj.modifiers:
        if not meshes.is_switched_on(modifier):
            continue
        bone = getattr(modifier, "subtarget", "")
        for _, data in _pointers(modifier):
            if not isinstance(data, bpy.types.Object):
                yield Part(data, VALUE)
                continue
            yield _place_of(data, bone)
            if modifier.type == "ARMATURE":
                yield Part(data, POSE)


def _of_constraints(owner: bpy.types.Object | bpy.types.PoseBone) -> Iterator[Part]:
    for constraint in owner.constraints:
        # An Armature constraint has several targets.
        for each in () if constraint.mute else (constraint, *getattr(constraint, "targets", ())):
            yield from _of_targets(constraint.type, each)


def _of_targets(kind: str, struct: Any) -> Iterator[Part]:
    for name, data in _pointers(struct):
        if not isinstance(data, bpy.types.Object):
            yield Part(data, VALUE)
            continue
        bone = getattr(struct, "pole_subtarget" if name.startswith("pole") else "subtarget", "")
        yield _place_of(data, bone)
        if kind in READ_AS_SHAPE or (bone and data.type != "ARMATURE"):
            yield Part(data, SHAPE)


def _of_variable(variable: bpy.types.DriverVariable) -> Iterator[Part]:
    for target in variable.targets:
        if target.id is None:
            continue
        if variable.type != "SINGLE_PROP":
            yield _place_of(target.id, target.bone_target)
            continue
        yield Part(target.id, VALUE, target.data_path)


def _place_of(obj: bpy.types.Object, bone: str) -> Part:
    return Part(obj, BONE, bone) if bone and obj.type == "ARMATURE" else Part(obj, PLACE)


def _pointers(struct: Any) -> list[tuple[str, bpy.types.ID]]:
    """The data-blocks that a modifier, constraint or target names, by the names of its properties."""
    found = [(name, getattr(struct, name)) for name in _pointer_names(struct.bl_rna)]
    return [(name, data) for name, data in found if isinstance(data, bpy.types.ID)]


@cache
def _pointer_names(kind: bpy.types.Struct) -> list[str]:
    return [prop.identifier for prop in kind.properties if prop.type == "POINTER"]
