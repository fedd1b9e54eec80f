# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""ARAP Pull: drag the surface itself. A click pins, Ctrl-click removes the pin; on another mesh it takes that."""

from dataclasses import replace

import bpy

from ..core.naming import counted
from ..core.native import ERRORS, sentence_of
from ..engine.interaction import End, Ending, Phase
from ..props import preferences
from ..scene import known, redraw, shape_keys
from ..scene.registration import for_each
from ..setup.handles import following_first_handle
from ..ui.checks import (
    ArapOperator,
    allow,
    arap_object,
    find_arap_object,
    reports_errors,
    select_alone,
    why_not_idle,
    why_not_object_mode,
    why_not_pullable,
)
from ..ui.modal import ModalOperator
from . import pins, tool
from .drag import Mode, press_place
from .other_mesh import mesh_at, pulled_object
from .region import PulledPatch
from .run import DragStart, PullRun, find_grip, grabs_at, remove_pins_at, runs

CONFIRM = {"LEFTMOUSE", "RET", "NUMPAD_ENTER"}
CANCEL = {"ESC", "RIGHTMOUSE"}
AXES = {"X": 0, "Y": 1, "Z": 2}
WHEEL = {"WHEELUPMOUSE": 1.1, "WHEELDOWNMOUSE": 1.0 / 1.1}
MOUSE_MOVES = {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}
MOVES = {*MOUSE_MOVES, "NONE"}


def why_no_pull(context: bpy.types.Context) -> str:
    """As why_not_idle(), and there must be a temporary pin of the tool."""
    lack = "Nothing is pulled or pinned: drag or click the mesh with ARAP Pull first"
    return why_not_idle(context) or ("" if arap_object(context).arap.pull_pins else lack)


class ARAP_OT_pull(ModalOperator, bpy.types.Operator):
    bl_idname = "arap.pull"
    bl_label = "ARAP Pull"
    bl_description = (
        "Drag the surface under the mouse and the mesh follows. A click pins the surface, Ctrl-click removes the pin"
    )
    bl_options = {"UNDO"}

    _run: PullRun | None = None
    _grip: DragStart | None = None
    _problem = ""  # why the mesh in hand cannot be pulled: told by a drag, and by a click unless it takes another mesh

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if bpy.app.background:
            return allow(cls, "Pulling needs a window: use handles and Solve")
        if context.region_data is None:
            return allow(cls, "Pull in a 3D view")
        return allow(cls, "" if find_arap_object(context) is not None else "Select a mesh first")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._mouse = (event.mouse_region_x, event.mouse_region_y)
        self._before: tuple[int, int] | None = (
            event.mouse_prev_x - context.region.x,
            event.mouse_prev_y - context.region.y,
        )
        self._is_ctrl = event.ctrl
        # Else a key, a menu or a script has called it, and a click ends it.
        self._is_held = (event.type, event.value) == ("LEFTMOUSE", "PRESS")
        return self._begin(context)

    @reports_errors
    def _begin(self, context: bpy.types.Context) -> set[str]:
        # A press always begins: passed on, it would let Blender select and move objects.
        self._take_grip(context)
        if not self._is_held and self._grip is None:
            lack = f"'{pulled_object(context).name}' is not under the mouse: point at the mesh"
            raise ValueError(self._problem or lack)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        mouse = (event.mouse_region_x, event.mouse_region_y)
        if self._run is None:
            return self._before_drag(context, event, mouse)
        run, answer = self._run, {"RUNNING_MODAL"}
        try:
            answer = self._settling(event) if run.is_released else self._dragging(event, mouse)
            if event.type == "TIMER":
                run.tick()
            run.show_status(context)
        except Exception as error:  # noqa: BLE001 - whatever it is, the drag must end, and the mesh go back
            run.interaction.fail(error)
        if run.is_over:
            return self._end() | (answer & {"PASS_THROUGH"})
        return answer

    def _before_drag(self, context: bpy.types.Context, event: bpy.types.Event, mouse: tuple[int, int]) -> set[str]:
        if event.type in CANCEL and event.value == "PRESS":
            return {"CANCELLED"}
        if event.type in MOUSE_MOVES:
            self._find_start(context, event, mouse)
        is_end = event.type == "LEFTMOUSE" and event.value == ("RELEASE" if self._is_held else "PRESS")
        threshold = context.preferences.inputs.drag_threshold_mouse
        is_drag = max(abs(mouse[0] - self._mouse[0]), abs(mouse[1] - self._mouse[1])) >= threshold
        # While the press is looked at, a quick drag may be over: then its end is the only event that tells of it.
        if is_end and not (is_drag and self._is_held):
            return self._click(context)
        if not (is_drag and (is_end or event.type in MOUSE_MOVES)):
            return {"RUNNING_MODAL"}
        if self._grip is None and not self._problem:
            if not is_end:
                bpy.ops.view3d.rotate("INVOKE_DEFAULT")  # as in Sculpt Mode; at the press it would end an axis view
            return {"CANCELLED"}
        answer = self._begin_drag(context, event, mouse)
        if is_end and self._run is not None:
            self._run.is_released = True
        return answer

    def _find_start(self, context: bpy.types.Context, event: bpy.types.Event, mouse: tuple[int, int]) -> None:
        """At the first move: takes the grip again if the press was elsewhere than it told."""
        if self._before is None:
            return
        start = press_place(self._mouse, self._before, mouse, is_behind=event.type == "INBETWEEN_MOUSEMOVE")
        self._before = None
        if start != self._mouse:
            self._mouse = start
            self._take_grip(context)

    def _take_grip(self, context: bpy.types.Context) -> None:
        self._grip, self._problem = None, ""
        try:
            self._grip = _grip_at(context, self._mouse)
        except ERRORS as error:
            self._problem = sentence_of(error)

    @reports_errors
    def _begin_drag(self, context: bpy.types.Context, event: bpy.types.Event, mouse: tuple[int, int]) -> set[str]:
        self._check()
        assert self._grip is not None
        obj = known.find(self._grip.uid)
        if obj is None:
            raise ValueError("The mesh was deleted: the pull has ended")
        self._run = PullRun(context, obj, self._grip)
        _take_in_hand(context, obj)
        self._run.drag.set_mode(_mode_of(event))
        self._run.move(mouse)
        return {"RUNNING_MODAL"}

    @reports_errors
    def _click(self, context: bpy.types.Context) -> set[str]:
        obj = pulled_object(context)
        other = None if self._is_ctrl else mesh_at(context, self._mouse)
        if other is not None and other != obj:
            select_alone(context, other)
            self.report({"INFO"}, f"'{other.name}' is in hand: drag it to pull it, click it again to pin a spot")
            return {"FINISHED"}
        self._check()
        if self._grip is None:
            return {"CANCELLED"}
        _take_in_hand(context, obj)
        pick = self._grip.pick
        if self._is_ctrl:
            if not remove_pins_at(obj, pick):
                raise ValueError("There is no pin of ARAP Pull here: point at one of its dots")
        else:
            pins.add(obj, [replace(grab, reach=0.0) for grab in grabs_at(obj, pick, PulledPatch(pick.vertices))])
            tool.watch()
        redraw.tag_views()
        return {"FINISHED"}

    def _check(self) -> None:
        """Raises ValueError if the mesh in hand cannot be pulled."""
        if self._problem:
            raise ValueError(self._problem)

    def _dragging(self, event: bpy.types.Event, mouse: tuple[int, int]) -> set[str]:
        run = self._run
        assert run is not None
        if event.type == "MOUSEMOVE":
            run.drag.is_stretching = event.alt
            run.drag.set_mode(_mode_of(event))  # other events may report former modifier keys
            run.move(mouse)
        elif event.type in CONFIRM and event.value == ("RELEASE" if self._is_held else "PRESS"):
            run.move(mouse)
            run.is_released = True
        elif event.value != "PRESS":
            pass
        elif event.type in CANCEL:
            run.interaction.cancel()
        elif event.type in AXES and not (event.ctrl or event.oskey):  # Ctrl Z is no axis
            run.drag.toggle_axis(AXES[event.type])
            run.move(mouse)
        elif event.type in WHEEL:
            settings = preferences.pull()
            settings.radius = max(1, round(settings.radius * WHEEL[event.type]))
            run.resize()
        return {"RUNNING_MODAL"}

    def _settling(self, event: bpy.types.Event) -> set[str]:
        """Lets events through. A press ends the settling first, so that its own step of undo comes after this drag."""
        run = self._run
        assert run is not None
        if event.value == "PRESS" and event.type not in MOVES and not event.type.startswith("TIMER"):
            if run.interaction.phase is not Phase.BINDING:
                run.interaction.keep(is_settling=False)
            elif event.type == "ESC" or _is_undo(event):  # there is no step of this drag yet that undo could take back
                run.interaction.cancel()
                return {"RUNNING_MODAL"}
        return {"PASS_THROUGH"}

    def _end(self) -> set[str]:
        assert self._run is not None
        end = self._run.finish()
        tool.watch()
        redraw.tag_views()
        if end.message:
            self.report({_severity(end)}, end.message)
        # A step of undo after an undo would remove the redo steps.
        return {"CANCELLED"} if end.how is Ending.RESTORE or self._run.is_undone else {"FINISHED"}


def _grip_at(context: bpy.types.Context, mouse: tuple[int, int]) -> DragStart | None:
    """As find_grip(), on pulled_object(). Raises ValueError too if that cannot be pulled."""
    obj = pulled_object(context)
    reason = why_not_pullable(context, obj)
    if reason:  # not in poll(): if poll() fails, Blender shows no message and passes the key on
        raise ValueError(reason)
    shape_keys.check_writable(obj)
    pins.forget_stale(obj)
    return find_grip(context, obj, mouse)


def _take_in_hand(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """What is pulled through a mesh that is attached to it: the tab and the pins shown are of that."""
    if arap_object(context) != obj:
        select_alone(context, obj)


def _severity(end: End) -> str:
    if end.error is not None:
        return "ERROR"
    return "INFO" if end.how is Ending.KEEP else "WARNING"


def _mode_of(event: bpy.types.Event) -> Mode:
    if event.shift:
        return Mode.TURN
    return Mode.NORMAL if event.ctrl else Mode.MOVE


def _is_undo(event: bpy.types.Event) -> bool:
    return event.type == "Z" and (event.ctrl or event.oskey) and not event.shift


class ARAP_OT_pull_make_real(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.pull_make_real"
    bl_label = "Make Handles of Pulls"
    bl_description = "Turn pulled pieces into handles with empties, and pieces at rest into pins. The mesh stays"
    why_not = staticmethod(why_no_pull)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        with following_first_handle(obj):
            n_handles, n_pins = pins.make_real(obj, context.evaluated_depsgraph_get())
            if n_handles:
                obj.arap.active_control_index = obj.arap.controls.find(obj.arap.handles[-1].name)
        made = [counted(n, word) for n, word in ((n_handles, "handle"), (n_pins, "pin")) if n]
        self.report({"INFO"}, f"Made {' and '.join(made)}")
        redraw.tag_views()


class ARAP_OT_pull_release(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.pull_release"
    bl_label = "Release Pulls"
    bl_description = "Remove all temporary pins of the tool. The mesh stays as it is"
    why_not = staticmethod(why_no_pull)

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        obj.arap.pull_pins.clear()
        redraw.tag_views()


def why_not_in_view(context: bpy.types.Context) -> str:
    """As why_not_pullable(). There must be a 3D view."""
    if not isinstance(context.space_data, bpy.types.SpaceView3D):
        return "Take the tool in a 3D view"
    if context.mode != "OBJECT" and context.object is not None and find_arap_object(context) != context.object:
        return why_not_object_mode(context.object)  # of an armature: tools belong to modes
    return why_not_pullable(context)


class ARAP_OT_pull_tool(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.pull_tool"
    bl_label = "Pull"
    bl_description = "Take the tool ARAP Pull: drag the surface to move it, click to pin it"
    bl_options: set[str] = set()
    why_not = staticmethod(why_not_in_view)

    def modify(self, _context: bpy.types.Context, _obj: bpy.types.Object) -> None:
        bpy.ops.wm.tool_set_by_id(name=tool.IDNAME)


def undone() -> None:
    """After an undo."""
    for_each(runs.copy(), PullRun.undone)
