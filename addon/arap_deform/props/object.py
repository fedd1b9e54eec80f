# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What is saved in the .blend: ``bpy.types.Object.arap``.

No ``from __future__ import annotations`` here: Blender reads the annotations themselves, not their text.
"""

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..core.naming import NAME_BYTES
from . import hooks
from .handles import ArapHandle, ArapPin
from .overlay import ArapOverlay
from .poses import CLASSES as POSE_CLASSES
from .poses import ArapStoredPose
from .pull import ArapPullPin, ArapPullSettings
from .stiffness import ArapStiffness

# The numbers are what is saved: they stay, whatever the order.
ENERGIES = (
    ("rotation_nodes", "Smooth", "Bends alike on coarse and dense meshes, as wide as Rigidity. The default", "NONE", 2),
    ("spokes_and_rims", "Spokes and Rims", "Classic: bends sharper the denser the mesh is", "NONE", 0),
    ("spokes", "Spokes", "The classic of 2007; a little stiffer across the bend", "NONE", 1),
)
WEIGHTS = (
    ("cotangent", "Cotangent", "Follows the shape of the surface, not how it is cut into faces. The default"),
    ("uniform", "Uniform", "Every edge counts the same; for meshes with very bad faces"),
)
INITIAL_GUESSES = (
    ("previous", "Previous Pose", "Goes on from the pose shown. The default while posing"),
    ("rest", "Rest", "Starts from the undeformed mesh every time"),
    ("naive_laplacian", "Smooth Blend", "Starts from a smooth blend of the handles that ignores rotation"),
    ("handle_rotations", "Handle Rotations", "Spreads the rotations of the handles over the mesh; for large turns"),
)
HANDLE_SHAPES = (
    ("SPHERE", "Sphere", ""),
    ("CUBE", "Cube", ""),
    ("CIRCLE", "Circle", ""),
    ("PLAIN_AXES", "Plain Axes", ""),
    ("ARROWS", "Arrows", ""),
    ("SINGLE_ARROW", "Single Arrow", ""),
    ("CONE", "Cone", ""),
)


def _on_display_changed(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.display_changed:
        changed(settings.id_data)


def _on_live_changed(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for toggled in hooks.live_toggled:
        toggled(settings.id_data)


def _choose(settings: bpy.types.PropertyGroup, items: Any, index: int, group: str) -> None:
    """Makes the vertex group of what is chosen in a list the active one: it is what Weight Paint shows and paints."""
    groups = settings.id_data.vertex_groups
    found = groups.find(getattr(items[index], group)) if index < len(items) else -1
    if found >= 0:
        groups.active_index = found


def _on_pin_chosen(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    _choose(settings, settings.pins, settings.active_pin_index, "name")


def _on_handle_chosen(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    _choose(settings, settings.handles, settings.active_handle_index, "vertex_group")


def _on_stiffness_chosen(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    _choose(settings, settings.stiffness, settings.active_stiffness_index, "name")


class ArapMadeKey(bpy.types.PropertyGroup):
    """A shape key that was made for the pose."""

    name: StringProperty(name="Name", description="Name of the shape key")


class ArapObject(bpy.types.PropertyGroup):
    """Pins, handles and settings of one mesh object."""

    pins: CollectionProperty(type=ArapPin, name="Pins", description="Vertex groups that stay at rest")
    active_pin_index: IntProperty(
        name="Active Pin", min=0, description="The pin chosen in the list", update=_on_pin_chosen
    )
    handles: CollectionProperty(type=ArapHandle, name="Handles", description="Objects and bones that move the mesh")
    active_handle_index: IntProperty(
        name="Active Handle", min=0, description="The handle chosen in the list", update=_on_handle_chosen
    )

    stiffness: CollectionProperty(
        type=ArapStiffness, name="Stiffness", description="Vertex groups that bend less, or not at all"
    )
    active_stiffness_index: IntProperty(
        name="Active Stiffness", min=0, description="The entry chosen in the list", update=_on_stiffness_chosen
    )
    poses: CollectionProperty(type=ArapStoredPose, name="Poses", description="Stored poses of the handles")
    active_pose_index: IntProperty(name="Active Pose", min=0, description="The pose chosen in the list")

    pull_pins: CollectionProperty(
        type=ArapPullPin, name="Pull Pins", description="What ARAP Pull holds", options={"HIDDEN"}
    )

    energy: EnumProperty(
        name="Energy",
        description="What turns as one piece: with Smooth pieces of one size, with the classics single vertices",
        items=ENERGIES,
        default="rotation_nodes",
    )
    rigidity: FloatProperty(
        name="Rigidity",
        description=(
            "Radius of what turns as one piece, in percent of the mesh's size (the diagonal of its box at rest): "
            "larger is stiffer, with wider bends and rounder hills"
        ),
        default=2.0,
        min=0.1,
        max=100.0,
        soft_min=0.5,
        soft_max=10.0,
        precision=1,
        step=10,
        subtype="PERCENTAGE",
    )
    weights: EnumProperty(name="Weights", description="How much each edge counts", items=WEIGHTS, default="cotangent")
    initial_guess: EnumProperty(
        name="Start From", description="Where each update starts", items=INITIAL_GUESSES, default="previous"
    )
    iterations_per_update: IntProperty(
        name="Iterations per Update",
        description="Steps at most after each change of a handle; fewer where a frame has no time for them",
        default=4,
        min=1,
        max=10000,
        soft_max=50,
    )
    max_iterations: IntProperty(
        name="Max Iterations",
        description="Steps at most when solving to the end, for one pose or one baked frame",
        default=1000,
        min=1,
        max=1000000,
        soft_max=10000,
    )
    accuracy: FloatProperty(
        name="Accuracy",
        description=(
            "Done when no vertex is further than this from where it would end; a fraction of the mesh's size "
            "(the diagonal of its box at rest)"
        ),
        default=1e-6,
        min=1e-9,
        max=0.1,
        soft_max=1e-2,
        precision=6,
    )
    join_seams: BoolProperty(
        name="Join Seams",
        description="Treat vertices at the same place as one, so that open seams stay closed",
        default=False,
    )
    key_name: StringProperty(
        name="Shape Key",
        description=(
            "Shape key that takes the pose. It is made if it is missing, and numbered if another key has the name. "
            "Empty: the name in the add-on's preferences"
        ),
        maxlen=NAME_BYTES,
    )
    made_keys: CollectionProperty(
        type=ArapMadeKey,
        name="Made Keys",
        description="Shape keys that were made for the pose, to tell them from others of that name",
        options={"HIDDEN"},
    )

    handle_shape: EnumProperty(
        name="Shape",
        description="How the handles' empties look",
        items=HANDLE_SHAPES,
        default="SPHERE",
        update=_on_display_changed,
    )
    handle_size: FloatProperty(
        name="Size",
        description="Size of the handles' empties; 1 is the size of the group they move",
        default=1.0,
        min=0.001,
        soft_min=0.1,
        soft_max=10.0,
        update=_on_display_changed,
    )
    handle_in_front: BoolProperty(
        name="In Front",
        description="Draw the handles' empties in front of the mesh",
        default=True,
        update=_on_display_changed,
    )
    handle_color: FloatVectorProperty(
        name="Color",
        description="Color of the handles' empties, seen where the wireframe color is set to Object",
        subtype="COLOR",
        size=4,
        default=(1.0, 0.55, 0.1, 1.0),
        min=0.0,
        max=1.0,
        update=_on_display_changed,
    )

    overlay: PointerProperty(type=ArapOverlay, name="Show", description="What is shown of the mesh in the 3D view")
    is_live: BoolProperty(
        name="Live",
        description=(
            "The mesh follows its handles all the time, without a posing act: also during playback, and after "
            "this file is loaded again. Not while rendering: bake the animation before"
        ),
        default=False,
        update=_on_live_changed,
    )
    live_problem: StringProperty(
        name="Live Problem", description="Why Live was switched off by itself", options={"HIDDEN"}
    )

    pose_act: IntProperty(
        options={"HIDDEN"}, description="Number of the posing act that this state of the scene is part of; 0: of none"
    )


CLASSES = (
    *POSE_CLASSES,
    ArapPin,
    ArapHandle,
    ArapStiffness,
    ArapMadeKey,
    ArapPullPin,
    ArapOverlay,
    ArapObject,
    ArapPullSettings,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.arap = PointerProperty(type=ArapObject, name="ARAP", description="As-rigid-as-possible posing")
    bpy.types.WindowManager.arap_pull = PointerProperty(type=ArapPullSettings, name="ARAP Pull")


def unregister() -> None:
    del bpy.types.WindowManager.arap_pull
    del bpy.types.Object.arap
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
