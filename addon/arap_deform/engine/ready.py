# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a pose would be what the artist wants, asked once before a task: what moves it moves, and it is seen."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import bpy
import numpy as np

from ..core.arrays import Ints
from ..core.session_input import SessionInput
from ..scene import handle_motion
from ..scene.movers import still
from ..scene.seen import look


def check(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, inputs: SessionInput | None = None) -> None:
    """Raises ValueError if what moves the handles does not move here, or if what they move would not be seen.

    Args:
        depsgraph: the evaluated scene.
        inputs: from read_input(); None: all vertices count, not those of handles alone.
    """
    still.check(obj)
    check_seen(obj, depsgraph, inputs)


def check_seen(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    inputs: SessionInput | None,
    *,
    shown: Mapping[str, bool] = MappingProxyType({}),
) -> None:
    """As the second half of check(). ``shown``: see look.look()."""
    reason = look.look(obj, depsgraph, _moved(obj, inputs), shown=shown)
    if reason:
        raise ValueError(reason)


def check_rendered(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, inputs: SessionInput) -> None:
    """As check_seen(), for renders, where modifiers may be on that are off in viewports."""
    others = look.of_renders_alone(obj)
    if others:
        check_seen(obj, depsgraph, inputs, shown=dict.fromkeys(others, True))


def _moved(obj: bpy.types.Object, inputs: SessionInput | None) -> Ints | None:
    """The vertices that handles hold; None if they hold none, as bones that move what is inside."""
    if inputs is None:
        return None
    enabled = handle_motion.enabled_controls(obj)
    specs = (spec for control, spec in zip(enabled, inputs.specs, strict=True) if not control.is_pin)
    moved = [spec.vertices for spec in specs if len(spec.vertices)]
    return np.unique(np.concatenate(moved)) if moved else None
