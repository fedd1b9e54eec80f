# SPDX-License-Identifier: GPL-3.0-or-later
"""Why what moves the handles of a mesh does not move here: it would be posed, and baked, as if nobody had moved it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ...core import naming
from .chain import BONE, PLACE, POSE, SHAPE, Chain, Part, place_of

if TYPE_CHECKING:
    from ...props.controls import ArapControl


def check(obj: bpy.types.Object) -> None:
    """Raises ValueError with all of problems()."""
    if found := problems(obj):
        raise ValueError(naming.sentences(found))


def problems(obj: bpy.types.Object) -> list[str]:
    """A sentence for the mesh, and for each enabled handle, that hangs on what does not move here.

    Whether the handles themselves can work is not asked: see handle_motion.problems(). The scene has been
    evaluated: what Blender could not do then is noted in its drivers.
    """
    chain = Chain()
    parts = [(f"'{obj.name}'", Part(obj, PLACE))]
    parts += [(f"{handle.label} of '{obj.name}'", place_of(handle)) for handle in handles_of(obj)]
    found = ((whose, _why_still(part, chain)) for whose, part in parts)
    return [f"{whose} does not move as it should: {reason}" for whose, reason in found if reason]


def handles_of(obj: bpy.types.Object) -> list[ArapControl]:
    """The enabled handles that have an object."""
    return [handle for handle in obj.arap.handles if handle.is_enabled and handle.target is not None]


def _why_still(start: Part, chain: Chain) -> str:
    """Of the part, and of what it hangs on, if no walk has passed there before."""
    for part in chain.walk([start]):
        undriven = (_why_undriven(fcurve) for fcurve in chain.drivers_of(part))
        reasons = (*(why_missing(data) for data in _data_of(part)), _why_at_rest(part), *undriven)
        if reason := next(filter(None, reasons), ""):
            return reason
    return ""


def _data_of(part: Part) -> Iterator[bpy.types.ID]:
    """What a part is read from."""
    owner = part.owner
    yield owner
    if isinstance(owner, bpy.types.Object) and part.kind in {BONE, POSE, SHAPE} and owner.data is not None:
        yield owner.data
    keys = getattr(getattr(owner, "data", None), "shape_keys", None) if part.kind == SHAPE else None
    for data in filter(None, (owner, keys)):
        animation = data.animation_data if hasattr(data, "animation_data") else None
        if animation is not None:
            strips = (strip for track in animation.nla_tracks if not track.mute for strip in track.strips)
            yield from filter(None, (animation.action, *(strip.action for strip in strips)))


def why_missing(data: bpy.types.ID) -> str:
    """Whether its library or file is missing, so that it stands still; '' if it is not."""
    reference = data.override_library.reference if data.override_library is not None else None
    if (
        isinstance(data, bpy.types.CacheFile)
        and not Path(bpy.path.abspath(data.filepath, library=data.library)).exists()
    ):
        return f"the file of '{data.name}', {data.filepath}, is missing; bring it back"
    linked = next((each for each in (data, reference) if each is not None and each.is_missing), None)
    if linked is None:
        return ""
    where = linked.library.filepath if linked.library is not None else "its library"
    return f"'{data.name}' is missing from {where}; bring that file back, or link it again"


def _why_at_rest(part: Part) -> str:
    rig = part.owner
    if part.kind not in {BONE, POSE} or getattr(rig, "type", "") != "ARMATURE":
        return ""
    if rig.data.is_editmode:
        return f"armature '{rig.name}' is in Edit Mode; go back to Object Mode first"
    if rig.data.pose_position == "REST":
        return f"armature '{rig.name}' shows its rest position; set it to Pose Position"
    return ""


def _why_undriven(fcurve: bpy.types.FCurve) -> str:
    driver = fcurve.driver
    if driver.is_valid:
        return ""
    where = f"the driver of '{fcurve.data_path}' of '{fcurve.id_data.name}'"
    if driver.type == "SCRIPTED" and not driver.is_simple_expression and bpy.app.autoexec_fail:
        return (
            f"{where} needs Python ({driver.expression}), which may not run; allow scripts (--enable-autoexec on the "
            "command line)"
        )
    return f"{where} does not work; mend or remove it"
