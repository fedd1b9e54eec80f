# SPDX-License-Identifier: GPL-3.0-or-later
"""One bound mesh: handles' matrices in, positions out.

Callers work in object space. The model works in solver space, object space times the stretch: there rigid means rigid
as seen. Only energies show it: they are in the square of world units.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import models
from .arrays import Floats, Ints
from .background import Cancelled, Progress, Result, Steps, part, stage
from .patches import begin_patches, patches_from, reaches_of_points, surface_diagonal
from .session_data import Readout, SessionMesh, SessionSettings
from .targets import HandleMap, HandleSpec, Patch, check_specs
from .transforms import map_points

if TYPE_CHECKING:
    import arap_native

PATCHES_SHARE = 0.1  # of the progress of new handles
HANDLES_CANCELLED = "Preparing the handles was cancelled; nothing has changed"
SOLVE_CANCELLED = "Solving was cancelled; the pose is as it was"


class Session:
    """The live session of one mesh. Made by bind(). While steps of it are under way, everything else is refused."""

    @classmethod
    def bind(
        cls,
        native: Any,
        mesh: SessionMesh,
        stretch: Floats,
        settings: SessionSettings,
        stiffness: Floats | None = None,
        rigid_regions: Ints | None = None,
    ) -> Steps[Session]:
        """Binds.

        Args:
            native: the module arap_native.
            mesh: at rest.
            stretch: (3, 3) symmetric factor of the polar decomposition of matrix_world; see transforms.stretch_of().
            settings: see SessionSettings.
            stiffness: (n,) > 0, or None.
            rigid_regions: (n,) int32 region of each vertex, negative for none, or None.

        Raises:
            ValueError: the mesh cannot be used; the message says where.
        """
        session = cls(native, mesh, stretch, settings)
        start = time.perf_counter()
        seen = replace(mesh, rest_positions=session._to_solver(session._rest))
        session._diagonal = surface_diagonal(seen.rest_positions, mesh.corner_vertices)
        job = models.begin_bind(native, models.ModelInput(seen, settings, stiffness, rigid_regions))
        session._model = yield from stage(job, "Binding was cancelled; nothing has changed")
        session._bind_ms = _ms_since(start)
        return session

    def __init__(self, native: Any, mesh: SessionMesh, stretch: Floats, settings: SessionSettings) -> None:
        """Prepares it, for bind()."""
        self._native = native
        self._stretch = np.ascontiguousarray(stretch, dtype=np.float64)
        self._unstretch: Floats = np.asarray(np.linalg.inv(self._stretch), dtype=np.float64)
        self._is_stretched = not np.array_equal(self._stretch, np.eye(3))
        self._rest = np.ascontiguousarray(mesh.rest_positions, dtype=np.float64)
        self._settings = settings
        self._map: HandleMap | None = None
        self._specs: tuple[HandleSpec, ...] = ()
        self._point_patches: dict[int, Patch] = {}
        self._positions = self._rest.astype(np.float32)
        # The solver writes single precision into memory that is there already: a frame allocates nothing.
        self._solved = np.empty_like(self._positions) if self._is_stretched else self._positions
        self._diagonal = 0.0  # as seen
        self._model: models.Model
        self._bind_ms = 0.0
        self._factor_ms = 0.0

    @property
    def n_vertices(self) -> int:
        return len(self._rest)

    @property
    def stretch(self) -> Floats:
        """(3, 3) float64."""
        return self._stretch

    @property
    def settings(self) -> SessionSettings:
        return self._settings

    @settings.setter
    def settings(self, settings: SessionSettings) -> None:
        if settings != self._settings and settings.of_bind != self._settings.of_bind:
            raise ValueError("Bending, rigidity, weights, threads and Weld Seams are fixed at bind: make a new session")
        self._settings = settings

    @property
    def positions(self) -> NDArray[np.float32]:
        """(n, 3) float32, contiguous, object space: where the mesh is now. Written over by the next update."""
        return self._positions

    @property
    def n_factorizations(self) -> int:
        """Numeric factorizations since the bind."""
        return self._model.n_factorizations

    @property
    def patches(self) -> Mapping[int, Patch]:
        """What the point handles hold, by index of the handle."""
        return self._point_patches

    def set_handles(self, specs: Sequence[HandleSpec]) -> Steps[None]:
        """Makes ``specs`` the handles; factorizes only if vertices or strengths have changed.

        Raises:
            ValueError: a vertex out of range, or nothing is held or moved. RuntimeError. The former handles then stay,
                and also if the work is dropped.
        """
        if self._map is not None and _are_same(self._specs, specs):
            if any(spec.base is not former.base for spec, former in zip(specs, self._specs, strict=True)):
                based = {i: self._based(patch, specs[i]) for i, patch in self._point_patches.items()}
                self._point_patches = based
                self._map = HandleMap(specs, self._rest, self._stretch, self._point_patches)
            self._specs = tuple(specs)
            return
        start = time.perf_counter()
        patches = yield from part(self._patches_of(specs), 0.0, PATCHES_SHARE)
        handle_map = HandleMap(specs, self._rest, self._stretch, patches)
        job = self._model.begin_set_constraints(handle_map.vertices, handle_map.strengths, handle_map.patches)
        try:
            yield from part(self._stage(job, HANDLES_CANCELLED), PATCHES_SHARE, 1.0)
        except GeneratorExit:
            if self._map is not None:  # the job may have ended before it heard of that; else this does nothing
                self._model.set_constraints(self._map.vertices, self._map.strengths, self._map.patches)
            raise
        self._factor_ms = _ms_since(start)
        self._map = handle_map
        self._specs = tuple(specs)
        self._point_patches = patches

    def _patches_of(self, specs: Sequence[HandleSpec]) -> Steps[dict[int, Patch]]:
        if not self._settings.has_radius:
            return {}
        check_specs(specs, self.n_vertices)
        reaches = reaches_of_points(
            specs,
            self._rest,
            self._stretch,
            self._settings.rigidity_radius * self._diagonal,
            self._model.loose_vertices,
        )
        if not reaches:
            return {}
        groups = [specs[i].vertices for i in reaches]
        job = begin_patches(self._model, groups, [reach / self._diagonal for reach in reaches.values()])
        found = patches_from((yield from self._stage(job, HANDLES_CANCELLED)), groups, self._unstretch)
        return {i: self._based(patch, specs[i]) for i, patch in zip(reaches, found, strict=True) if patch is not None}

    def _stage(self, job: arap_native.Job[Result], if_cancelled: str) -> Steps[Result]:
        """A job of the model as a stage. If the work is dropped, the model can be used at once."""
        try:
            return (yield from stage(job, if_cancelled))
        except GeneratorExit:
            job.wait()
            raise

    def _based(self, patch: Patch, spec: HandleSpec) -> Patch:
        base = self._rest if spec.base is None else spec.base
        return replace(patch, centre=patch.weights @ base[patch.vertices].astype(np.float64))

    def update(
        self,
        matrices: Floats,
        *,
        iterations: int | None = None,
        initial_guess: str | None = None,
        to_convergence: bool = False,
        time_limit_s: float | None = None,
        sufficient_accuracy: float = 0.0,
        progress: Progress | None = None,
    ) -> Readout:
        """Moves the mesh after its handles.

        Args:
            matrices: (h, 4, 4) float64 object-space motion of each handle, in the order of set_handles():
                (O_now^-1 M_now)(O_rest^-1 M_rest)^-1; identity for pins.
            iterations: the limit; None: settings.iterations_per_update, or with ``to_convergence``
                settings.max_iterations.
            initial_guess: None: settings.initial_guess.
            to_convergence: see ``iterations``.
            time_limit_s: stops before the iteration that would pass it, but not before the first; None: no limit.
            sufficient_accuracy: enough even if the settings ask for more.
            progress: may stop the update by returning False; the mesh is then where it was.

        Raises:
            ValueError: no handles yet, wrong shape, or a matrix that is not finite. RuntimeError: the solver
                failed. Cancelled. The mesh stays where it was in each case.
        """
        start = time.perf_counter()
        call = self._solve_call(matrices, iterations, initial_guess, to_convergence, time_limit_s, sufficient_accuracy)
        return self._take(self._model.solve(**call, progress=progress), start)

    def updating(self, matrices: Floats, *, initial_guess: str, to_convergence: bool) -> Steps[Readout]:
        """As update(), in the background. If the work is dropped, the mesh is where it was."""
        start = time.perf_counter()
        call = self._solve_call(matrices, initial_guess=initial_guess, to_convergence=to_convergence)
        return self._take((yield from self._stage(self._model.begin_solve(**call), SOLVE_CANCELLED)), start)

    def _solve_call(
        self,
        matrices: Floats,
        iterations: int | None = None,
        initial_guess: str | None = None,
        to_convergence: bool = False,
        time_limit_s: float | None = None,
        sufficient_accuracy: float = 0.0,
    ) -> dict[str, Any]:
        """What the model's solve is called with, for the arguments of update()."""
        if self._map is None:
            raise ValueError("The session has no handles: call set_handles first")
        settings = self._settings
        guess = initial_guess or settings.initial_guess
        at_most = settings.max_iterations if to_convergence else settings.iterations_per_update
        options = {
            "initial_guess": guess,
            "max_iterations": at_most if iterations is None else iterations,
            "accuracy": max(settings.accuracy, sufficient_accuracy),
        }
        if time_limit_s is not None:
            options["time_limit_s"] = time_limit_s
        return {
            "targets": self._map.targets(matrices),
            "options": self._native.SolveOptions(**options),
            "rotations": self._map.rotations(matrices) if guess == "handle_rotations" else None,
            "out": self._solved,
        }

    def _take(self, result: arap_native.SolveResult, start: float) -> Readout:
        """Shows the result of a solve that began at ``start``."""
        assert self._map is not None
        if result.stop_reason == "cancelled":
            raise Cancelled(SOLVE_CANCELLED)
        self._unstretch_solved()
        return Readout(
            vertices=self.n_vertices,
            free_vertices=self.n_vertices - len(self._map.vertices),
            last_ms=_ms_since(start),
            iterations=result.iterations,
            energy=result.energy_after,
            energy_before=result.energy_before,
            step=result.step,
            stop_reason=result.stop_reason,
            parts_at_rest=len(result.parts_at_rest),
            loose_vertices=len(result.loose_vertices),
            bind_ms=self._bind_ms,
            factor_ms=self._factor_ms,
        )

    def set_positions(self, positions: NDArray[np.floating]) -> None:
        """Goes on from ``positions``, (n, 3), object space.

        Raises:
            ValueError: wrong shape or not finite; the mesh stays where it was.
        """
        if positions.shape != self._rest.shape:
            raise ValueError(f"positions have shape {positions.shape}, expected {self._rest.shape}")
        self._model.set_positions(self._to_solver(np.ascontiguousarray(positions, dtype=np.float64)))
        self._positions[...] = positions

    def reset(self) -> None:
        """Back to rest; the handles stay."""
        self._model.reset()
        self._positions[...] = self._rest

    def _to_solver(self, positions: Floats) -> Floats:
        return np.ascontiguousarray(positions @ self._stretch.T) if self._is_stretched else positions

    def _unstretch_solved(self) -> None:
        if self._is_stretched:
            map_points(self._solved, self._unstretch.astype(np.float32), self._positions)


def _are_same(former: Sequence[HandleSpec], specs: Sequence[HandleSpec]) -> bool:
    return len(former) == len(specs) and all(a.is_same_as(b) for a, b in zip(former, specs, strict=True))


def _ms_since(start: float) -> float:
    return 1e3 * (time.perf_counter() - start)
