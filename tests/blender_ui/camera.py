# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the pictures of the documents: of a region, of a part of it, or of one panel of the tab."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

import bpy
from harness import Steps, Ui, register_again, sub_panels

SAMPLES = Path(__file__).resolve().parents[2] / "blend_files"
STEPS_UNTIL_DRAWN = 8  # soft edges come in several passes
PANELS_S = 0.7  # new panels slide to their place
TABS_PX = 24  # the tabs' names beside the panels
EDGE_PX = 6  # of an editor, whose corners are round


class Camera:
    """Takes pictures of the window: NAME.png in the folder of the screenshots."""

    def __init__(self, ui: Ui, *, has_soft_edges: bool = True) -> None:
        """With a sidebar beside the view instead of over it."""
        self._ui = ui
        system = bpy.context.preferences.system
        system.viewport_aa = "8" if has_soft_edges else "OFF"
        system.use_region_overlap = False

    def view(self, name: str, *cut: str) -> Steps:
        """The 3D view alone; ``cut``: what ImageMagick does to the picture."""
        yield from self._take(name, self._ui.region(), cut, EDGE_PX)

    def area(self, name: str, *cut: str, area: bpy.types.Area | None = None) -> Steps:
        """An editor with all its regions: the 3D view by default."""
        yield from self._take(name, area or self._ui.view, cut)

    def open_panels(self) -> Steps:
        """Opens the tab with all its sub-panels open."""
        register_again({cls: set() for cls in sub_panels()})
        yield from self._ui.open_tab()

    def panel(self, name: str, *panels: str) -> Steps:
        """The tab with these sub-panels alone, and without what stands above them; the whole of that for none."""
        children = [*sub_panels(), *([bpy.types.ARAP_PT_pose] if panels else [])]  # which has no header
        for cls in reversed(children):
            bpy.utils.unregister_class(cls)
        chosen = [cls for cls in children if cls.__name__ in panels]
        cut = ("-trim", "+repage")
        if chosen:
            top = yield from self._tab_height()
            cut = ("-chop", f"0x{top}", *cut)
        for cls in chosen:
            bpy.utils.register_class(cls)
        yield from self._slide()
        yield from self._take(name, self._ui.region("UI"), cut, TABS_PX)
        for cls in reversed(chosen):
            bpy.utils.unregister_class(cls)
        for cls in children:
            bpy.utils.register_class(cls)

    def popup(self, name: str, operator: Any, **properties: Any) -> Steps:
        """What an operator opens over the 3D view, cut out."""
        yield from self.view("before")
        self._ui.call(operator, **properties)
        yield from self.view("after")
        before, after = (self._ui.screenshots / f"{name}.png" for name in ("before", "after"))
        difference = ("-compose", "difference", "-composite", "-colorspace", "gray", "-threshold", "3%")
        box = _output("convert", str(before), str(after), *difference, "-format", "%@", "info:")
        _output("convert", str(after), "-crop", box, "+repage", str(self._ui.screenshots / f"{name}.png"))
        before.unlink()
        after.unlink()

    def _slide(self) -> Steps:
        end = time.monotonic() + PANELS_S
        while time.monotonic() < end:
            self._ui.region("UI").tag_redraw()
            yield

    def _tab_height(self) -> Generator[None, None, int]:
        """Pixels from the top of the tab to the end of what is drawn in it."""
        yield from self._slide()
        yield from self._take("head", self._ui.region("UI"), ("-trim",), TABS_PX)
        path = self._ui.screenshots / "head.png"
        height, top = _output("identify", "-format", "%h %Y", str(path)).split()
        path.unlink()
        return int(height) + int(top)

    def _take(self, name: str, place: bpy.types.Region | bpy.types.Area, cut: tuple[str, ...], right: int = 0) -> Steps:
        """``right``: pixels left out there; of a region its edges are left out, too."""
        ui = self._ui
        for area in ui.window.screen.areas:
            area.tag_redraw()
        for _ in range(STEPS_UNTIL_DRAWN):
            yield
        top = ui.window.height - place.y - place.height
        edge = EDGE_PX if right else 0
        crop = f"{place.width - right - edge}x{place.height - 2 * edge}+{place.x + edge}+{top + edge}"
        path = str(ui.screenshots / f"{name}.png")
        _output("import", "-window", "root", path)
        _output("convert", path, "-crop", crop, "+repage", *cut, path)


def _output(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def tidy_up(space: bpy.types.SpaceView3D) -> None:
    """Nothing but what is meant: no floor, no cursor, no texts."""
    space.show_region_toolbar = space.show_region_header = space.show_region_tool_header = False
    space.show_gizmo = space.show_region_hud = False
    overlay = space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = overlay.show_cursor = overlay.show_text = False
    overlay.show_outline_selected = overlay.show_ortho_grid = overlay.show_object_origins = False


def open_creature(ui: Ui) -> Steps:
    """The sample creature with its pins, handles and animation; returns it."""
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / "creature.blend"), load_ui=False)
    yield
    creature = next(obj for obj in bpy.context.scene.objects if obj.type == "MESH" and obj.arap.handles)
    ui.select(creature)
    shading = ui.view.spaces.active.shading
    shading.type, shading.color_type = "SOLID", "VERTEX"
    return creature


def begin_pull(ui: Ui, sample: str = "creature") -> Generator[None, None, bpy.types.Object]:
    """The posed mesh of a sample without its handles, seen from the front, and the tool in hand."""
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{sample}.blend"))
    yield
    creature = next(obj for obj in bpy.data.objects if obj.type == "MESH" and obj.arap.handles)
    for obj in [obj for obj in bpy.data.objects if obj.type in {"EMPTY", "ARMATURE"}]:
        bpy.data.objects.remove(obj)
    creature.arap.controls.clear()
    creature.animation_data_clear()
    creature.shape_key_clear()
    ui.select(creature)
    ui.view.spaces.active.shading.type = "SOLID"
    ui.call(bpy.ops.view3d.view_axis, type="FRONT")
    ui.call(bpy.ops.view3d.view_selected)
    yield
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    yield
    return creature


def look(ui: Ui, *, right: float = 0.0, up: float = 0.0, closer: float = 1.0) -> None:
    """From its left, turned by radians; ``closer``: less than 1 is nearer."""
    with ui.override():
        bpy.ops.view3d.view_axis(type="RIGHT")
        bpy.ops.view3d.view_orbit(angle=right, type="ORBITRIGHT")
        bpy.ops.view3d.view_orbit(angle=up, type="ORBITUP")
        bpy.ops.view3d.view_selected()
    ui.view.spaces.active.region_3d.view_distance *= closer
