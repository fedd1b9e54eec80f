# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Exporting the animation of the handles to a point cache."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ..pose.job_operator import ShapesJobOperator
from ..ui.checks import allow, posed_object, reports_errors, why_not_solvable
from .cache import MeshCacheJob, begin_mesh_cache
from .cache_file import FORMATS
from .frames_job import check_range
from .keys import BYTES_PER_VERTEX, size_text

FORMAT_ITEMS = (
    ("MDD", "MDD", "Times in seconds; what most programs read"),
    ("PC2", "PC2", "Times in frames; 3ds Max and others"),
)


class ARAP_OT_export_mesh_cache(ShapesJobOperator, bpy.types.Operator):
    bl_idname = "arap.export_mesh_cache"
    bl_label = "Export ARAP Mesh Cache"
    bl_description = (
        "Solve each frame and write it to an MDD or PC2 file, for the Mesh Cache modifier: for shots too long to bake"
    )
    bl_options = {"UNDO"}  # not REGISTER: its redo panel would export again at every change

    act = "Export"

    filepath: StringProperty(name="File", description="The .mdd or .pc2 file to write", subtype="FILE_PATH")
    check_existing: BoolProperty(default=True, options={"HIDDEN"})
    filter_glob: StringProperty(default="*.mdd;*.pc2", options={"HIDDEN"})
    cache_format: EnumProperty(name="Format", description="Kind of file", items=FORMAT_ITEMS, default="MDD")
    frame_start: IntProperty(name="Start", description="First frame to export", default=1)
    frame_end: IntProperty(name="End", description="Last frame to export", default=250)
    frame_step: IntProperty(name="Step", description="Export every so many frames", default=1, min=1)
    add_modifier: BoolProperty(
        name="Add Modifier",
        description="Give the mesh a Mesh Cache modifier that plays the file. While it is on, poses are not seen",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_solvable(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        scene = context.scene
        if not self.properties.is_property_set("frame_start"):
            self.frame_start = scene.frame_start
        if not self.properties.is_property_set("frame_end"):
            self.frame_end = scene.frame_end
        if not self.filepath:
            folder = Path(bpy.data.filepath).parent if bpy.data.filepath else Path.home()
            self.filepath = str(folder / bpy.path.clean_name(posed_object(context).name))
        self.check(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def check(self, _context: bpy.types.Context) -> bool:
        """Gives the name the end of the format chosen; True where that has changed it."""
        path = Path(self.filepath)
        if not path.name:
            return False
        end = f".{self.cache_format.lower()}"
        right = path.with_suffix(end) if path.suffix.lower() in FORMATS else path.with_name(f"{path.name}{end}")
        has_changed = right != path
        self.filepath = str(right)
        return has_changed

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(self, "cache_format")
        column = layout.column(align=True)
        column.prop(self, "frame_start")
        column.prop(self, "frame_end")
        column.prop(self, "frame_step")
        layout.prop(self, "add_modifier")
        try:
            check_range(self.frame_start, self.frame_end, self.frame_step)
            n_frames = len(range(self.frame_start, self.frame_end + 1, self.frame_step))
            size = size_text(BYTES_PER_VERTEX * n_frames * len(posed_object(context).data.vertices))
            text, icon = f"{n_frames} frames, {size}", "FILE_CACHE"
        except ValueError as error:
            text, icon = str(error), "ERROR"
        layout.label(text=text, translate=False, icon=icon)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        job = begin_mesh_cache(
            posed_object(context),
            self.filepath,
            self.frame_start,
            self.frame_end,
            self.frame_step,
            add_modifier=self.add_modifier,
        )
        return self.work_off(context, job)

    def report_shapes(self, job: MeshCacheJob, path: Path) -> None:
        self.report({"INFO"}, f"Exported {job.n_shapes} frames to {path}")


def register() -> None:
    bpy.utils.register_class(ARAP_OT_export_mesh_cache)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_OT_export_mesh_cache)
