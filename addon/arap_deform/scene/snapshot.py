# SPDX-License-Identifier: GPL-3.0-or-later
"""What one frame sees of a mesh that is posed, read once: settings, what holds it, its key, its place."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

from ..core.arrays import Floats
from ..core.session_data import SessionSettings
from ..core.session_input import BoneConstraint, Constraint, Counts, SceneState, VertexConstraint
from ..core.stiffness import StiffGroup
from ..props import preferences
from ..props.bounds import all_bounded, bounded
from . import handle_motion, meshes, pose_key

if TYPE_CHECKING:
    from ..props.controls import ArapControl

LEAST_CUBE_SIZE = 0.1  # percent of the diagonal

# Settings that have the same name and meaning in ``obj.arap`` and for the solver.
SAME_NAMES = (
    "model", "keep_volume", "energy", "weights", "initial_guess", "iterations_per_update", "max_iterations", "accuracy",
)  # fmt: skip


@dataclass(frozen=True)
class Snapshot:
    """A mesh and what poses it, at one moment. It holds Blender data: after the next evaluation read another one.

    Attributes:
        depsgraph: what it was read from.
        world: (4, 4) float64 evaluated matrix of the object; it has an inverse.
        key: the shape key that takes the pose.
        state: what a session must fit.
    """

    obj: bpy.types.Object
    depsgraph: bpy.types.Depsgraph
    world: Floats
    key: pose_key.PoseKey
    state: SceneState

    @classmethod
    def read(cls, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, rest: Floats | None = None) -> Snapshot:
        """Reads a mesh object.

        Args:
            depsgraph: to read matrices from.
            rest: (n, 3) the mesh at rest; None: it is read if there is a Mirror modifier.

        Raises:
            ValueError: its matrix has no inverse.
        """
        world = meshes.read_matrix(obj, depsgraph)
        stretch = meshes.stretch_in(obj, world)
        key = pose_key.look(obj)
        settings = obj.arap
        state = SceneState(
            object_name=obj.name,
            counts=counts_of(obj),
            stretch=stretch,
            settings=settings_of(obj),
            constraints=constraints_of(handle_motion.enabled_controls(obj)),
            stiff_groups=stiff_groups_of(obj) if settings.stiffness else (),
            key_name=key.name,
            mirrors=meshes.read_mirrors(obj, depsgraph, stretch, rest) if obj.modifiers else (),
        )
        return cls(obj, depsgraph, world, key, state)

    def motions(self) -> Floats:
        """(h, 4, 4) as handle_motion.handle_matrices(). Raises ValueError if a handle cannot work."""
        return handle_motion.motions(self.obj, self.depsgraph, self.world)


def settings_of(obj: bpy.types.Object) -> SessionSettings:
    """The solver's settings: of ``obj.arap``, the threads of the preferences."""
    settings = obj.arap
    values = all_bounded(settings, (*SAME_NAMES, "cube_size", "rigidity"))
    cube_size, rigidity = values.pop("cube_size"), values.pop("rigidity")
    if cube_size > 0.0:
        cube_size = max(cube_size, LEAST_CUBE_SIZE)
    return SessionSettings(
        **values,
        cube_size=cube_size / 100.0,
        rigidity_radius=rigidity / 100.0,
        threads=preferences.threads(),
        join_seams=settings.use_weld,
        use_loose_parts=settings.use_loose_parts,
    )


def counts_of(obj: bpy.types.Object) -> Counts:
    """Vertices, edges, corners, faces."""
    mesh = obj.data
    return len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons)


def constraints_of(controls: Iterable[ArapControl]) -> tuple[Constraint, ...]:
    """What pins, handles and bones hold."""
    holds: list[Constraint] = []
    for control in controls:
        kind = control.kind
        if kind == "bone":
            holds.append(BoneConstraint(control.name, tuple(handle_motion.bone_ends(control).ravel().tolist())))
        elif kind == "pin":
            holds.append(VertexConstraint(control.vertex_group, base_id=control.base_id))
        else:
            reach = bounded(control, "reach") if control.reach else 0.0
            holds.append(VertexConstraint(control.vertex_group, control.use_exact, reach, control.base_id))
    return tuple(holds)


def stiff_groups_of(obj: bpy.types.Object) -> tuple[StiffGroup, ...]:
    """The enabled entries of the list Stiffness."""
    return tuple(
        StiffGroup(entry.name, bounded(entry, "factor"), entry.use_rigid, entry.use_single_body)
        for entry in obj.arap.stiffness
        if entry.is_enabled
    )
