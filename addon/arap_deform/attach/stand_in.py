# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a stand-in of several meshes, and removes it."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable, Sequence

import bpy
import numpy as np
from mathutils import Matrix

from ..core.background import Progress
from ..core.job import STEP_S, run_job
from ..core.naming import listed
from ..core.stand_in.bridges import connected
from ..core.stand_in.fewer import simplified
from ..core.stand_in.shape import Shape, centre_of, joined
from ..scene import groups, known, meshes, versions
from ..scene.points import objects as points
from ..setup.controls import remove_control
from ..setup.made_objects import collection_for_made
from ..setup.pins import add_pin_group
from .attachments import attach, detach, detach_at
from .problems import owner_of
from .stand_in_parts import NAME, VERTICES, check, groups_of, is_posed, pieces_of, pins_of, read_shape

READ_SHARE = 0.4  # of the time
SIMPLIFIED_SHARE = 0.9


class StandInJob:
    """A Job that makes a stand-in, see make_stand_in(). It holds no Blender data."""

    noun = "stand-in"

    def __init__(self, objects: Iterable[bpy.types.Object], vertices: int = VERTICES) -> None:
        """Begins. Raises ValueError if the objects cannot be posed together."""
        chosen = list(dict.fromkeys(objects))
        pieces = pieces_of(chosen)
        check(pieces, vertices)
        self.left = [obj.name for obj in chosen if obj not in pieces]
        """Names of the objects that are attached to another one of them, and stay so."""
        self.uid = known.add(pieces[0])
        self.object_name: str = pieces[0].name  # for messages
        self._names = {known.add(piece): piece.name for piece in pieces}
        self._vertices = vertices
        self._groups = groups_of(pieces)
        self._posed: list[str] = []
        self._fraction = 0.0
        self._shape: Shape | None = None
        self._work = self._steps()

    @property
    def warning(self) -> str:
        """That meshes have poses of their own, '' if none has."""
        if not self._posed:
            return ""
        return (
            f"The stand-in is at rest, and its pose is added to the poses of {listed(self._posed)}: press Reset "
            "for each of them"
        )

    @property
    def fraction(self) -> float:
        return self._fraction

    @property
    def stage_fraction(self) -> float:
        return self._fraction

    @property
    def status(self) -> str:
        return f"a stand-in of {len(self._names)} meshes, {self._fraction:.0%}"

    def step(self, time_limit_s: float = STEP_S) -> bool:
        end = time.monotonic() + time_limit_s
        while self._shape is None:
            next(self._work, None)
            if time.monotonic() >= end:
                break
        return self._shape is None

    def finish(self) -> bpy.types.Object:
        """Makes the object. Raises as attach(), or RuntimeError if a mesh is gone."""
        assert self._shape is not None
        pieces = self._pieces()
        stand_in = _new_object(self._shape, collection_for_made(pieces[0]))
        try:
            _write_groups(stand_in, self._groups, self._shape)
            for name in pins_of(pieces):
                add_pin_group(stand_in, name)
            attach(stand_in, pieces, "bend", may_wait=True)
        except BaseException:
            _delete(stand_in)
            raise
        return stand_in

    def cancel(self) -> None:
        self._work.close()

    def _pieces(self) -> list[bpy.types.Object]:
        """The meshes. Raises RuntimeError if one is gone."""
        pieces = []
        for uid, name in self._names.items():
            piece = known.find(uid)
            if piece is None:
                raise RuntimeError(f"'{name}' is gone: the stand-in was not made")
            pieces.append(piece)
        return pieces

    def _steps(self) -> Generator[None, None, None]:
        shapes = []
        for index in range(len(self._names)):
            piece = self._pieces()[index]
            shapes.append(read_shape(piece, self._groups))
            if is_posed(piece):
                self._posed.append(piece.name)
            self._fraction = READ_SHARE * len(shapes) / len(self._names)
            yield
        shape = joined(shapes)
        del shapes
        yield
        if not len(shape.triangles):
            raise ValueError("None of the meshes has a face: there is nothing to deform")
        if not shape.size > 0.0:
            raise ValueError("The meshes have no size: move their vertices apart")
        shape = yield from self._slowly(simplified(shape, self._vertices), SIMPLIFIED_SHARE)
        if not len(shape.triangles):
            raise ValueError(f"With {self._vertices:,} vertices no face is left of these meshes: raise Vertices")
        self._shape = yield from self._slowly(connected(shape, self._vertices), 1.0)

    def _slowly(self, work: Generator[None, None, Shape], end: float) -> Generator[None, None, Shape]:
        """Does the work. It is not known how many steps it takes, so the fraction only comes nearer to its end."""
        while True:
            try:
                next(work)
            except StopIteration as stop:
                self._fraction = end
                return stop.value  # type: ignore[no-any-return]
            self._fraction += 0.2 * (end - self._fraction)
            yield


def make_stand_in(
    objects: Iterable[bpy.types.Object], vertices: int = VERTICES, progress: Progress | None = None
) -> bpy.types.Object:
    """Makes several meshes one to pose: a stand-in, to which they are attached.

    The stand-in is a mesh of all of them at rest, where they are now, connected where they are near each other. It is a
    Solid, drawn as a box and not rendered. Pose it as any mesh: pins, handles, bakes. Each of the others gets the shape
    keys, see attach(). Vertex groups of the same name are one in it, and what is pinned in them stays pinned.

    Args:
        objects: what is attached to another one of them stays attached to that.
        vertices: of the stand-in at most, but for some at the seams. If the meshes have more, those of it are fewer,
            and the meshes follow as clothes do. One mesh is enough if it has more.

    Returns:
        The stand-in.

    Raises:
        ValueError: the meshes cannot be posed together. Cancelled.
    """
    return run_job(StandInJob(objects, vertices), progress)


def remove_stand_in(stand_in: bpy.types.Object) -> None:
    """Removes a stand-in with its handles. The meshes go back to rest, without the shape keys made for it.

    Its children stay where they are.

    Raises:
        ValueError: it is none, or a mesh is in Edit Mode.
    """
    if not stand_in.arap.is_stand_in:
        raise ValueError(f"'{stand_in.name}' is no stand-in: choose one that Make Stand-in has made")
    meshes.check_local(stand_in)
    for attachment in stand_in.arap.attachments:
        if (
            attachment.object is not None
            and points.has_points(attachment.object)
            and attachment.object.data.is_editmode
        ):
            raise ValueError(f"'{attachment.object.name}' is in Edit Mode: go back to Object Mode first")
    host = owner_of(stand_in)
    if host is not None:
        detach(host, stand_in)
    for index in reversed(range(len(stand_in.arap.attachments))):
        detach_at(stand_in, index)
    for name in [control.name for control in stand_in.arap.controls]:
        remove_control(stand_in, name)
    _release_children(stand_in)
    _delete(stand_in)


def stand_in_of(obj: bpy.types.Object) -> bpy.types.Object | None:
    """The object if it is a stand-in, else its host if that is one, maybe deleted; None if there is none."""
    return next((each for each in (obj, owner_of(obj)) if each is not None and each.arap.is_stand_in), None)


def _release_children(stand_in: bpy.types.Object) -> None:
    """They stay where they are: without their parent they would go to where they were when they got it."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    places = [(child, meshes.read_matrix(child, depsgraph)) for child in stand_in.children]
    for child, place in places:
        child.parent = None
        child.matrix_world = Matrix(place)


def _delete(stand_in: bpy.types.Object) -> None:
    mesh = stand_in.data
    bpy.data.objects.remove(stand_in)
    if not mesh.users:
        bpy.data.meshes.remove(mesh)


def _new_object(shape: Shape, collection: bpy.types.Collection) -> bpy.types.Object:
    # Far from its origin coordinates of single precision have few digits. Mirror X of Pull is about the origin.
    centre = centre_of(shape)
    points = np.ascontiguousarray(shape.points - centre, dtype=np.float32)
    mesh = versions.new_mesh(NAME, points, shape.triangles.astype(np.int32))
    stand_in = bpy.data.objects.new(NAME, mesh)
    stand_in.location = centre
    stand_in.display_type = "BOUNDS"
    stand_in.hide_render = True
    stand_in.arap.model = "solid"
    stand_in.arap.is_stand_in = True
    collection.objects.link(stand_in)
    bpy.context.view_layer.update()
    return stand_in


def _write_groups(stand_in: bpy.types.Object, names: Sequence[str], shape: Shape) -> None:
    for name, weights in zip(names, shape.weights, strict=True):
        stand_in.vertex_groups.new(name=name)
        vertices = np.flatnonzero(weights).astype(np.int32)
        groups.write(stand_in, name, vertices, weights[vertices].astype(np.float64))
