# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of attackers: each function makes a posed, live mesh hostile, from one thought of somebody who means harm.

They write past the bounds that Blender keeps for properties, as a file that was edited byte by byte would.
"""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np

NAN, INF = float("nan"), float("inf")
BIGGEST = 2**31 - 1


def raw(obj: bpy.types.Object) -> Any:
    """What is stored of ``obj.arap``, without its bounds and types."""
    stored = obj.bl_system_properties_get(do_create=True) if hasattr(obj, "bl_system_properties_get") else obj
    return stored["arap"]


def write(obj: bpy.types.Object, **values: object) -> None:
    """Values of any type."""
    stored = raw(obj)
    for name, value in values.items():
        if name in stored:
            del stored[name]
        stored[name] = value


def work_for_ever(obj: bpy.types.Object) -> None:
    """Solves that never end hold Blender."""
    write(obj, max_iterations=BIGGEST, iterations_per_update=BIGGEST, accuracy=0.0, rigidity=1e-9)


def numbers_that_are_none(obj: bpy.types.Object) -> None:
    """NaN and infinity spread to every vertex and every picture."""
    write(obj, accuracy=NAN, rigidity=NAN, handle_size=INF, max_iterations=-5, iterations_per_update=-1)
    overlay = obj.arap.overlay
    overlay.show_pins = overlay.show_handles = overlay.show_strain = overlay.show_cubes = True
    write(obj, model=1, cube_size=NAN, keep_volume=NAN)
    raw(obj)["overlay"]["strain_limit"] = NAN
    raw(obj)["controls"][-1]["group_radius"] = NAN


def choices_that_are_none(obj: bpy.types.Object) -> None:
    """Items that no list has, and entries that are not there."""
    write(obj, model=999, energy=999, weights=-7, initial_guess=55, chosen_control_index=BIGGEST)


def other_types(obj: bpy.types.Object) -> None:
    """Texts where numbers are read, numbers where lists are."""
    write(obj, max_iterations="x", accuracy="y", rigidity=[1, 2, 3], key_name=7, pull_pins=5, poses=1.0, overlay=4)


def a_singular_place(obj: bpy.types.Object) -> None:
    """A rest place that has no inverse, or whose inverse overflows."""
    obj.arap.handles[0].rest_matrix = [1e38] * 16


def a_handle_on_itself(obj: bpy.types.Object) -> None:
    """A circle: the mesh moves itself. And a name that could be code, or a line of a log."""
    handle = raw(obj)["controls"][-1]
    handle["target"], handle["bone"] = obj, 'x"]; import os #'
    handle["name"] = "{0.__class__}\n" * 100


def pull_pins_of_nonsense(obj: bpy.types.Object) -> None:
    """Text that is no list of vertices, vertices that are not there, and too much of it."""
    n = len(obj.data.vertices)
    out_of_range = [np.full(10, value, "<i4").tobytes() for value in (-5, BIGGEST)]
    texts = ["!!!", "A" * 3_000_000, *(base64.b64encode(data).decode() for data in (b"abc", *out_of_range))]
    for text in texts:
        pin = obj.arap.pull_pins.add()
        pin.vertices_text, pin.n_vertices = text, n
    pin = obj.arap.pull_pins.add()
    pin.vertices, pin.n_vertices = np.arange(5, dtype=np.int32), n
    for stored in raw(obj)["pull_pins"]:
        stored["reach"] = NAN


def followers_of_nonsense(obj: bpy.types.Object) -> None:
    """The mesh goes along with itself, an empty does, places are none, and the rest shapes are what may be removed."""
    for target in (obj, obj.arap.handles[0].target, None):
        attachment = obj.arap.attachments.add()
        attachment.object, attachment.place = target, [NAN] * 16
        raw(obj)["attachments"][-1]["kind"] = 77
    obj.arap.attached_to.host = obj
    for name in ("Basis", "ARAP"):
        twin = obj.arap.attached_to.linked_keys.add()
        twin.name = twin.key = name
    write(obj, active_attachment_index=-BIGGEST)


def thousands_of_poses(obj: bpy.types.Object) -> None:
    """Lists so long that each redraw takes seconds, with motions that are none."""
    for i in range(1500):
        pose = obj.arap.poses.add()
        pose["name"] = f"P{i % 10}"
        motion = pose.motions.add()
        motion.name, motion.handle_id, motion.motion = "Head", i, [NAN] * 16


def thousands_of_handles(obj: bpy.types.Object) -> None:
    """As above, with pins, handles, stiffness and keys."""
    for i in range(1500):
        pin = obj.arap.controls.add()
        pin["kind"], pin["name"], pin["vertex_group"] = 0, "Pin", f"No such group {i}"
        handle = obj.arap.controls.add()
        handle["name"], handle["vertex_group"], handle["has_made_target"] = "Head", "Head", True
        handle["kind"] = 1 + i % 3
        obj.arap.stiffness.add()["name"] = "Head"
        raw(obj)["stiffness"][-1]["factor"] = INF
        obj.arap.made_keys.add()["name"] = "Basis"


def the_rest_shape_as_the_pose(obj: bpy.types.Object) -> None:
    """The add-on writes over what is the artist's."""
    raw(obj)["key_name"] = "Basis"
    obj.arap.made_keys.add()["name"] = "Basis"


def code(obj: bpy.types.Object) -> None:
    """Something in our data is run: by a driver that Blender refuses, by a name, by a format."""
    text = bpy.data.texts.new("x.py")
    text.write("raise SystemExit")
    text.use_module = True
    obj.arap.handles[0].target.driver_add("location", 0).driver.expression = "__import__('os').abort()"
    obj.name = "{0} {} %s {x.__class__}"
    raw(obj)["key_name"] = "{0.__class__.__init__.__globals__}"


KINDS: tuple[Callable[[bpy.types.Object], None], ...] = (
    work_for_ever, numbers_that_are_none, choices_that_are_none, other_types, a_singular_place, a_handle_on_itself,
    pull_pins_of_nonsense, followers_of_nonsense, thousands_of_poses, thousands_of_handles,
    the_rest_shape_as_the_pose, code,
)  # fmt: skip
