# SPDX-License-Identifier: GPL-3.0-or-later
"""A bind in a worker thread, and what becomes of it."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..core.arrays import Float32s
from ..core.session import Session
from ..core.sessions import SessionInput
from ..core.worker import Binding
from . import mesh
from .update import end_session, rebuild_session


class SessionBinding(Binding[Session]):
    """Binds, or gives the live session other handles where it lacks no more than that."""

    def __init__(self, obj: bpy.types.Object, inputs: SessionInput, start: Float32s | None = None) -> None:
        """Prepares it.

        Args:
            obj: the mesh.
            inputs: of session_input().
            start: (n, 3) where the session begins; None: at the pose that the key has.
        """
        self._name = obj.name
        self._inputs = inputs
        self._start_positions = start
        self._former = former = sessions.get(obj.name)
        end_session(obj)  # busy from here on
        super().__init__(lambda progress: rebuild_session(inputs, former, progress))

    def drop(self) -> None:
        """Asks the work to stop; where it has not begun, the former session is the live one again."""
        if not self.has_started and self._former is not None and sessions.get(self._name) is None:
            sessions.put(self._name, self._former)
        super().drop()

    def adopt(self) -> None:
        mesh.adopt(bpy.data.objects[self._name], self._inputs, self.result())
        if self._start_positions is not None:
            self.result().set_positions(self._start_positions)
