# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds attached objects to their hosts, and tells whether a bind still fits."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix

from ..core import native
from ..core.arrays import Floats
from ..core.attach.probe import Probe, probed
from ..core.attach.surface import PreparedSurface
from ..core.attach.wrap import Wrap
from ..core.attach.wrap_input import WrapInput
from ..core.session_data import SessionMesh
from ..core.transforms import has_no_inverse, inverted
from ..props import preferences
from ..props.bounds import bounded
from ..scene import handle_motion, meshes
from ..scene.points import objects as points
from ..ui import waiting
from . import states
from .binding import Binding

if TYPE_CHECKING:
    from ..props.attach import ArapAttachment
    from .states import State

_read: dict[int, SessionMesh] | None = None
"""By the uids of hosts, see reading_once()."""
_prepared = PreparedSurface()
"""Of the binds that follow each other, see _drop_prepared()."""


def place_of(attachment: ArapAttachment) -> Floats:
    """(4, 4) from the space of the attached object to that of the host."""
    return np.array(attachment.place, dtype=np.float64).reshape(4, 4)


def read_input(host: bpy.types.Object, attachment: ArapAttachment) -> WrapInput:
    """Everything that a bind needs. Raises ValueError if the host or the place of the object cannot be used."""
    attached, place = attachment.object, place_of(attachment)
    if has_no_inverse(place):
        raise ValueError(f"The place of '{attached.name}' is lost: press Attach again")
    # As last evaluated: this may be called by a handler, in which an evaluation would call handlers again.
    depsgraph = meshes.drawn_depsgraph(bpy.context)
    mesh, stretch = _read_host(host), meshes.read_stretch(host, depsgraph)
    return WrapInput(
        name=attached.name,
        mesh=mesh,
        stretch=stretch,
        mirrors=meshes.read_mirrors(host, depsgraph, stretch, mesh.rest_positions),
        points=meshes.read_rest(attached),
        place=place,
        pieces=points.pieces(attached) if bounded(attachment, "kind") == "rigid" else None,
        # A stand-in is coarser than the meshes that it stands for: they have no distance from it, and no facets of it.
        keeps_distance=not host.arap.is_stand_in,
        threads=preferences.threads(),
    )


@contextmanager
def reading_once() -> Iterator[None]:
    """Every host is read and prepared once for all its attachments, while no rest shape changes."""
    global _read  # noqa: PLW0603 - of the block that is outermost
    if _read is not None:
        yield
        return
    _read = {}
    try:
        yield
    finally:
        _read = None
        _drop_prepared()


def _drop_prepared() -> None:
    """Unless more binds may follow at once."""
    if _read is None and not states.is_any_binding():
        _prepared.drop()


def _read_host(host: bpy.types.Object) -> SessionMesh:
    if host.data.is_editmode:
        raise ValueError(f"'{host.name}' is in Edit Mode: what is attached to it waits")
    if _read is None:
        return meshes.read_mesh(host)
    if host.session_uid not in _read:
        _read[host.session_uid] = meshes.read_mesh(host)
    return _read[host.session_uid]


def place_now(host: bpy.types.Object, attached: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Floats:
    """(4, 4) from the space of an object to that of the host. Raises ValueError if one has no inverse."""
    world = handle_motion.object_matrix(host, depsgraph)
    return np.asarray(inverted(world) @ handle_motion.object_matrix(attached, depsgraph))


def _probe(host: bpy.types.Object, attachment: ArapAttachment, place: Floats) -> Probe:
    own, surface = (meshes.read_rest_at(obj, probed(points.count(obj))) for obj in (attachment.object, host))
    return Probe(points=own, surface=surface, place=place)


def _take_applied_place(host: bpy.types.Object, attachment: ArapAttachment, wrap: Wrap) -> None:
    """After Object > Apply to the object or its host, the place is another one that says the same."""
    depsgraph = meshes.drawn_depsgraph(bpy.context)
    try:
        now = place_now(host, attachment.object, depsgraph)
    except ValueError:
        return
    if wrap.probe.is_applied(_probe(host, attachment, now)):
        attachment.set_place(Matrix(now))


def get(host: bpy.types.Object, attachment: ArapAttachment, *, may_check: bool = True) -> Wrap | None:
    """The bind of an attached object; None if there is none, or if it does not fit any more.

    ``may_check``: all arrays, if they may have changed. That takes milliseconds; without, the answer is None then.
    """
    uid = attachment.object.session_uid
    state = states.of(uid)
    wrap = state.wrap
    if wrap is None or (state.must_check and not may_check):
        return None
    fits = (wrap.n_points, wrap.n_vertices) == (points.count(attachment.object), points.count(host))
    if fits and not wrap.probe.is_same(_probe(host, attachment, place_of(attachment))):
        _take_applied_place(host, attachment, wrap)
        fits = False
    if fits and state.must_check:
        fits = wrap.is_of(read_input(host, attachment))
        state.must_check = False
    if not fits:
        unbind(uid)
        return None
    return wrap


def bound(host: bpy.types.Object, attachment: ArapAttachment) -> Wrap:
    """As get(), bound now if need be. Raises as read_input(), RuntimeError or MemoryError."""
    wrap, state = get(host, attachment), states.of(attachment.object.session_uid)
    if wrap is None and state.binding is not None:
        _finish(state)
        wrap = get(host, attachment)  # it may be of former arrays
    if wrap is None:
        begin(host, attachment)
        wrap = _finish(state)
    return wrap


def _finish(state: State) -> Wrap:
    """Waits for the bind that is under way."""
    assert state.binding is not None
    try:
        with waiting.at_mouse() as progress:
            state.wrap = state.binding.work.run(progress)
    finally:
        state.binding = None
        _drop_prepared()
    return state.wrap


def begin(host: bpy.types.Object, attachment: ArapAttachment) -> None:
    """Begins to bind in the background, unless that is under way. Raises as bound()."""
    state = states.of(attachment.object.session_uid)
    if state.binding is None:
        state.must_check = False
        steps = Wrap.bind(native.load(), read_input(host, attachment), _prepared)
        state.binding = Binding(attachment.object, steps)


def is_binding(uid: int) -> bool:
    """Whether a bind is under way. Goes on with it. Raises what it has raised."""
    state = states.of(uid)
    binding = state.binding
    if binding is None or binding.work.step():
        return binding is not None
    state.binding = None
    state.wrap = binding.work.result()
    return False


def unbind(uid: int) -> None:
    """A bind under way ends by itself."""
    state = states.of(uid)
    state.wrap, state.must_check = None, False
    stop_binding(uid)


def stop_binding(uid: int) -> None:
    state = states.of(uid)
    if state.binding is not None:
        state.binding.work.drop()
        state.binding = None
        _drop_prepared()
