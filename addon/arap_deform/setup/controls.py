# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of pins, handles and bones: an entry found, added, removed.

Functions return names: Blender moves the entries of a list when it grows, so a reference to one does not last.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bpy

from ..core import naming
from ..scene import groups, handle_motion, meshes, preserve_shape, ui_cache
from . import made_objects
from .control_changes import suppress_updates

if TYPE_CHECKING:
    from ..props.controls import ArapControl


def new_control(obj: bpy.types.Object, kind: str, name: str, vertex_group: str = "") -> ArapControl:
    """Appends an entry, enabled and chosen. A name that another has gets a number."""
    controls = obj.arap.controls
    unique_name = naming.unique(name, {control.name for control in controls})
    control: ArapControl = controls.add()
    with suppress_updates():
        control.kind = kind
        control.name = unique_name
        control.vertex_group = vertex_group
    obj.arap.chosen_control_index = len(controls) - 1
    return control


def index_of(obj: bpy.types.Object, name: str) -> int:
    """The place of an entry in the list. Raises ValueError if there is none of that name."""
    if not isinstance(name, str):
        raise ValueError(  # noqa: TRY004 - the errors of scripts are ValueError and RuntimeError
            f"{name!r} is no name: give that of the pin, handle or bone"
        )
    index = int(obj.arap.controls.find(name))
    if index < 0:
        there = ", ".join(f"'{control.name}'" for control in obj.arap.controls) or "none"
        raise ValueError(f"'{obj.name}' has no pin, handle or bone '{name}': it has {there}")
    return index


def remove_control(obj: bpy.types.Object, name: str) -> None:
    """Removes a pin, handle or bone, and the vertex group and the empty made for it if nothing else uses them."""
    meshes.check_local(obj)
    remove_at(obj, index_of(obj, name))


def remove_at(obj: bpy.types.Object, index: int) -> None:
    """As remove_control(), the entry at a place in the list."""
    settings = obj.arap
    control = settings.controls[index]
    target = control.target if control.has_made_target and not control.is_pin else None
    if target is not None and target.mode != "OBJECT":
        raise ValueError(f"'{target.name}' is in another mode: go back to Object Mode first")
    group = control.vertex_group if control.has_made_group else ""
    control.forget_base()
    settings.controls.remove(index)
    settings.chosen_control_index = max(0, min(settings.chosen_control_index, len(settings.controls) - 1))
    groups.remove_unused(obj, group)
    if target is not None:
        made_objects.remove_unused(target)


@contextmanager
def all_or_none(obj: bpy.types.Object) -> Iterator[int]:
    """While controls are added, from the index that it yields on: if one cannot be, none is."""
    settings, bases = obj.arap, preserve_shape.capture_bases(obj)
    first, chosen = len(settings.controls), settings.chosen_control_index
    try:
        yield first
    except BaseException:
        for index in reversed(range(first, len(settings.controls))):
            remove_at(obj, index)
        settings.chosen_control_index = chosen
        preserve_shape.restore_bases(obj, bases)
        raise


def control_problem(obj: bpy.types.Object, control: ArapControl, *, with_weights: bool = False) -> str:
    """Why a handle or bone cannot work (no object, group missing ...), one sentence; '' if it can, and for pins.

    Args:
        with_weights: report a group without weights too, if a look at it takes only milliseconds: see ui_cache.
    """
    if control.is_pin:
        return ""
    problem = handle_motion.problem_of(obj, control, meshes.drawn_depsgraph(bpy.context))
    if not problem and with_weights and ui_cache.is_empty_group(obj, control.vertex_group):
        return handle_motion.no_weights(obj, control)
    return problem
