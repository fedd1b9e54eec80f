# SPDX-License-Identifier: GPL-3.0-or-later
"""The models that a session can be bound to. Only this file names their classes in arap_native."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from .arrays import Floats, Ints
from .session_data import SessionMesh, SessionSettings

if TYPE_CHECKING:
    import arap_native

Model: TypeAlias = "arap_native.Model"


@dataclass(frozen=True)
class ModelInput:
    """What a model is bound to.

    Attributes:
        mesh: at rest, in solver space.
        settings: of the object.
        stiffness: (n,) 1e-12 to 1e12, or None.
        rigid_regions: (n,) int32 region of each vertex, negative for none, or None.
    """

    mesh: SessionMesh
    settings: SessionSettings
    stiffness: Floats | None = None
    rigid_regions: Ints | None = None


def begin_bind(native: Any, inputs: ModelInput) -> arap_native.Job[Model]:
    """Begins to bind a model. The job raises ValueError if the mesh cannot be used.

    Args:
        native: the module arap_native.
        inputs: see ModelInput.
    """
    mesh = inputs.mesh
    begin, options = _SORTS[inputs.settings.model](native, inputs.settings)
    job: arap_native.Job[Model] = begin(
        np.ascontiguousarray(mesh.rest_positions, dtype=np.float64),
        np.ascontiguousarray(mesh.corner_vertices, dtype=np.int32),
        np.ascontiguousarray(mesh.face_sizes, dtype=np.int32),
        options=options,
        stiffness=inputs.stiffness,
        rigid_regions=inputs.rigid_regions,
    )
    return job


def solid_of(native: Any, model: Model) -> arap_native.LatticeArap | None:
    """The model, if it is one with an inside."""
    return model if isinstance(model, native.LatticeArap) else None


def _surface(native: Any, settings: SessionSettings) -> tuple[Any, Any]:
    return native.SurfaceArap.begin_bind, native.Options(
        energy=settings.energy,
        rigidity_radius=settings.rigidity_radius,
        weights=settings.weights,
        threads=settings.threads,
        join_seams=settings.join_seams,
    )


def _solid(native: Any, settings: SessionSettings) -> tuple[Any, Any]:
    return native.LatticeArap.begin_bind, native.LatticeOptions(
        cube_size=settings.cube_size,
        keep_volume=settings.keep_volume,
        threads=settings.threads,
        join_seams=settings.join_seams,
    )


_SORTS = {"surface": _surface, "solid": _solid}
