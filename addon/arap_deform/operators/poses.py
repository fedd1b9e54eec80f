# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Stored poses: storing, applying, blending, mirroring, deleting them, and making shape keys of them."""

from collections.abc import Callable

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from .. import api, redraw, sessions
from ..api_result import capture_transforms, restore_transforms
from ..texts import iface_, rpt_
from .blend_run import BlendRun
from .common import (
    StatusBar,
    allow,
    find_posed_object,
    posed_object,
    reports_errors,
    why_busy,
    why_no_mesh,
    why_not_solvable,
)
from .job import ShapesJobOperator
from .pose_act import PoseAct
from .solve import solve_with_progress, unsettled_text

STARTS = (
    ("NOW", "Handles Now", "From where the handles are"),
    ("REST", "Rest", "From the handles at rest"),
    ("POSE", "Stored Pose", "From another stored pose"),
)
AXES = (
    ("X", "X", "Left and right of the object's own plane X = 0"),
    ("Y", "Y", "In front of and behind the object's own plane Y = 0"),
    ("Z", "Z", "Above and below the object's own plane Z = 0"),
)


def why_not_storable(context: bpy.types.Context) -> str:
    """Why the handles cannot be stored: there must be some, and nobody may have the mesh but a posing act."""
    reason = why_no_mesh(context)
    obj = find_posed_object(context)
    if reason or obj is None:
        return reason
    if obj.mode != "OBJECT":
        return "Go to Object Mode first (Tab)"
    if not obj.arap.handles:
        return "Add a handle first: a pose is where the handles are"
    return "" if _is_posed(obj) else why_busy(obj)


def why_no_stored_pose(context: bpy.types.Context) -> str:
    """As why_not_storable(), and there must be a stored pose."""
    reason = why_not_storable(context)
    obj = find_posed_object(context)
    if reason or obj is None:
        return reason
    return "" if obj.arap.poses else "Store a pose first"


def why_not_applicable(context: bpy.types.Context) -> str:
    """As why_no_stored_pose(), and the mesh must be able to follow."""
    reason = why_no_stored_pose(context)
    obj = find_posed_object(context)
    return reason if reason or obj is None or _is_followed(obj) else why_not_solvable(context)


def why_no_pose_keys(context: bpy.types.Context) -> str:
    """As why_no_stored_pose(), and the mesh must be idle and solvable."""
    return why_no_stored_pose(context) or why_not_solvable(context)


def _is_posed(obj: bpy.types.Object) -> bool:
    """Whether a posing act has the mesh; not a drag of its surface."""
    act = sessions.acts.get(obj.name)
    return isinstance(act, PoseAct) and not act.is_drag


def _is_followed(obj: bpy.types.Object) -> bool:
    """Whether the mesh follows its handles anyway: while it is posed, or live."""
    return _is_posed(obj) or bool(obj.arap.is_live)


def _active_name(context: bpy.types.Context) -> str:
    settings = posed_object(context).arap
    index = settings.active_pose_index
    return str(settings.poses[index].name) if 0 <= index < len(settings.poses) else ""


class PoseOperator:
    """To be mixed into operators that move the handles: the mesh comes after them, all or nothing."""

    report: Callable[[set[str], str], None]

    def place(self, context: bpy.types.Context, act: Callable[[bpy.types.Object], api.Placement]) -> set[str]:
        """Moves the handles by ``act`` and solves, where nothing else does."""
        obj = posed_object(context)
        before = capture_transforms(obj)
        try:
            placement = act(obj)
            unsettled = "" if _is_followed(obj) else unsettled_text(solve_with_progress(context, obj))
        except BaseException:
            restore_transforms(before)
            raise
        for text in (str(placement), unsettled):
            if text:
                self.report({"WARNING"}, text)
        redraw.tag_panels()
        return {"FINISHED"}


class ARAP_OT_poses_store(bpy.types.Operator):
    bl_idname = "arap.poses_store"
    bl_label = "Store ARAP Pose"
    bl_description = "Add where the handles are now to the object's poses"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the pose, numbered where another has it", default="Pose")
    is_replacing: BoolProperty(
        name="Replace",
        description="Store into the pose chosen in the list, in place of what it has",
        default=False,
        options={"HIDDEN", "SKIP_SAVE"},
    )

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        if properties.is_replacing:
            return "Store where the handles are now into the pose chosen in the list"
        return str(cls.bl_description)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_storable(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        name = _active_name(context) if self.is_replacing else self.name
        if self.is_replacing and not name:
            raise ValueError("There is no pose to store into: choose one in the list")
        pose = api.store_pose(posed_object(context), name, replace=self.is_replacing)
        n = len(pose.motions)
        text = rpt_("Stored pose '{}' of 1 handle") if n == 1 else rpt_("Stored pose '{}' of {} handles")
        self.report({"INFO"}, text.format(pose.name, n))
        return {"FINISHED"}


class ARAP_OT_poses_delete(bpy.types.Operator):
    bl_idname = "arap.poses_delete"
    bl_label = "Delete ARAP Pose"
    bl_description = "Take the pose chosen in the list out of the library; handles, mesh and shape keys stay"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_stored_pose(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        api.delete_pose(posed_object(context), _active_name(context))
        return {"FINISHED"}


class ARAP_OT_poses_apply(PoseOperator, bpy.types.Operator):
    bl_idname = "arap.poses_apply"
    bl_label = "Apply Stored ARAP Pose"
    bl_description = "Move the handles to where they were in the pose, and the mesh after them"
    bl_options = {"REGISTER", "UNDO"}

    pose: StringProperty(
        name="Pose", description="The pose to apply; empty: the one chosen in the list", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_applicable(context))

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop_search(self, "pose", posed_object(context).arap, "poses")

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        self.pose = self.pose or _active_name(context)
        return self.place(context, lambda obj: api.apply_pose(obj, self.pose))


class ARAP_OT_poses_blend(PoseOperator, bpy.types.Operator):
    bl_idname = "arap.poses_blend"
    bl_label = "Blend ARAP Poses"
    bl_description = (
        "Move the handles to between two poses and solve: rotations turn the short way, and nothing is bent that need "
        "not be. Move the mouse to the right, then click; the panel that appears has the factor too"
    )
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR_X", "BLOCKING"}

    start: EnumProperty(name="From", description="The pose at factor 0", items=STARTS, default="NOW")
    start_pose: StringProperty(name="From Pose", description="The stored pose at factor 0", options={"SKIP_SAVE"})
    pose: StringProperty(
        name="To", description="The pose at factor 1; empty: the one chosen in the list", options={"SKIP_SAVE"}
    )
    factor: FloatProperty(
        name="Factor",
        description="How far from the first pose to the second: 0 is the first, 1 the second, beyond it goes on",
        default=0.5,
        min=-1.0,
        max=2.0,
        soft_min=0.0,
        soft_max=1.0,
        precision=3,
    )

    _run: BlendRun
    _status: StatusBar
    _is_confirmed: bool

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_applicable(context))

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = posed_object(context).arap
        layout.prop(self, "start")
        if self.start == "POSE":
            layout.prop_search(self, "start_pose", settings, "poses")
        layout.prop_search(self, "pose", settings, "poses")
        layout.prop(self, "factor", slider=True)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._choose(context)
        obj = posed_object(context)
        try:
            self._run = BlendRun(context, obj, self._blend, event.mouse_x, is_followed=_is_followed(obj))
        except (ValueError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._status = StatusBar()
        self._is_confirmed = False
        self.factor = 0.0
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        try:
            if event.type == "TIMER":
                if self._run.tick():
                    redraw.tag_views()
                if self._is_confirmed and self._run.is_ready:
                    return self._keep(context)
            elif event.type == "MOUSEMOVE" and not self._is_confirmed:
                self.factor = self._run.factor_at(event.mouse_x)
                self._run.set_factor(self.factor)
            elif event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
                self._is_confirmed = True
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            self.cancel(context)
            self.report({"ERROR"}, rpt_("Nothing has changed: {}").format(error))
            return {"CANCELLED"}
        self._show(context)
        # The timer of a posing act goes on, too.
        return {"PASS_THROUGH"} if event.type == "TIMER" else {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator, or Esc."""
        self._run.end(context)
        self._status.clear()
        self._run.restore()
        redraw.tag_panels()

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        self._choose(context)
        return self.place(context, lambda obj: self._blend(obj, self.factor))

    def _keep(self, context: bpy.types.Context) -> set[str]:
        """As execute() from the start: what is kept is what the panel of the last act gives for this factor."""
        self._run.end(context)
        self._status.clear()
        self._run.restore_handles()
        result = self.execute(context)
        if "FINISHED" not in result:
            self._run.restore()
        return result

    def _choose(self, context: bpy.types.Context) -> None:
        self.pose = self.pose or _active_name(context)
        self.start_pose = self.start_pose or self.pose

    def _blend(self, obj: bpy.types.Object, factor: float) -> api.Placement:
        start = {"NOW": api.NOW, "REST": api.REST}.get(self.start, self.start_pose)
        return api.blend_poses(obj, start, self.pose, factor)

    def _show(self, context: bpy.types.Context) -> None:
        run = self._run
        parts = [
            iface_("{:.0%} of the way to '{}'").format(self.factor, self.pose),
            iface_("Left or right: less or more"),
            iface_("Click, Enter: keep"),
            iface_("Esc: cancel"),
        ]
        if not run.is_ready:
            parts.insert(0, iface_("preparing the mesh, {:.0%}").format(run.bind_fraction))
        self._status.show(context, f"{iface_('ARAP Blend')}: {'   |   '.join(parts)}")


class ARAP_OT_poses_mirror(bpy.types.Operator):
    bl_idname = "arap.poses_mirror"
    bl_label = "Mirror ARAP Pose"
    bl_description = (
        "Store the mirror image of the pose chosen in the list. Handles are paired by name (Hand.L and Hand.R), or by "
        "where they are at rest"
    )
    bl_options = {"REGISTER", "UNDO"}

    axis: EnumProperty(name="Axis", description="Across which plane of the object", items=AXES, default="X")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_stored_pose(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        pose = api.mirror_pose(posed_object(context), _active_name(context), "XYZ".index(self.axis))
        self.report({"INFO"}, rpt_("Stored pose '{}'").format(pose.name))
        return {"FINISHED"}


class ARAP_OT_poses_to_keys(ShapesJobOperator, bpy.types.Operator):
    bl_idname = "arap.poses_to_keys"
    bl_label = "ARAP Poses to Shape Keys"
    bl_description = (
        "Solve every stored pose from rest and make it a shape key of its name, value 0. Keys made so before are "
        "renewed, all others stay as they are"
    )
    bl_options = {"UNDO"}  # not REGISTER: its redo panel would solve again at every change

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_pose_keys(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.work_off(context, api.begin_pose_keys(posed_object(context)))

    def report_shapes(self, _job: api.PoseKeysJob, names: list[str]) -> None:
        text = rpt_("Made 1 shape key: {1}") if len(names) == 1 else rpt_("Made {0} shape keys: {1}")
        self.report({"INFO"}, text.format(len(names), ", ".join(names)))


CLASSES = (
    ARAP_OT_poses_store,
    ARAP_OT_poses_delete,
    ARAP_OT_poses_apply,
    ARAP_OT_poses_blend,
    ARAP_OT_poses_mirror,
    ARAP_OT_poses_to_keys,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
