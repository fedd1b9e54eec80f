# SPDX-License-Identifier: GPL-3.0-or-later
"""The bound followers by the uids of their objects, and what they are bound from."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix

from ..core import native
from ..core.arrays import Floats
from ..core.carry.probe import Probe, probed
from ..core.carry.surface import PreparedSurface
from ..core.carry.wrap import Wrap
from ..core.carry.wrap_input import WrapInput
from ..core.session_data import SessionMesh
from ..core.transforms import has_no_inverse, inverted
from ..props import preferences
from ..props.bounds import bounded
from ..scene import handle_motion, meshes
from ..scene.points import objects as points
from ..ui import waiting
from .binding import Binding

if TYPE_CHECKING:
    from ..props.carry import ArapFollower

_bound: dict[int, Wrap] = {}
_binding: dict[int, Binding] = {}
_suspect: set[int] = set()
"""Of those that are bound: a look at all arrays must tell whether they still fit."""

_read: dict[int, SessionMesh] | None = None
"""By the uids of bodies, see reading_once()."""
_prepared = PreparedSurface()
"""Of the binds that follow each other, see _let_go()."""


def place_of(follower: ArapFollower) -> Floats:
    """(4, 4) from the space of the follower to that of the body."""
    return np.array(follower.place, dtype=np.float64).reshape(4, 4)


def read_input(body: bpy.types.Object, follower: ArapFollower) -> WrapInput:
    """Everything that a bind needs. Raises ValueError if the body or the place of the follower cannot be used."""
    target, place = follower.target, place_of(follower)
    if has_no_inverse(place):
        raise ValueError(f"The place of '{target.name}' is lost: press Carry Along again")
    # As last evaluated: this may be called by a handler, in which an evaluation would call handlers again.
    depsgraph = meshes.drawn_depsgraph(bpy.context)
    mesh, stretch = _read_body(body), meshes.read_stretch(body, depsgraph)
    return WrapInput(
        name=target.name,
        mesh=mesh,
        stretch=stretch,
        mirrors=meshes.read_mirrors(body, depsgraph, stretch, mesh.rest_positions),
        points=meshes.read_rest(target),
        place=place,
        pieces=points.pieces(target) if bounded(follower, "kind") == "rigid" else None,
        # A stand-in is coarser than the meshes that it stands for: they have no distance from it, and no facets of it.
        keeps_distance=not body.arap.is_stand_in,
        threads=preferences.threads(),
    )


@contextmanager
def reading_once() -> Iterator[None]:
    """Every body is read and prepared once for all its followers, while no rest shape changes."""
    global _read  # noqa: PLW0603 - of the block that is outermost
    if _read is not None:
        yield
        return
    _read = {}
    try:
        yield
    finally:
        _read = None
        _let_go()


def _let_go() -> None:
    """Of the prepared surface, unless more binds may follow at once."""
    if _read is None and not _binding:
        _prepared.drop()


def _read_body(body: bpy.types.Object) -> SessionMesh:
    if body.data.is_editmode:
        raise ValueError(f"'{body.name}' is in Edit Mode: what goes along with it waits")
    if _read is None:
        return meshes.read_mesh(body)
    if body.session_uid not in _read:
        _read[body.session_uid] = meshes.read_mesh(body)
    return _read[body.session_uid]


def place_now(body: bpy.types.Object, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Floats:
    """(4, 4) from the space of an object to that of the body. Raises ValueError if one has no inverse."""
    world = handle_motion.object_matrix(body, depsgraph)
    return np.asarray(inverted(world) @ handle_motion.object_matrix(target, depsgraph))


def _probe(body: bpy.types.Object, follower: ArapFollower, place: Floats) -> Probe:
    own, surface = (meshes.read_rest_at(obj, probed(points.count(obj))) for obj in (follower.target, body))
    return Probe(points=own, surface=surface, place=place)


def _take_applied_place(body: bpy.types.Object, follower: ArapFollower, wrap: Wrap) -> None:
    """After Object > Apply to the follower or the body, the place is another one that says the same."""
    depsgraph = meshes.drawn_depsgraph(bpy.context)
    try:
        now = place_now(body, follower.target, depsgraph)
    except ValueError:
        return
    if wrap.probe.is_applied(_probe(body, follower, now)):
        follower.set_place(Matrix(now))


def get(body: bpy.types.Object, follower: ArapFollower, *, may_look: bool = True) -> Wrap | None:
    """The wrap of a follower, None if it is not bound, or if that does not fit any more.

    ``may_look``: at all arrays, if they may have changed. It takes milliseconds; without, the answer is None then.
    """
    uid = follower.target.session_uid
    wrap = _bound.get(uid)
    if wrap is None or (uid in _suspect and not may_look):
        return None
    fits = (wrap.n_points, wrap.n_vertices) == (points.count(follower.target), points.count(body))
    if fits and not wrap.probe.is_same(_probe(body, follower, place_of(follower))):
        _take_applied_place(body, follower, wrap)
        fits = False
    if fits and uid in _suspect:
        fits = wrap.is_of(read_input(body, follower))
        _suspect.discard(uid)
    if not fits:
        forget(uid)
        return None
    return wrap


def bound(body: bpy.types.Object, follower: ArapFollower) -> Wrap:
    """As get(), bound now if need be. Raises as read_input(), RuntimeError or MemoryError."""
    wrap, uid = get(body, follower), follower.target.session_uid
    if wrap is None and uid in _binding:
        _end_binding(uid)
        wrap = get(body, follower)  # it may be of former arrays
    if wrap is None:
        begin(body, follower)
        wrap = _end_binding(uid)
    return wrap


def _end_binding(uid: int) -> Wrap:
    try:
        with waiting.at_mouse() as progress:
            wrap = _binding[uid].work.run(progress)
    finally:
        _binding.pop(uid, None)
        _let_go()
    _bound[uid] = wrap
    return wrap


def begin(body: bpy.types.Object, follower: ArapFollower) -> None:
    """Begins to bind in the background, unless that is under way. Raises as bound()."""
    uid = follower.target.session_uid
    if uid not in _binding:
        _suspect.discard(uid)
        _binding[uid] = Binding(follower.target, Wrap.bind(native.load(), read_input(body, follower), _prepared))


def is_binding(uid: int) -> bool:
    """Whether a bind of the follower is under way. Goes on with it. Raises what it has raised."""
    binding = _binding.get(uid)
    if binding is None or binding.work.step():
        return binding is not None
    del _binding[uid]
    _bound[uid] = binding.work.result()
    return False


def suspect(uid: int) -> None:
    """The arrays that the follower was bound from may have changed."""
    _suspect.add(uid)


def has_stretch(uid: int, stretch: Floats) -> bool:
    """Whether the follower is not bound, or under this stretch of its body."""
    return uid not in _bound or _bound[uid].has_stretch(stretch)


def suspect_all() -> None:
    _suspect.update(_bound)


def is_any_binding() -> bool:
    """Whether some bind is under way."""
    return bool(_binding)


def is_bound(uid: int) -> bool:
    return uid in _bound


def uids() -> list[int]:
    """Of the followers that are bound."""
    return list(_bound)


def forget(uid: int) -> None:
    """The follower is not bound any more. A bind under way ends by itself."""
    _bound.pop(uid, None)
    _suspect.discard(uid)
    stop_binding(uid)


def stop_binding(uid: int) -> None:
    if uid in _binding:
        _binding.pop(uid).work.drop()
        _let_go()


def clear() -> None:
    for uid in {*_bound, *_binding}:
        forget(uid)
