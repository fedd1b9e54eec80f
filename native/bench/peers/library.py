# SPDX-License-Identifier: GPL-3.0-or-later
"""What the worker asks of a library."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from measure.inputs.mesh import Mesh
from measure.inputs.tasks import Task
from numpy.typing import NDArray


class Library(Protocol):
    """One library, made for a mesh of triangles and a task.

    Attributes:
        binds_in_every_solve: it has no bind of its own: solve() does one, as long as bind() takes.
    """

    binds_in_every_solve: bool

    def __init__(self, mesh: Mesh, task: Task, options: dict[str, Any]) -> None: ...
    def version(self) -> str: ...
    def bind(self) -> None: ...
    def solve(self, n_iterations: int) -> None:
        """Exactly so many iterations from rest."""

    def positions(self) -> NDArray[np.float64]:
        """(n, 3) float64, C-ordered, where the last solve ended."""
