# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts functions into Blender's lists ``bpy.app.handlers``, and takes them out again."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy

Handlers = Sequence[tuple[str, Callable[..., None]]]  # the name of a list, and a function for it


def add(handlers: Handlers) -> None:
    for event, function in handlers:
        getattr(bpy.app.handlers, event).append(function)


def remove(handlers: Handlers) -> None:
    """Takes them out again. Loading a file may have done so: it keeps only persistent functions."""
    for event, function in handlers:
        functions = getattr(bpy.app.handlers, event)
        if function in functions:
            functions.remove(function)
