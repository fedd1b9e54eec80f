# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The settings saved in the .blend: ``bpy.types.Object.arap``.

No ``from __future__ import annotations`` in this folder: Blender reads the annotations themselves, not their text.
"""

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

from ..core.attach.probe import MOST
from ..core.naming import NAME_BYTES
from . import hooks
from .attach import ArapAttachedTo, ArapAttachment
from .controls import ArapControl, ArapStiffness
from .poses import ArapStoredPose
from .pull import ArapPullPin, ArapPullRest

# Files store the numbers, so an item keeps its number.
ENERGIES = (
    ("rotation_nodes", "Even", "Bends look the same on coarse and dense meshes, as wide as Rigidity", "NONE", 2),
    ("spokes_and_rims", "Spokes and Rims", "Classic: the denser the mesh, the sharper the bends", "NONE", 0),
    ("spokes", "Spokes", "The classic of 2007. A little stiffer across the bend", "NONE", 1),
)
MODELS = (
    ("surface", "Surface", "The mesh is a skin with nothing inside. For clothes, sheets and fine detail", "NONE", 0),
    (
        "solid",
        "Solid",
        (
            "The mesh has an inside, so limbs that twist or bend keep their volume. Holes do no harm. "
            "Parts without an inside, as clothes, stay surfaces"
        ),
        "NONE",
        1,
    ),
)
WEIGHTS = (
    ("cotangent", "Cotangent", "Edges count by the shape of their faces, so that their layout does not matter"),
    ("uniform", "Uniform", "Every edge counts the same. For meshes with very bad triangles"),
)
INITIAL_GUESSES = (
    ("previous", "Previous Pose", "The pose shown"),
    ("rest", "Rest", "The mesh at rest"),
    ("naive_laplacian", "Smooth Blend", "A smooth blend of the handles that ignores rotation"),
    ("handle_rotations", "Handle Rotations", "The rotations of the handles, spread over the mesh. For large rotations"),
)


def _on_display_changed(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.display_changed:
        changed(settings.id_data)


def _on_follow_changed(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for toggled in hooks.follow_toggled:
        toggled(settings.id_data)


def _on_overlay_changed(_settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.views_changed:
        changed()


def _activate_group(obj: bpy.types.Object, name: str) -> None:
    """Weight Paint shows and paints the active group."""
    found = obj.vertex_groups.find(name)
    if found >= 0:
        obj.vertex_groups.active_index = found


def _on_stiffness_chosen(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    if settings.active_stiffness_index < len(settings.stiffness):
        _activate_group(settings.id_data, settings.stiffness[settings.active_stiffness_index].name)


def _on_control_chosen(settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    if settings.chosen_control_index < len(settings.controls):
        _activate_group(settings.id_data, settings.controls[settings.chosen_control_index].vertex_group)


def _active_control(settings: bpy.types.PropertyGroup) -> int:
    """The one chosen last, unless something else is active in the view since then: then the one that this moves."""
    active = getattr(bpy.context, "object", None)
    if active is not None and active != settings.id_data and _name_of(active) != settings.active_when_chosen:
        bones = {"", _active_bone(active)}
        for index, control in enumerate(settings.controls):
            if control.target == active and control.bone in bones and control.kind != "pin":
                return index
    return int(settings.chosen_control_index)


def _active_bone(obj: bpy.types.Object) -> str:
    bone = obj.data.bones.active if obj.type == "ARMATURE" else None
    return "" if bone is None else str(bone.name)


def _name_of(active: bpy.types.Object) -> str:
    return f"{active.name_full}/{_active_bone(active)}"


def _choose_control(settings: bpy.types.PropertyGroup, index: int) -> None:
    settings.chosen_control_index = index
    if 0 <= index < len(settings.controls):
        for chosen in hooks.control_chosen:
            chosen(settings.id_data, settings.controls[index])
    active = getattr(bpy.context, "object", None)
    settings.active_when_chosen = "" if active is None else _name_of(active)


class ArapOverlay(bpy.types.PropertyGroup):
    """What is drawn over one mesh, while the panel shows that mesh."""

    show_pins: BoolProperty(
        name="Pins", description="Draw the pinned vertices", default=True, update=_on_overlay_changed
    )
    show_handles: BoolProperty(
        name="Handles",
        description="Draw a line from each handle's rest place to its place now",
        default=True,
        update=_on_overlay_changed,
    )
    show_strain: BoolProperty(
        name="Stretch",
        description="Color the mesh by the length of its edges: red is longer than at rest, blue is shorter",
        update=_on_overlay_changed,
    )
    show_cubes: BoolProperty(
        name="Cubes",
        description="Draw the cubes that carry a solid mesh, as its last solve has bent them",
        update=_on_overlay_changed,
    )
    strain_limit: FloatProperty(
        name="Full Color At",
        description="Stretch of the full color, in percent of the length at rest",
        default=20.0,
        min=0.1,
        max=1000.0,
        soft_min=1.0,
        soft_max=100.0,
        precision=1,
        subtype="PERCENTAGE",
        update=_on_overlay_changed,
    )


class ArapMadeKey(bpy.types.PropertyGroup):
    """A shape key that the add-on made."""

    name: StringProperty(name="Name", description="Name of the shape key")


class ArapFormerBake(bpy.types.PropertyGroup):
    """A bake before the last one, with another prefix: its keys are still there, muted."""

    name: StringProperty(name="Prefix", description="The names of its shape keys begin so")


class ArapObject(bpy.types.PropertyGroup):
    """Pins, handles and settings of one mesh object."""

    controls: CollectionProperty(
        type=ArapControl, name="Handles and Pins", description="What holds or moves the mesh: pins, handles and bones"
    )
    active_control_index: IntProperty(
        name="Handle or Pin",
        description="A click selects the handle in the view. A handle selected in the view is the one shown here",
        get=_active_control,
        set=_choose_control,
        options=set(),
    )
    chosen_control_index: IntProperty(
        min=0,
        options={"HIDDEN"},
        description="The control that was chosen last in the list",
        update=_on_control_chosen,
    )
    active_when_chosen: StringProperty(
        options={"HIDDEN"}, description="Object and bone that were active after the last click on the list"
    )

    stiffness: CollectionProperty(
        type=ArapStiffness, name="Stiffness", description="Vertex groups that bend less, or not at all"
    )
    active_stiffness_index: IntProperty(
        name="Active Stiffness",
        min=0,
        description="The entry chosen in the list",
        update=_on_stiffness_chosen,
    )
    poses: CollectionProperty(type=ArapStoredPose, name="Poses", description="Stored poses of the handles")
    active_pose_index: IntProperty(name="Active Pose", min=0, description="The pose chosen in the list")

    attachments: CollectionProperty(
        type=ArapAttachment, name="Attachments", description="Objects that follow the mesh: clothes, hair, eyes"
    )
    active_attachment_index: IntProperty(
        name="Active Attachment", min=0, description="The attached object chosen in the list"
    )
    attached_to: PointerProperty(
        type=ArapAttachedTo, name="Attached To", description="What is known of the mesh that this one follows"
    )

    is_stand_in: BoolProperty(options={"HIDDEN"}, description="The mesh stands for others, which are attached to it")

    pull_pins: CollectionProperty(
        type=ArapPullPin, name="Pull Pins", description="Pieces that ARAP Pull holds", options={"HIDDEN"}
    )
    pull_rest: PointerProperty(
        type=ArapPullRest, name="Pull Rest", description="What the last drag held besides", options={"HIDDEN"}
    )

    model: EnumProperty(
        name="Model",
        description="What the mesh is made of. Handles, pins and the pose stay if this changes",
        items=MODELS,
        default="surface",
    )
    cube_size: FloatProperty(
        name="Cube Size",
        description=(
            "Size of the cubes that fill a solid, in percent of the mesh's size (the diagonal of its box at rest). "
            "Larger is stiffer and faster. 0: from the shape, four across a limb, 2 % at the most"
        ),
        default=0.0,
        min=0.0,
        max=100.0,
        soft_max=10.0,
        precision=1,
        step=10,
        subtype="PERCENTAGE",
    )
    keep_volume: FloatProperty(
        name="Keep Volume",
        description=(
            "How firmly each place inside a solid keeps its volume. 0: as the shape makes it. 1: limbs hardly get "
            "thinner, but a pose takes about twice the time"
        ),
        default=0.0,
        min=0.0,
        max=1.0,
        precision=2,
        subtype="FACTOR",
    )
    energy: EnumProperty(
        name="Bending",
        description="How bends look",
        items=ENERGIES,
        default="rotation_nodes",
    )
    rigidity: FloatProperty(
        name="Rigidity",
        description=(
            "Radius of the pieces that turn together, in percent of the mesh's size (the diagonal of its box at "
            "rest). More is stiffer: wider bends, rounder hills"
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
    weights: EnumProperty(
        name="Weights", description="How much each edge of the mesh counts", items=WEIGHTS, default="cotangent"
    )
    initial_guess: EnumProperty(
        name="Start From",
        description="The shape from which each update starts",
        items=INITIAL_GUESSES,
        default="previous",
    )
    iterations_per_update: IntProperty(
        name="Iterations per Update",
        description="Limit of iterations after each change of a handle. A time limit may stop earlier",
        default=4,
        min=1,
        max=10000,
        soft_max=50,
    )
    max_iterations: IntProperty(
        name="Max Iterations",
        description="Limit of iterations for Solve and for each baked frame",
        default=1000,
        min=1,
        max=1000000,
        soft_max=10000,
    )
    accuracy: FloatProperty(
        name="Accuracy",
        description=(
            "Stop when every vertex is within this distance of its final place. "
            "A fraction of the mesh's size (the diagonal of its box at rest)"
        ),
        default=1e-6,
        min=1e-9,
        max=0.1,
        soft_max=1e-2,
        precision=6,
    )
    use_weld: BoolProperty(
        name="Weld Seams",
        description="Vertices at the same place count as one, so open seams stay closed",
    )
    use_loose_parts: BoolProperty(
        name="Loose Pieces Follow",
        description=(
            "Separate pieces of the mesh without a pin or handle, such as eyes and buttons, move along with what they "
            "sit in and keep their shape. Pieces that are near nothing stay at rest"
        ),
        default=True,
    )
    key_name: StringProperty(
        name="Shape Key",
        description=(
            "Shape key that takes the pose. If another key has the name, the pose's key gets a number. "
            "Empty: the name in the add-on's preferences"
        ),
        maxlen=NAME_BYTES,
    )
    made_keys: CollectionProperty(
        type=ArapMadeKey,
        name="Made Keys",
        description="Shape keys that the add-on made for the pose, not the user",
        options={"HIDDEN"},
    )

    baked_poses: CollectionProperty(
        type=ArapMadeKey,
        name="Baked Poses",
        description="Shape keys that are copies of the pose",
        options={"HIDDEN"},
    )

    bake_prefix: StringProperty(
        options={"HIDDEN"}, description="The names of the last bake's shape keys begin so. Empty: there was none"
    )

    former_bakes: CollectionProperty(
        type=ArapFormerBake, name="Former Bakes", description="Bakes with other prefixes", options={"HIDDEN"}
    )

    handle_size: FloatProperty(
        name="Size",
        description="Size of the empties that were made for handles. 1 is the size of their vertex group",
        default=1.0,
        min=0.001,
        soft_min=0.1,
        soft_max=10.0,
        update=_on_display_changed,
    )
    overlay: PointerProperty(type=ArapOverlay, name="Display", description="What is drawn over the mesh in the 3D view")
    use_follow: BoolProperty(
        name="Follow",
        description=(
            "The mesh follows its handles all the time, also in playback. Saved with the file. "
            "Not while rendering: bake the animation first"
        ),
        update=_on_follow_changed,
    )
    last_matrix: FloatVectorProperty(
        size=16, options={"HIDDEN"}, description="Own matrix of the object when it was seen last; 4x4, row by row"
    )
    last_points: FloatVectorProperty(
        size=3 * MOST, options={"HIDDEN"}, description="A few vertices of the mesh at rest, then"
    )
    follow_error: StringProperty(
        name="Follow Problem", description="Why Follow switched itself off", options={"HIDDEN"}
    )

    interaction_number: IntProperty(
        options={"HIDDEN"}, description="Number of the interaction that this state of the scene belongs to; 0: none"
    )

    @property
    def pins(self) -> tuple[ArapControl, ...]:
        """The controls that stay where they are, in the order of the list."""
        return tuple(control for control in self.controls if control.kind == "pin")

    @property
    def handles(self) -> tuple[ArapControl, ...]:
        """The controls that an object or a bone moves, in the order of the list."""
        return tuple(control for control in self.controls if control.kind != "pin")

    def has_data(self) -> bool:
        """Whether there is anything that must be looked at when the scene changes."""
        lists = (self.controls, self.attachments, self.pull_pins)
        is_attached = self.attached_to.host is not None
        return any(map(len, lists)) or self.use_follow or is_attached or self.interaction_number != 0


def register() -> None:
    bpy.types.Object.arap = PointerProperty(type=ArapObject, name="ARAP", description="As-rigid-as-possible posing")


def unregister() -> None:
    del bpy.types.Object.arap
