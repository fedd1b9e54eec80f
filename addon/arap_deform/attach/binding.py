# SPDX-License-Identifier: GPL-3.0-or-later
"""An object that is bound to its host in the background: a bar shows how far it is, and Esc ends it."""

from __future__ import annotations

import time

import bpy

from ..core.attach.wrap import Wrap
from ..core.background import Background, Steps
from ..engine.scene import is_rendering
from ..ui import waiting
from ..ui.esc import EndedByEsc, is_free
from ..ui.waits import Wait, wait_for_bind
from . import problems


class Binding(EndedByEsc):
    """Holds no Blender data."""

    def __init__(self, attached: bpy.types.Object, steps: Steps[Wrap]) -> None:
        """Begins."""
        self._uid = attached.session_uid
        self._name = attached.name  # for messages
        self._began = time.monotonic()
        self.work = Background(steps)
        waiting.watch(self)

    @property
    def is_binding(self) -> bool:
        return not self.work.is_done

    @property
    def bind_fraction(self) -> float:
        return self.work.fraction

    @property
    def bind_s(self) -> float:
        return time.monotonic() - self._began

    def wait(self) -> Wait | None:
        return None if is_rendering() else wait_for_bind(self._name, self, ends_on_esc=is_free())

    def cancel(self) -> str:
        pair = problems.pair_of(self._uid)
        if pair is None:
            return ""
        pair[1].is_enabled = False  # which stops the work
        return f"Preparing '{self._name}' cancelled: it does not follow until it is ticked in the list"
