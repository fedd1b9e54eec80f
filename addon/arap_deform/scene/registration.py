# SPDX-License-Identifier: GPL-3.0-or-later
"""What a module gives to Blender, and takes back.

- its classes of the kinds below, in the order in which they stand;
- ``CALLBACKS``: pairs of a list, of ``bpy.app.handlers`` or ``props.hooks``, and a function for it;
- ``DRAWN``: pairs of a function that draws in the 3D views, and when;
- what its own functions register() and unregister() do, if it has them.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from enum import Enum, auto
from types import ModuleType
from typing import Any, TypeVar

import bpy

Item = TypeVar("Item")
Callbacks = Sequence[tuple[list[Any], Callable[..., None]]]

KINDS = (
    bpy.types.PropertyGroup,
    bpy.types.AddonPreferences,
    bpy.types.Operator,
    bpy.types.UIList,
    bpy.types.Panel,
    bpy.types.Menu,
)

_draw_handles: dict[str, list[Any]] = {}
"""What Blender needs to stop drawing, by name of the module."""


class Hearing(Enum):
    """Whether the handler looks at an evaluation."""

    NOW = auto()
    LATER = auto()  # but solves nothing before the next one: something is in the middle of a change
    NEVER = auto()  # the scene will be again as it was


hearing = Hearing.NOW
"""Read it; only quiet() and postponed() change it."""


def quiet() -> AbstractContextManager[None]:
    return _heard(Hearing.NEVER)


def postponed() -> AbstractContextManager[None]:
    return _heard(Hearing.LATER)


@contextmanager
def _heard(how: Hearing) -> Iterator[None]:
    global hearing  # noqa: PLW0603 - handlers take no other message
    before, hearing = hearing, how
    try:
        yield
    finally:
        hearing = before


def register(module: ModuleType) -> None:
    for cls in classes(module):
        bpy.utils.register_class(cls)
    if hasattr(module, "register"):
        module.register()
    add(getattr(module, "CALLBACKS", ()))
    space = bpy.types.SpaceView3D
    drawn = getattr(module, "DRAWN", ())
    _draw_handles[module.__name__] = [space.draw_handler_add(function, (), "WINDOW", when) for function, when in drawn]


def unregister(module: ModuleType) -> None:
    for handle in _draw_handles.pop(module.__name__):
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
    remove(getattr(module, "CALLBACKS", ()))
    if hasattr(module, "unregister"):
        module.unregister()
    for cls in reversed(classes(module)):
        bpy.utils.unregister_class(cls)


def add(callbacks: Callbacks) -> None:
    for functions, function in callbacks:
        functions.append(function)


def remove(callbacks: Callbacks) -> None:
    """Takes them out again. Loading a file may have done so: Blender keeps only persistent functions."""
    for functions, function in callbacks:
        if function in functions:
            functions.remove(function)


def for_each(items: Iterable[Item], act: Callable[[Item], object]) -> None:
    """For handlers and timers: a fault with one object is printed, and keeps no other from its turn."""
    for item in items:
        try:
            act(item)
        except Exception:  # noqa: BLE001 - whatever it is, the others are not at fault
            traceback.print_exc()


def classes(module: ModuleType) -> list[type]:
    own = [item for item in vars(module).values() if isinstance(item, type) and item.__module__ == module.__name__]
    return [cls for cls in own if issubclass(cls, KINDS)]
