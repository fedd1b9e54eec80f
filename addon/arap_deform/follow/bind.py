# SPDX-License-Identifier: GPL-3.0-or-later
"""The bind of an object's session in a worker thread."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..core.arrays import Float32s
from ..core.session import Session
from ..core.session_input import SessionInput
from ..core.worker import Binding
from . import mesh


class SessionBinding(Binding[Session]):
    """Binds a session, or gives the live session other handles if that is enough."""

    def __init__(self, obj: bpy.types.Object, inputs: SessionInput, start: Float32s | None = None) -> None:
        """Prepares it.

        Args:
            inputs: from read_input().
            start: (n, 3) positions to begin with; None: the pose that the key has.
        """
        self._name = obj.name
        self._inputs = inputs
        self._start_positions = start
        self._former = former = sessions.get(obj.name)
        sessions.drop(obj.name)  # the session is busy until adopt() or drop()
        super().__init__(lambda progress: sessions.rebuild(inputs, former, progress))

    def drop(self) -> None:
        """Asks the work to stop. If it has not begun, the former session is the live one again."""
        if not self.has_started and self._former is not None and sessions.get(self._name) is None:
            sessions.put(self._name, self._former)
        super().drop()

    def adopt(self) -> None:
        mesh.adopt(bpy.data.objects[self._name], self._inputs, self.result())
        if self._start_positions is not None:
            self.result().set_positions(self._start_positions)
