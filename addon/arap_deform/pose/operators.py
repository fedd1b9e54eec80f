# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The posing act in Blender: a modal operator that lets everything through but Enter and Esc.

The act itself is in pose_act. Here is what it needs of Blender: names instead of references (undo replaces all data),
handlers that say when the scene was evaluated, a timer for refining, and one exit.
"""

import bpy
from bpy.props import BoolProperty

from ..core import sessions
from ..core.arrays import Floats
from ..core.session_data import Readout
from ..core.session_input import SessionInput
from ..follow.act import End, Ending, Phase, PoseAct, print_fault, restored, status_text
from ..follow.scene import BlenderFollowScene, is_rendering
from ..live import runs
from ..props import preferences
from ..scene import app_handlers, pose_key, redraw
from ..setup.handles import handle_problem
from ..ui.checks import StatusBar, allow, find_posed_object, is_posed, posed_object, reports_errors, why_not_solvable
from . import undo
from .result import capture_state, restore_state

TIMER_S = 0.02
VIEW_EVENTS = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "NDOF_MOTION"}
EDITORS_WITH_TEXT = {"CONSOLE", "TEXT_EDITOR"}


class BlenderPoseScene(BlenderFollowScene):
    """The PoseScene of one object."""

    def __init__(self, obj: bpy.types.Object) -> None:
        super().__init__(obj)
        self.number = 0
        pose_key.forget_removed(obj)
        self.state = capture_state(obj)
        self.key = pose_key.KeyFollower(obj)
        self._counts = _counts(obj)
        former = sessions.get(obj.name)
        self._topology = former.inputs.signature.topology if former is not None else None

    @property
    def obj(self) -> bpy.types.Object | None:
        """The object; None where it is gone, or another one has its name."""
        obj = super().obj
        return obj if obj is not None and undo.is_within(obj, self.number) else None

    def why_over(self) -> str:
        obj = self.obj
        if obj is None or obj.name not in bpy.context.scene.objects:
            return f"'{self.name}' was deleted or renamed: posing has ended"
        if obj.mode not in {"OBJECT", "WEIGHT_PAINT"}:
            return f"'{self.name}' is no longer in Object Mode: the pose is kept and posing has ended"
        if _counts(obj) != self._counts:
            text = "The mesh of '{}' has changed: posing has ended, its rest shape is another one now"
            return text.format(self.name)
        reason = self.key.why_left(obj)
        if not reason and not self.key.follow(obj):
            reason = f"Shape key '{pose_key.wanted_name(obj)}' of '{obj.name}' was removed"
        if reason:
            return f"{reason}: posing has ended"
        for index, handle in enumerate(obj.arap.handles):
            problem = handle_problem(obj, index) if handle.is_enabled else ""
            if problem:
                return f"{problem}. The pose is kept and posing has ended"
        return ""

    def update(self, matrices: Floats, iterations: int | None, time_limit_s: float | None) -> Readout:
        readout = super().update(matrices, iterations, time_limit_s)
        self.key.note(self._obj())
        return readout

    def restore(self, obj: bpy.types.Object) -> None:
        """Everything as before the act. Raises as restore_state()."""
        self.key.give_name_back(obj)
        restore_state(obj, self.state)

    def _read_inputs(self) -> SessionInput:
        inputs = super()._read_inputs()
        topology = inputs.signature.topology
        if self._topology not in {None, topology}:
            raise ValueError(f"The faces of '{self.name}' have changed")
        self._topology = topology
        return inputs


def _counts(obj: bpy.types.Object) -> tuple[int, int, int]:
    return len(obj.data.vertices), len(obj.data.loops), len(obj.data.polygons)


class Run:
    """One running act: its state machine, its scene, and what it has put into Blender's window."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Begins the act. Raises ValueError or RuntimeError where it cannot; then nothing has changed."""
        sessions.check_free(obj.name)
        runs.give_up(obj)
        self.scene = BlenderPoseScene(obj)
        self.act = PoseAct(self.scene)
        self._status = StatusBar()
        self.scene.number = undo.mark(obj)
        try:
            self.act.begin()
        except BaseException:
            undo.unmark(obj)
            raise
        undo.push("Begin ARAP Pose")
        self._timer = context.window_manager.event_timer_add(TIMER_S, window=context.window)
        _add(self)

    def show_status(self, context: bpy.types.Context) -> None:
        self._status.show(context, status_text(self.act))

    def finish(self) -> End:
        """The one exit of all ends; ``end.message`` is what is left to say."""
        end = self.act.end
        assert end is not None
        bpy.context.window_manager.event_timer_remove(self._timer)
        _remove(self)
        obj = self.scene.obj
        if obj is None:
            sessions.drop(self.scene.name)
        elif end.how is Ending.RESTORE:
            end = restored(end, lambda: self.scene.restore(obj))
        undo.finish(self.scene.name, self.scene.number, as_one_step=end.how is not Ending.LEAVE)
        self._status.clear()
        print_fault(end)
        redraw.tag_panels()
        return end


_runs: dict[str, Run] = {}


def _add(run: Run) -> None:
    if not _runs:
        app_handlers.add(_HANDLERS)
    _runs[run.scene.name] = run
    sessions.claim(run.scene.name, run.act)


def _remove(run: Run) -> None:
    _runs.pop(run.scene.name, None)
    sessions.release(run.scene.name, run.act)
    if not _runs:
        app_handlers.remove(_HANDLERS)


def _on_update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    _scene_changed(scene, depsgraph, is_frame=False)


def _on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    _scene_changed(scene, depsgraph, is_frame=True)


def _scene_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, *, is_frame: bool) -> None:
    if is_rendering():
        return
    for run in list(_runs.values()):
        if scene.objects.get(run.scene.name) is not None or run.scene.obj is None:
            with run.scene.evaluated(depsgraph, is_frame=is_frame):
                run.act.scene_changed()


def _on_undo(*_: object) -> None:
    for run in list(_runs.values()):
        if run.scene.obj is None:
            run.act.leave("Undo went back to before this pose: posing has ended")
        else:
            run.scene.key.forget_address()
            run.act.undone()


_HANDLERS = (
    ("depsgraph_update_post", _on_update),
    ("frame_change_post", _on_frame),
    ("undo_post", _on_undo),
    ("redo_post", _on_undo),
)


class ARAP_OT_pose(bpy.types.Operator):
    bl_idname = "arap.pose"
    bl_label = "ARAP Pose"
    bl_description = "Move, turn and scale the handles and the mesh follows. Enter keeps the pose, Esc cancels it"
    bl_options = {"UNDO"}

    _run: Run

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if bpy.app.background:
            return allow(cls, "Posing needs a window: use Solve")
        return allow(cls, why_not_solvable(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return self._begin(context)

    @reports_errors
    def _begin(self, context: bpy.types.Context) -> set[str]:
        self._run = Run(context, posed_object(context))
        context.window_manager.modal_handler_add(self)
        self._run.show_status(context)
        redraw.tag_panels()
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        run = self._run
        is_ours = False
        if event.type == "TIMER":
            self._tick(context)
        else:
            # A release that ends somebody else's drag reaches us too, so only a press means something.
            # While it ends nothing new begins but moves of the view: it would be cut off in the middle.
            is_ours = event.value == "PRESS" and (
                self._on_press(context, event) or (run.act.is_keeping and event.type not in VIEW_EVENTS)
            )
            run.show_status(context)
        if run.act.end is None:
            return {"RUNNING_MODAL"} if is_ours else {"PASS_THROUGH"}
        end = run.finish()
        if end.message:
            self.report({"WARNING"} if end.error is None else {"ERROR"}, end.message)
        if end.how is Ending.KEEP:
            return {"FINISHED"}
        if end.how is Ending.RESTORE:
            undo.push("Cancel ARAP Pose")
        return {"CANCELLED"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """Blender ends the operator: file load, closed window."""
        self._run.act.end_now()
        self._run.finish()

    def _tick(self, context: bpy.types.Context) -> None:
        if is_rendering():
            return
        act = self._run.act
        before = act.readout
        act.tick(preferences.refine_time_s())
        if act.phase is Phase.BINDING:
            self._run.show_status(context)
        if act.readout is not before or act.phase is Phase.BINDING:
            redraw.tag_panels()

    def _on_press(self, context: bpy.types.Context, event: bpy.types.Event) -> bool:
        """Acts on our keys; True where the key was ours."""
        act = self._run.act
        if _editor_at(context, event) in EDITORS_WITH_TEXT:
            return False
        if event.type in {"RET", "NUMPAD_ENTER"}:
            act.keep()
            return True
        if event.type == "ESC" and not context.screen.is_animation_playing:  # there Esc ends the playback
            act.cancel()
            return True
        return False


def _editor_at(context: bpy.types.Context, event: bpy.types.Event) -> str:
    for area in context.window.screen.areas:
        if area.x <= event.mouse_x < area.x + area.width and area.y <= event.mouse_y < area.y + area.height:
            return str(area.type)
    return ""


class ARAP_OT_pose_end(bpy.types.Operator):
    bl_idname = "arap.pose_end"
    bl_label = "End ARAP Pose"
    bl_description = "End posing: keep the pose, or put everything back to where it was before"

    is_kept: BoolProperty(name="Keep", description="Keep the pose. Off: everything as before", default=True)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = find_posed_object(context)
        return allow(cls, "" if obj is not None and is_posed(obj) else "Press Pose first: this mesh is not being posed")

    def execute(self, context: bpy.types.Context) -> set[str]:
        act = sessions.acts[posed_object(context).name]
        assert isinstance(act, PoseAct)
        if self.is_kept:
            act.keep()
        else:
            act.cancel()
        return {"FINISHED"}


CLASSES = (ARAP_OT_pose, ARAP_OT_pose_end)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for run in list(_runs.values()):  # Blender drops running operators without a word when their class goes
        run.act.end_now("The add-on was disabled")
        run.finish()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
