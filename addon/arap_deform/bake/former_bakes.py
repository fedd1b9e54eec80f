# SPDX-License-Identifier: GPL-3.0-or-later
"""Former bakes are silent while a new one reads the frames: their keys are evaluated for nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import bpy

from ..attach.problems import below
from ..scene import baked, fcurves, known, shape_keys

Curve = tuple[int, int, str]  # uid of the object, and of its F-curves and drivers the number and the path


class FormerBakes:
    """Mutes the F-curves of keys that bakes have made, and what gives their values to linked keys, until wake().

    Holds no Blender data.
    """

    def __init__(self, objs: Iterable[bpy.types.Object]) -> None:
        self._muted: set[Curve] = set()
        for obj in objs:
            self._mute(obj)

    def wake(self) -> None:
        """Everything is as before. Does nothing the second time."""
        for uid in {uid for uid, _, _ in self._muted}:
            obj = known.find(uid)
            for curve, fcurve in _curves(obj) if obj is not None else ():
                if curve in self._muted:
                    fcurve.mute = False
        self._muted.clear()

    def _mute(self, host: bpy.types.Object) -> None:
        names = {host: set(baked.names_of_all(host))}
        for obj in (host, *below(host)):  # a host comes before what is attached to it
            if obj != host:
                link = obj.arap.attached_to
                names[obj] = {linked.key for linked in link.linked_keys if linked.name in names[link.host]}
            paths = {shape_keys.value_path(key) for name in names[obj] if (key := shape_keys.find(obj, name))}
            for curve, fcurve in _curves(obj) if paths else ():
                if fcurve.data_path in paths and not fcurve.mute:
                    fcurve.mute = True
                    self._muted.add(curve)


def _curves(obj: bpy.types.Object) -> Iterator[tuple[Curve, bpy.types.FCurve]]:
    """The F-curves and drivers of the shape keys of an object, of what is not linked."""
    keys = obj.data.shape_keys
    if keys is None or keys.animation_data is None:
        return
    for i, fcurve in enumerate((*fcurves.all_fcurves_of(keys), *keys.animation_data.drivers)):
        if fcurve.id_data.library is None:
            yield (obj.session_uid, i, fcurve.data_path), fcurve
