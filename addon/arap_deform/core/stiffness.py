# SPDX-License-Identifier: GPL-3.0-or-later
"""How stiff each vertex is, and which vertices move as one body, from the entries of the list Stiffness."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .arrays import Floats, Ints
from .graph import connected_labels, face_edges

if TYPE_CHECKING:
    from .session_data import SessionMesh

RIGID_WEIGHT = 0.5  # a vertex with this weight or more belongs to a rigid body


@dataclass(frozen=True)
class StiffGroup:
    """An entry of the list.

    Attributes:
        group: the vertex group.
        factor: stiffness at weight 1, normal is 1.
        use_rigid: the group moves as a body; ``factor`` does not count.
        use_single_body: the whole group is one body, joined or not; else each connected piece is one.
    """

    group: str
    factor: float = 100.0
    use_rigid: bool = False
    use_single_body: bool = False


def stiffness_of(entries: Sequence[StiffGroup], weights: Mapping[str, Floats]) -> Floats | None:
    """(n,) stiffness of each vertex, None if no entry sets any.

    It is factor^weight, so each step of weight multiplies, which looks even. A vertex in several entries takes the
    largest.

    Args:
        entries: of the list.
        weights: (n,) by group.
    """
    powers = [entry.factor ** np.clip(weights[entry.group], 0.0, 1.0) for entry in entries if not entry.use_rigid]
    return np.maximum.reduce(powers) if powers else None


def regions_of(entries: Sequence[StiffGroup], weights: Mapping[str, Floats], mesh: SessionMesh) -> Ints | None:
    """(n,) int32 rigid region of each vertex, -1 for none; None if no entry is rigid.

    Each connected piece of an entry is a region of its own, or the whole entry if it is one body. Entries that lie
    side by side stay two bodies with a hinge between them. Entries that share a vertex are one body.

    Args:
        entries: of the list.
        weights: (n,) by group; from RIGID_WEIGHT on a vertex belongs to it.
        mesh: whose faces say what is connected.
    """
    rigid = [entry for entry in entries if entry.use_rigid]
    if not rigid:
        return None
    first, second = face_edges(mesh.corner_vertices, mesh.face_sizes)
    is_rigid = np.zeros(len(mesh.rest_positions), dtype=bool)
    links = []
    for entry in rigid:
        is_inside = weights[entry.group] >= RIGID_WEIGHT
        is_rigid |= is_inside
        if entry.use_single_body:
            members = np.flatnonzero(is_inside).astype(first.dtype)
            links.append((members[:-1], members[1:]))
        else:
            is_within = is_inside[first] & is_inside[second]
            links.append((first[is_within], second[is_within]))
    ones, others = zip(*links, strict=True)
    labels = connected_labels(len(is_rigid), np.concatenate(ones), np.concatenate(others))
    _, regions = np.unique(np.where(is_rigid, labels, -1), return_inverse=True)
    return np.where(is_rigid, regions, -1).astype(np.int32)
