# SPDX-License-Identifier: GPL-3.0-or-later
"""The way of one frame: look at the scene, read the handles, solve, write the shape key."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import sessions
from ..core.arrays import Floats
from ..core.session import Session
from ..core.session_data import Readout
from ..core.session_input import Hold, difference, difference_of_scene
from ..scene import handle_motion, meshes, pose_key, shape_keys
from ..scene.inputs import read_input, read_state
from . import mesh


class Frame:
    """One frame of a mesh. What it reads of the scene it reads once, when it is made.

    ``problem`` says why the live session does not fit the scene, one sentence; '' if it does. Only then may matrices()
    and solve() be called. A frame holds Blender data: after the next evaluation of the scene make another one.
    """

    def __init__(
        self,
        obj: bpy.types.Object,
        depsgraph: bpy.types.Depsgraph,
        *,
        holds: tuple[Hold, ...] | None = None,
        is_thorough: bool = False,
        use_nodes: bool | None = False,
    ) -> None:
        """Looks at the scene.

        Args:
            depsgraph: to read matrices from.
            holds: what the session must hold; None: what the pins and handles of the object do.
            is_thorough: compare topology, rest shape and weights too, which takes milliseconds.
            use_nodes: see versions.read_group_weights().
        """
        self._obj = obj
        self._depsgraph = depsgraph
        self._bound = sessions.get(obj.session_uid)
        self.problem = "" if self._bound is not None else f"'{obj.name}' is not being posed"
        if self._bound is None:
            return
        try:
            meshes.check_mesh(obj)
            self._world: Floats = meshes.read_matrix(obj, depsgraph)
            stretch = meshes.stretch_in(obj, self._world)
            self._key = pose_key.look(obj)
            state = read_state(obj, depsgraph, stretch, self._key.name, self._bound.inputs.mesh.rest_positions)
            if holds is not None:
                state = replace(state, holds=holds)
            self.settings = state.settings
            self.problem = difference_of_scene(self._bound.inputs, state)
            if is_thorough and not self.problem:
                self.problem = difference(self._bound.inputs, read_input(obj, depsgraph, use_nodes=use_nodes))
        except ValueError as error:
            self.problem = str(error)

    def matrices(self) -> NDArray[np.float64]:
        """(h, 4, 4) as handle_motion.handle_matrices(). Raises ValueError if a handle cannot work."""
        return handle_motion.motions(self._obj, self._depsgraph, self._world)

    def solve(self, matrices: Floats, *, is_from_rest: bool = False, **options: Any) -> Readout:
        """Solves and writes the key, which is made if there is none.

        Args:
            matrices: (h, 4, 4) object-space motions of all that the session holds.
            is_from_rest: see mesh.solve_from_rest().
            options: of Session.update().

        Raises:
            ValueError: the key would not show the pose; nothing has changed.
        """
        assert self._bound is not None
        session = self._bound.session
        session.settings = self.settings
        key = pose_key.writable(self._obj, self._key)
        self._key = replace(self._key, key=key)
        if is_from_rest:
            result = mesh.solve_from_rest(session, matrices, **options)
        else:
            result = session.update(matrices, **options)
        write_pose(self._obj, key, session, result, is_frame=True)
        return result


def write_pose(
    obj: bpy.types.Object, key: bpy.types.ShapeKey, session: Session, result: Readout, *, is_frame: bool = False
) -> None:
    """Writes the session's positions to the key, shows it, and keeps the readout for the panel.

    ``is_frame``: see hooks.key_written.
    """
    shape_keys.write(obj, key, session.positions, is_frame=is_frame)
    shape_keys.show(key)
    sessions.set_readout(obj.session_uid, result)
