# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts functions into Blender's lists ``bpy.app.handlers``, and takes them out again."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy

Handlers = Sequence[tuple[str, Callable[..., None]]]  # the name of a list, and what it is to call


def add(handlers: Handlers) -> None:
    for event, function in handlers:
        getattr(bpy.app.handlers, event).append(function)


def remove(handlers: Handlers) -> None:
    """Takes out those that are still there: loading a file has cleared the lists of what is not persistent."""
    for event, function in handlers:
        functions = getattr(bpy.app.handlers, event)
        if function in functions:
            functions.remove(function)
