# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Baking the pose to a shape key, and the animation of the handles to shape keys with keyframes or to a point cache."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ..core import native
from ..pose.job_operator import JobOperator
from ..pose.result import bake_pose
from ..scene import baked, meshes, ui_cache, versions
from ..ui.checks import ArapOperator, arap_object, why_baked, why_no_pose, why_not_idle, why_not_solvable
from ..ui.panels import draw_text_in_dialog, split_column
from .cache import MeshCacheJob
from .cache_file import FORMATS
from .estimate import BYTES_PER_VERTEX, LAST_FRAME, BakeEstimate, check_range, check_search, n_frames, size_text
from .frame_range import proposed_range
from .keys import BakeJob

FORMAT_ITEMS = (
    ("MDD", "MDD", "Times in seconds. Most programs read it"),
    ("PC2", "PC2", "Times in frames. For 3ds Max and others"),
)


class ARAP_OT_bake_pose(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.bake_pose"
    bl_label = "Bake Pose"
    bl_description = "Copy the present pose to a new shape key"
    why_not = staticmethod(why_no_pose)

    name: StringProperty(name="Name", description="Name of the new shape key", default="Pose")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return set(context.window_manager.invoke_props_dialog(self))

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        key = bake_pose(obj, name=self.name)
        self.report({"INFO"}, f"Baked to shape key '{key.name}'")


class FramesOperator(JobOperator):
    """A mixin for operators that solve a range of frames."""

    why_not = staticmethod(why_not_solvable)

    frame_start: IntProperty(name="Start", description="First frame", default=1, min=-LAST_FRAME, max=LAST_FRAME)
    frame_end: IntProperty(name="End", description="Last frame", default=250, min=-LAST_FRAME, max=LAST_FRAME)
    frame_step: IntProperty(name="Step", description="Solve every n-th frame", default=1, min=1)

    properties: Any  # of the operator
    layout: Any

    def propose_range(self, context: bpy.types.Context) -> None:
        """Fills in the frames that the caller has not set."""
        start, end = proposed_range(arap_object(context), context.scene)
        if not self.properties.is_property_set("frame_start"):
            self.frame_start = start
        if not self.properties.is_property_set("frame_end"):
            self.frame_end = end

    @property
    def frame_range(self) -> tuple[int, int, int]:
        return self.frame_start, self.frame_end, self.frame_step

    def draw_range(self, layout: bpy.types.UILayout) -> None:
        column = layout.column(align=True)
        for name in ("frame_start", "frame_end", "frame_step"):
            column.prop(self, name)

    def draw_size(self, context: bpy.types.Context, size: Callable[[], str], icon: str) -> None:
        """A line with the text of ``size``, or with the error that it raises."""
        try:
            self.layout.label(text=size(), translate=False, icon=icon)
        except native.ERRORS as error:
            draw_text_in_dialog(context, self.layout, native.sentence_of(error), "ERROR")


class ARAP_OT_bake_animation(FramesOperator, bpy.types.Operator):
    bl_idname = "arap.bake_animation"
    bl_label = "Bake Animation"
    bl_description = "Solve each frame and make it a keyframed shape key, so that the file plays without this add-on"

    use_fewest_keys: BoolProperty(
        name="Fewest Keys", description="Make only as many shape keys as the tolerance Within needs"
    )
    fewest_keys_percent: FloatProperty(
        name="Within",
        description=(
            "Largest error of every vertex in every solved frame, in percent of the mesh's size "
            "(the diagonal of its box at rest)"
        ),
        default=0.1,
        min=0.0,
        max=100.0,
        soft_max=5.0,
        precision=3,
        step=1,
        subtype="PERCENTAGE",
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        self.propose_range(context)
        return set(context.window_manager.invoke_props_dialog(self))

    def draw(self, context: bpy.types.Context) -> None:
        layout = split_column(self.layout)
        self.draw_range(layout)
        column = layout.column(align=True)
        column.prop(self, "use_fewest_keys")
        within = column.column()
        within.active = self.use_fewest_keys
        within.prop(self, "fewest_keys_percent")
        if self.use_fewest_keys:
            self.draw_size(context, lambda: f"Largest error {self._tolerance_text(context)}", "DRIVER_DISTANCE")
        self.draw_size(context, lambda: self._size_text(arap_object(context)), "SHAPEKEY_DATA")

    def _size_text(self, obj: bpy.types.Object) -> str:
        n = n_frames(*self.frame_range)
        if self.use_fewest_keys:
            check_search(n)
        return f"{'Up to ' if self.use_fewest_keys else ''}{BakeEstimate(n, len(obj.data.vertices))}"

    def _tolerance_text(self, context: bpy.types.Context) -> str:
        size = ui_cache.diagonal(arap_object(context), meshes.drawn_depsgraph(context))
        return versions.length_text(context.scene, size * self.fewest_keys_percent / 100.0)

    def begin(self, _context: bpy.types.Context, obj: bpy.types.Object) -> BakeJob:
        percent = self.fewest_keys_percent if self.use_fewest_keys else None
        return BakeJob(obj, *self.frame_range, fewest_keys_percent=percent)

    def result_text(self, job: BakeJob, names: list[str]) -> str:
        return f"Baked shape keys '{names[0]}' to '{names[-1]}': {job.fit}"


def why_not_baked(context: bpy.types.Context) -> str:
    """As why_not_idle(). A bake must show in place of the pose."""
    lack = "No bake is shown: the mesh can be posed"
    return why_not_idle(context) or ("" if why_baked(arap_object(context)) else lack)


class ARAP_OT_edit_again(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.edit_again"
    bl_label = "Edit Again"
    bl_description = "Show the pose in place of the bake, to change it. The next bake replaces this one"
    why_not = staticmethod(why_not_baked)
    ends_itself = True

    is_removing: BoolProperty(
        name="Remove Bake",
        description="Remove the shape keys of all bakes of this mesh. Off: mute them until the next bake replaces them",
    )

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        baked.edit_again(obj, is_removing=self.is_removing)


class ARAP_OT_export_mesh_cache(FramesOperator, bpy.types.Operator):
    bl_idname = "arap.export_mesh_cache"
    bl_label = "Export Mesh Cache"
    bl_description = "Solve each frame and write it to a file for the Mesh Cache modifier: for shots too long to bake"
    task_name = "Export"

    filepath: StringProperty(name="File", description="The .mdd or .pc2 file to write", subtype="FILE_PATH")
    check_existing: BoolProperty(default=True, options={"HIDDEN"})
    filter_glob: StringProperty(default="*.mdd;*.pc2", options={"HIDDEN"})
    cache_format: EnumProperty(name="Format", description="Kind of file", items=FORMAT_ITEMS, default="MDD")
    add_modifier: BoolProperty(
        name="Add Modifier",
        description="Add a Mesh Cache modifier that plays the file. While it is on, poses are not visible",
        default=True,
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        self.propose_range(context)
        if not self.filepath:
            folder = Path(bpy.data.filepath).parent if bpy.data.filepath else Path.home()
            self.filepath = str(folder / bpy.path.clean_name(arap_object(context).name))
        self.check(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def check(self, _context: bpy.types.Context) -> bool:
        """Gives the file name the suffix of the format; True if that has changed the name."""
        path = Path(self.filepath)
        if not path.name:
            return False
        suffix = f".{self.cache_format.lower()}"
        right = path.with_suffix(suffix) if path.suffix.lower() in FORMATS else path.with_name(f"{path.name}{suffix}")
        has_changed = right != path
        self.filepath = str(right)
        return has_changed

    def draw(self, context: bpy.types.Context) -> None:
        layout = split_column(self.layout)
        layout.prop(self, "cache_format")
        self.draw_range(layout)
        layout.prop(self, "add_modifier")
        self.draw_size(context, lambda: self._size_text(arap_object(context)), "FILE_CACHE")

    def _size_text(self, obj: bpy.types.Object) -> str:
        check_range(*self.frame_range)
        n_frames = len(range(self.frame_start, self.frame_end + 1, self.frame_step))
        return f"{n_frames} frames, {size_text(BYTES_PER_VERTEX * n_frames * len(obj.data.vertices))}"

    def begin(self, _context: bpy.types.Context, obj: bpy.types.Object) -> MeshCacheJob:
        return MeshCacheJob(obj, self.filepath, *self.frame_range, add_modifier=self.add_modifier)

    def result_text(self, job: MeshCacheJob, path: Path) -> str:
        return f"Exported {job.n_shapes} frames to {path}"
