# SPDX-License-Identifier: GPL-3.0-or-later
"""One bound mesh: handles' matrices in, positions out.

Callers work in object space. The model works in solver space, object space times the stretch: there rigid means rigid
as seen. Only energies show it: they are in the square of world units.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import models
from .arrays import Float32s, Floats, Ints
from .background import Cancelled, Progress, Result, Steps, part, stage
from .loose.parts import LooseParts
from .mirror import Copy, Mirror, completed
from .naming import listed
from .patches import Surface, begin_patches, held_by_themselves, patches_from, points_of, surface_diagonal, without
from .session_data import OF_BIND, SessionMesh, SessionSettings, SolveStats
from .targets import NO_PATCHES, HandleMap, HandleSpec, Patch, Patches, check_specs, checked_matrices
from .transforms import SolverSpace

if TYPE_CHECKING:
    import arap_native

CUBE_EDGES = [corner for bit in (1, 2, 4) for i in range(8) if not i & bit for corner in (i, i | bit)]
"""Corners at the ends of the edges of a cube, two by two."""
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
        mirrors: Sequence[Mirror] = (),
    ) -> Steps[Session]:
        """Binds.

        Args:
            native: the module arap_native.
            mesh: at rest.
            stretch: (3, 3) symmetric factor of the polar decomposition of matrix_world; see transforms.stretch_of().
            settings: see SessionSettings.
            stiffness: (n,) 1e-12 to 1e12, or None.
            rigid_regions: (n,) int32 region of each vertex, negative for none, or None.
            mirrors: planes that complete the mesh, see mirror.used_mirrors().

        Raises:
            ValueError: the mesh cannot be used; the message says where.
        """
        session = cls(native, mesh, stretch, settings, mirrors)
        whole = session._whole
        if whole is not None:
            mesh = whole.mesh
            stiffness = None if stiffness is None else stiffness[whole.sources]
            rigid_regions = whole.regions(rigid_regions)
        start = time.perf_counter()
        seen = replace(mesh, rest_positions=session._surface.seen)
        job = models.begin_bind(native, models.ModelInput(seen, settings, stiffness, rigid_regions))
        session._model = yield from stage(job, "Binding was cancelled; nothing has changed")
        parts = session._model.part_of_vertex
        session._own_parts = np.unique(parts[: session.n_vertices])
        if settings.use_loose_parts and session._model.n_parts > 1:
            images = () if whole is None else whole.permutations()
            session._loose = LooseParts(session._surface, parts, rigid_regions, images)
            session._solved = np.empty_like(session._positions)  # the solver does not know where they go
        session._bind_ms = _ms_since(start)
        return session

    def __init__(
        self, native: Any, mesh: SessionMesh, stretch: Floats, settings: SessionSettings, mirrors: Sequence[Mirror]
    ) -> None:
        """Prepares it, for bind()."""
        self._native = native
        self._space = SolverSpace(stretch)
        self._n_own = len(mesh.rest_positions)
        self._mirrors = tuple(mirrors)
        mesh, self._whole = completed(mesh, mirrors, self._space.stretch)
        self._rest = np.ascontiguousarray(mesh.rest_positions, dtype=np.float64)
        self._settings = settings
        self._map: HandleMap | None = None
        self._specs: tuple[HandleSpec, ...] = ()
        self._held: Sequence[HandleSpec] = ()  # of the whole
        self._copies: Sequence[Copy] = ()
        self._point_patches: Patches = NO_PATCHES
        self._outside: tuple[str, ...] = ()
        self._at_rest: Ints = np.empty(0, dtype=np.int32)  # own parts, in the last solve
        self._positions = self._rest.astype(np.float32)
        self._own_positions = self._positions[: self._n_own]
        # The solver writes single precision into memory that is there already: a frame allocates nothing.
        self._solved = np.empty_like(self._positions) if self._space.is_stretched else self._positions
        self._model: models.Model
        self._own_parts: Ints  # the others are images
        self._loose: LooseParts | None = None
        self._bind_ms = 0.0
        self._factor_ms = 0.0

        seen = self._space.to_solver(self._rest)
        self._surface = Surface.of(seen, mesh.corner_vertices, mesh.face_sizes, settings.rigidity_radius)
        self._diagonal = surface_diagonal(seen, mesh.corner_vertices)

    @property
    def n_vertices(self) -> int:
        return self._n_own

    @property
    def stretch(self) -> Floats:
        """(3, 3) float64."""
        return self._space.stretch

    @property
    def mirrors(self) -> tuple[Mirror, ...]:
        """The planes that complete the mesh."""
        return self._mirrors

    @property
    def settings(self) -> SessionSettings:
        return self._settings

    @settings.setter
    def settings(self, settings: SessionSettings) -> None:
        if settings != self._settings and settings.of_bind != self._settings.of_bind:
            raise ValueError(f"{OF_BIND} are fixed at bind: make a new session")
        self._settings = settings

    @property
    def positions(self) -> NDArray[np.float32]:
        """(n, 3) float32, contiguous, object space: where the mesh is now. Written over by the next update."""
        return self._own_positions

    @property
    def at_rest(self) -> tuple[Ints, int]:
        """The own vertices of parts that the last solve left at rest, (k,) int32 ascending, and how many parts."""
        parts = self._model.part_of_vertex[: self._n_own]
        return np.flatnonzero(np.isin(parts, self._at_rest)).astype(np.int32), len(self._at_rest)

    @property
    def n_factorizations(self) -> int:
        """Numeric factorizations since the bind."""
        return self._model.n_factorizations

    @property
    def patches(self) -> Patches:
        """What the point handles hold; of a completed mesh see mirror.MirroredMesh.specs()."""
        return self._point_patches

    @property
    def has_inside(self) -> bool:
        """False if it is a solid of a mesh without an inside."""
        return self._solid is None or self._solid.has_inside

    @cached_property
    def n_sheets(self) -> int:
        """Own parts of a solid that have no inside, so they are posed as surfaces. Panels ask at each redraw."""
        return 0 if self._solid is None else int(np.isin(self._own_parts, self._solid.sheets).sum())

    @property
    def _solid(self) -> arap_native.LatticeArap | None:
        return models.solid_of(self._native, self._model)

    def cube_edges(self) -> Float32s:
        """(2 e, 3) float32 ends of the edges of a solid's cubes where they are now, object space; none of a surface.

        Raises:
            RuntimeError: the solver is at work.
        """
        if self._solid is None:
            return np.empty((0, 3), dtype=np.float32)
        corners = (self._solid.cube_corners() @ self._space.unstretch.T).reshape(-1, 8, 3)
        return np.ascontiguousarray(corners[:, CUBE_EDGES].reshape(-1, 3), np.float32)

    def set_handles(self, specs: Sequence[HandleSpec], shown: NDArray[np.floating] | None = None) -> Steps[None]:
        """Makes ``specs`` the handles; factorizes only if vertices or strengths have changed.

        Args:
            specs: the handles.
            shown: (n, 3) the pose that loose pieces go on from; None: rest.

        Raises:
            ValueError: a vertex out of range, or nothing is held or moved. RuntimeError. The former handles then stay,
                and also if the work is dropped.
        """
        if self._map is not None and _are_same(self._specs, specs):
            if not all(spec.has_base_of(former) for spec, former in zip(specs, self._specs, strict=True)):
                held, self._copies = self._completed(specs)
                self._held, _ = self._without_outside(specs, held, self._copies)
                self._point_patches = self._based(self._held, self._point_patches)
                self._map = HandleMap(self._held, self._rest, self._space.stretch, self._point_patches)
            self._specs = tuple(specs)
            self._start_loose(shown)
            return
        start = time.perf_counter()
        check_specs(specs, self.n_vertices)
        held, copies = self._completed(specs)
        held, outside = self._without_outside(specs, held, copies)
        patches = yield from part(self._patches_of(held), 0.0, PATCHES_SHARE)
        handle_map = HandleMap(held, self._rest, self._space.stretch, patches)
        job = self._model.begin_set_constraints(*handle_map.constraints)
        try:
            yield from part(self._stage(job, HANDLES_CANCELLED), PATCHES_SHARE, 1.0)
        except GeneratorExit:
            if self._map is not None:  # the job may have ended before it heard of that; else this does nothing
                self._model.set_constraints(*self._map.constraints)
            raise
        self._factor_ms = _ms_since(start)
        self._held, self._copies = held, copies
        self._map = handle_map
        self._outside = outside
        self._specs = tuple(specs)
        self._point_patches = patches
        self._start_loose(shown)

    def _start_loose(self, shown: NDArray[np.floating] | None) -> None:
        if self._loose is not None:
            self._loose.start_from(None if shown is None else self._space.to_solver(self._lifted(shown)))

    def _lifted(self, positions: NDArray[np.floating]) -> Floats:
        """(m, 3) of the whole."""
        return positions.astype(np.float64) if self._whole is None else self._whole.lifted(positions)

    def _without_outside(
        self, specs: Sequence[HandleSpec], held: Sequence[HandleSpec], copies: Sequence[Copy]
    ) -> tuple[Sequence[HandleSpec], tuple[str, ...]]:
        """What is held without the bones that pass through nothing, and the names of these.

        Args:
            specs: the handles.
            held, copies: of the whole, see _completed().

        Raises:
            ValueError: there is nothing else.
        """
        if all(spec.segment is None for spec in specs):
            return held, ()
        bones = [(i, spec.segment) for i, spec in enumerate(held) if spec.segment is not None]
        segments = np.array([segment.ends for _, segment in bones]).reshape(-1, 2, 3) @ self._space.stretch.T
        solid = self._solid
        outside = {bones[k][0] for k in (range(len(bones)) if solid is None else solid.segments_outside(segments))}
        left = [replace(spec, segment=None) if i in outside else spec for i, spec in enumerate(held)]
        handles = [copy.handle for copy in copies] or range(len(specs))
        inside = {handle for handle, spec in zip(handles, left, strict=True) if spec.segment is not None}
        names = tuple(s.name for i, s in enumerate(specs) if s.segment is not None and i not in inside)
        if not any(spec.segment is not None or len(spec.vertices) for spec in left):
            raise ValueError(
                f"No bone passes through the mesh ({listed(names)}): "
                "move the armature into it, then press Add Bones again"
            )
        return left, names

    def _completed(self, specs: Sequence[HandleSpec]) -> tuple[Sequence[HandleSpec], Sequence[Copy]]:
        """The handles of the whole."""
        return (specs, ()) if self._whole is None else self._whole.specs(specs)

    def _stage(self, job: arap_native.Job[Result], if_cancelled: str) -> Steps[Result]:
        """A job of the model as a stage. If the work is dropped, the model can be used at once."""
        try:
            return (yield from stage(job, if_cancelled))
        except GeneratorExit:
            job.wait()
            raise

    def _patches_of(self, specs: Sequence[HandleSpec]) -> Steps[Patches]:
        """``specs``: of the whole."""
        points = points_of(specs, self._surface) if self._settings.has_radius else []
        if not points:
            return NO_PATCHES
        groups = [point.vertices for point in points]
        job = begin_patches(self._model, groups, [point.reach / self._diagonal for point in points])
        found = patches_from((yield from self._stage(job, HANDLES_CANCELLED)), groups, self._space.unstretch)
        patches: dict[int, list[Patch]] = {}
        for point, patch in zip(points, found, strict=True):
            if patch is not None:
                patches.setdefault(point.handle, []).append(patch)
        of_points = {i: [patch.sources for patch in of_handle] for i, of_handle in patches.items()}
        is_held = held_by_themselves(specs, of_points, len(self._rest))
        left = {i: [without(patch, is_held) for patch in of_handle] for i, of_handle in patches.items()}
        kept = {i: [patch for patch in of_handle if patch is not None] for i, of_handle in left.items()}
        return self._based(specs, {i: of_handle for i, of_handle in kept.items() if of_handle})

    def _based(self, specs: Sequence[HandleSpec], patches: Patches) -> Patches:
        """The patches with their centres while no handle has moved. ``specs``: of the whole."""
        result = {}
        for i, of_handle in patches.items():
            base = specs[i].base_or(self._rest)
            result[i] = [replace(p, centre=p.weights @ base[p.vertices].astype(np.float64)) for p in of_handle]
        return result

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
    ) -> SolveStats:
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

    def updating(self, matrices: Floats, *, initial_guess: str, to_convergence: bool) -> Steps[SolveStats]:
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
        if self._whole is not None:
            matrices = self._whole.matrices(checked_matrices(matrices, self._specs), self._copies)
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

    def _take(self, result: arap_native.SolveResult, start: float) -> SolveStats:
        """Shows the result of a solve that began at ``start``."""
        assert self._map is not None
        if result.stop_reason == "cancelled":
            raise Cancelled(SOLVE_CANCELLED)
        at_rest = self._own_parts[np.isin(self._own_parts, result.parts_at_rest)]
        if self._loose is not None:
            at_rest = np.setdiff1d(at_rest, self._loose.move(self._solved, result.parts_at_rest))
        self._at_rest = at_rest
        self._show_solved()
        n = self._n_own
        return SolveStats(
            vertices=n,
            free_vertices=n - int((self._map.vertices < n).sum()),
            last_ms=_ms_since(start),
            iterations=result.iterations,
            energy=result.energy_after,
            energy_before=result.energy_before,
            step=result.step,
            stop_reason=result.stop_reason,
            parts_at_rest=len(at_rest),
            loose_vertices=int((result.loose_vertices < n).sum()),
            outside=self._outside,
            bind_ms=self._bind_ms,
            factor_ms=self._factor_ms,
        )

    def set_positions(self, positions: NDArray[np.floating]) -> None:
        """Goes on from ``positions``, (n, 3), object space.

        Raises:
            ValueError: wrong shape or not finite; the mesh stays where it was.
        """
        if positions.shape != (self.n_vertices, 3):
            raise ValueError(f"positions have shape {positions.shape}, expected {(self.n_vertices, 3)}")
        lifted = self._lifted(positions)
        self._model.set_positions(self._space.to_solver(lifted))
        self._positions[...] = lifted

    def reset(self) -> None:
        """Back to rest; the handles stay."""
        self._model.reset()
        self._positions[...] = self._rest

    def _show_solved(self) -> None:
        if self._solved is self._positions:
            return
        try:
            self._space.show(self._solved, self._positions)
        except RuntimeError:
            self._model.set_positions(self._space.to_solver(self._positions.astype(np.float64)))
            raise


def _are_same(former: Sequence[HandleSpec], specs: Sequence[HandleSpec]) -> bool:
    return len(former) == len(specs) and all(a.is_same_as(b) for a, b in zip(former, specs, strict=True))


def _ms_since(start: float) -> float:
    return 1e3 * (time.perf_counter() - start)
