# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Add and remove pins, handles and stiffness."""

from collections.abc import Callable
from typing import Any

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..core.arrays import Ints
from ..scene import meshes, ui_cache
from ..ui.checks import ArapOperator, arap_object, why_not_changeable, why_not_object_mode
from ..ui.edit_mode import OneStepOperator, is_edited
from .chosen import chosen, select_target
from .controls import remove_at
from .handle_copies import copy_handles
from .handles import add_handle, add_handles_for, following_first_handle
from .names import name_for
from .pins import add_pin, add_pin_group
from .stiffness import add_rigid, add_stiffness, add_stiffness_group, remove_stiffness

NOTHING_TO_MOVE = "Select vertices in Edit Mode (Tab), or empties or bones with the mesh"

Target = tuple[bpy.types.Object, str]  # the name of the bone is '' for a whole object


def selected_targets(context: bpy.types.Context, obj: bpy.types.Object) -> list[Target]:
    """The selected bones in Pose Mode, else the selected empties. Targets of the mesh's handles are left out."""
    if context.mode == "POSE":
        targets = [(bone.id_data, bone.name) for bone in context.selected_pose_bones]
    else:
        targets = [(other, "") for other in context.selected_objects if other.type == "EMPTY"]
    if not targets:
        return []
    taken = {(handle.target, handle.bone) for handle in obj.arap.handles}
    return [target for target in targets if target not in taken]


def why_nothing_to_pin(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must be in Edit Mode, or have vertex groups."""
    lack = "Select vertices in Edit Mode (Tab) to pin them"
    return why_not_changeable(context) or (
        "" if is_edited(arap_object(context)) or arap_object(context).vertex_groups else lack
    )


def why_nothing_to_move(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must be in Edit Mode, or empties or bones must be selected with it."""
    reason = why_not_changeable(context)
    if reason or is_edited(arap_object(context)) or selected_targets(context, arap_object(context)):
        return reason
    return why_not_object_mode(arap_object(context)) or NOTHING_TO_MOVE


def _why_none(items: str, lack: str) -> Callable[[bpy.types.Context], str]:
    """As why_not_changeable(). The list ``items`` of the mesh must have entries."""
    return lambda context: why_not_changeable(context) or ("" if getattr(arap_object(context).arap, items) else lack)


why_none_chosen = _why_none("controls", "Add a pin or a handle first: nothing holds or moves the mesh yet")


def why_own_handles(context: bpy.types.Context) -> str:
    """As why_not_changeable(). Handles must belong to another mesh, or be in no scene."""
    return why_not_changeable(context) or (
        ""
        if ui_cache.has_foreign_handles(arap_object(context))
        else "The handles belong to this mesh, and none was deleted: there is nothing to copy"
    )


class _Add(OneStepOperator):
    """Adds an entry to a list."""

    purpose: str  # for a message
    goes_back = True  # to Edit Mode
    name: Any

    def add_selected(self, obj: bpy.types.Object, add: Callable[..., object], **options: bool) -> None:
        """Of a mesh in Edit Mode. Raises ValueError if no vertices are selected."""
        vertices = meshes.selected_vertices(obj)
        if not len(vertices):
            raise ValueError(f"No vertices are selected: select the vertices to {self.purpose}")
        with self.one_step(obj, goes_back=self.goes_back):
            self.name = self.name or name_for(obj, vertices)
            add(obj, vertices, name=self.name, **options)


class ARAP_OT_pin_add(_Add, bpy.types.Operator):
    bl_idname = "arap.pin_add"
    bl_label = "Add Pin"
    bl_description = "Hold vertices where they are. In Edit Mode: the selected vertices. In other modes: a vertex group"
    purpose = "pin"
    why_not = staticmethod(why_nothing_to_pin)

    name: StringProperty(
        name="Name",
        description="Name of the new pin and its vertex group. Empty: by side and place",
        options={"SKIP_SAVE"},
    )
    vertex_group: StringProperty(
        name="Vertex Group", description="Group to pin. Not used in Edit Mode", options={"SKIP_SAVE"}
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = arap_object(context)
        if obj.mode == "EDIT" or self.vertex_group:
            return self.execute(context)
        if obj.vertex_groups.active is not None:
            self.vertex_group = obj.vertex_groups.active.name
        return set(context.window_manager.invoke_props_dialog(self))

    def draw(self, context: bpy.types.Context) -> None:
        obj = arap_object(context)
        if obj.mode == "EDIT":
            self.layout.prop(self, "name")
        else:
            self.layout.prop_search(self, "vertex_group", obj, "vertex_groups")

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        if obj.mode == "EDIT":
            self.add_selected(obj, add_pin)
        elif not self.vertex_group:
            raise ValueError("Choose the vertex group to pin, or select vertices in Edit Mode")
        else:
            with self.one_step(obj):
                add_pin_group(obj, self.vertex_group)


class ARAP_OT_handle_add(_Add, bpy.types.Operator):
    bl_idname = "arap.handle_add"
    bl_label = "Add Handle"
    bl_description = (
        "In Edit Mode: give the selected vertices a new empty. Move, rotate or scale it and the mesh follows. Else "
        "each selected empty (in Pose Mode: each selected bone) becomes a handle of the vertices around it"
    )
    purpose = "move"
    goes_back = False  # to take the handle in hand
    why_not = staticmethod(why_nothing_to_move)
    ends_itself = True

    name: StringProperty(
        name="Name",
        description="Name of the new handle and its empty. Empty: by side and place",
        options={"SKIP_SAVE"},
    )
    use_exact: BoolProperty(
        name="Exact",
        description="Hold every vertex, even if the handle is smaller than Rigidity. That pulls a spike",
    )
    radius: FloatProperty(
        name="Radius",
        description=(
            "Take the vertices within this distance of the empty or bone, in scene units. "
            "If there are none, or at 0: the nearest vertex"
        ),
        default=0.0,
        min=0.0,
        subtype="DISTANCE",
    )
    is_of_targets: BoolProperty(options={"HIDDEN", "SKIP_SAVE"}, description="It was not called in Edit Mode")

    def draw(self, _context: bpy.types.Context) -> None:
        for name in ("radius",) if self.is_of_targets else ("name", "use_exact"):
            self.layout.prop(self, name)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        self.is_of_targets = not is_edited(obj)
        with following_first_handle(obj):
            if self.is_of_targets:
                self._add_targets(context, obj)
            else:
                self.add_selected(obj, add_handle, use_exact=self.use_exact)
                select_target(context, obj.arap.controls[-1])

    def _add_targets(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        targets = selected_targets(context, obj)
        if not targets:
            raise ValueError(NOTHING_TO_MOVE)
        add_handles_for(obj, targets, radius=self.radius or None)


class ARAP_OT_handles_copy(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.handles_copy"
    bl_label = "Copy Handles"
    bl_description = (
        "Give this mesh handles of its own. A copy gets copies of those of the original, at the same places on it. "
        "Empties that were deleted come back"
    )
    why_not = staticmethod(why_own_handles)

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        copy_handles(obj)


class ARAP_OT_control_remove(OneStepOperator, bpy.types.Operator):
    bl_idname = "arap.control_remove"
    bl_label = "Remove Handle or Pin"
    bl_description = (
        "Remove the chosen pin, handle or bone, and its empty and vertex group if they were made for it. "
        "Its vertices are free"
    )
    why_not = staticmethod(why_none_chosen)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        if chosen(obj) is None:
            raise ValueError("Choose the pin, handle or bone to remove in the list")
        index = obj.arap.active_control_index
        with self.one_step(obj):
            remove_at(obj, index)
        if context.object is None:  # it was the empty
            context.view_layer.objects.active = obj


class ARAP_OT_stiffness_add(_Add, bpy.types.Operator):
    bl_idname = "arap.stiffness_add"
    bl_label = "Add Stiffness"
    bl_description = (
        "Make vertices stiffer than the rest. In Edit Mode: the selected vertices. "
        "In other modes: a vertex group, or a new one to paint"
    )
    purpose = "stiffen"

    name: StringProperty(
        name="Name",
        description="Name of the new entry and its vertex group. Empty: Stiff or Rigid",
        options={"SKIP_SAVE"},
    )
    vertex_group: StringProperty(
        name="Vertex Group",
        description="Group to stiffen. Empty: a new group to paint. Not used in Edit Mode",
        options={"SKIP_SAVE"},
    )
    use_rigid: BoolProperty(
        name="Rigid", description="The vertices keep their shape exactly, like a helmet", options={"SKIP_SAVE"}
    )
    use_single_body: BoolProperty(
        name="As One Piece",
        description="All vertices move as one piece, even if they are not connected: the shells of a helmet",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = arap_object(context)
        if obj.mode == "OBJECT" and obj.vertex_groups and not self.vertex_group:
            active = obj.vertex_groups.active
            if active is not None and active.name not in obj.arap.stiffness:
                self.vertex_group = active.name
            return set(context.window_manager.invoke_props_dialog(self))
        return self.execute(context)

    def draw(self, context: bpy.types.Context) -> None:
        obj = arap_object(context)
        if obj.mode != "EDIT":
            self.layout.prop_search(self, "vertex_group", obj, "vertex_groups")
        if not self.vertex_group:
            self.layout.prop(self, "name")
        self.layout.prop(self, "use_rigid")
        if self.use_rigid:
            self.layout.prop(self, "use_single_body")

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        self.name = self.name or ("Rigid" if self.use_rigid else "Stiff")
        if obj.mode == "EDIT":
            self.add_selected(obj, self._add)
            return
        meshes.check_mesh(obj)  # first, so a refusal leaves no unused group behind
        with self.one_step(obj):
            entry = add_stiffness_group(obj, self.vertex_group or obj.vertex_groups.new(name=self.name).name)
            stiffness = obj.arap.stiffness[entry]
            if not self.vertex_group:
                stiffness.has_made_group = True
            if self.use_rigid:
                stiffness.use_rigid, stiffness.use_single_body = True, self.use_single_body

    def _add(self, obj: bpy.types.Object, vertices: Ints, name: str) -> None:
        if self.use_rigid:
            add_rigid(obj, vertices, name, use_single_body=self.use_single_body)
        else:
            add_stiffness(obj, vertices, name)


class ARAP_OT_stiffness_remove(OneStepOperator, bpy.types.Operator):
    bl_idname = "arap.stiffness_remove"
    bl_label = "Remove Stiffness"
    bl_description = "Remove the chosen entry, so its group is as soft as the rest"
    why_not = staticmethod(_why_none("stiffness", "Add stiffness first: the list is empty"))

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        settings = obj.arap
        entry = settings.stiffness[min(settings.active_stiffness_index, len(settings.stiffness) - 1)]
        with self.one_step(obj):
            remove_stiffness(obj, entry.name)
