# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows, as arrays; drawn without a window where Blender can (4.5). Windows have their own tests."""

from unittest import mock

import bpy
import gpu
import numpy as np
from looks import rest_positions, shown_positions
from mathutils import Matrix
from support import SceneTest, module
from tubes import BOTTOM, MIDDLE, bend, move, posable, solved

SIZE = 64


class OverlayTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.data = module("show.data")

    def surface(self, obj):
        return self.data.Surface.read(obj, bpy.context.evaluated_depsgraph_get())

    def test_pins_faces_and_rest_are_those_of_the_mesh(self):
        obj = posable()
        surface = self.surface(obj)
        self.assertEqual(self.data.read_pinned(obj).tolist(), BOTTOM)
        self.assert_close(surface.rest, rest_positions(obj))
        n_triangles = sum(len(face.vertices) - 2 for face in obj.data.polygons)
        self.assertEqual(surface.triangles.shape, (n_triangles, 3))
        self.assertEqual(sorted(set(surface.triangles.ravel())), list(range(len(obj.data.vertices))))
        obj.arap.pins[0].is_enabled = False
        self.assertEqual(self.data.read_pinned(obj).tolist(), [])

    def test_strain_is_of_the_pose_alone(self):
        obj = posable()
        surface = self.surface(obj)
        at_rest = self.data.strain_colors(obj, surface)
        self.assert_close(at_rest, np.broadcast_to(at_rest[0], at_rest.shape), 0.0)
        bend(obj)
        self.api.solve(obj)
        posed = self.data.strain_colors(obj, surface)
        self.assertGreater(np.ptp(posed[:, 0]), 0.1)
        swollen = obj.shape_key_add(name="Swollen")
        swollen.data.foreach_set("co", (2.0 * rest_positions(obj)).ravel())
        swollen.value = 1.0
        self.assert_close(self.data.strain_colors(obj, surface), posed, 0.0)

    def test_positions_are_as_seen_and_before_modifiers_that_make_other_vertices(self):
        obj = solved()
        surface = self.surface(obj)
        obj.modifiers.new("Smooth", "SMOOTH").iterations = 5
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.assert_close(self.data.positions_now(obj, surface, depsgraph), shown_positions(obj), 1e-6)
        obj.modifiers.clear()
        posed = shown_positions(obj)
        obj.modifiers.new("Subdivision", "SUBSURF")
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.assert_close(self.data.positions_now(obj, surface, depsgraph), posed, 1e-6)

    def test_lines_go_from_rest_to_now_and_along_with_the_object(self):
        obj = posable()
        target = obj.arap.handles[0].target
        shift = np.array((0.3, 0.0, -0.2))
        before = np.array(target.matrix_world.translation)
        move(target, shift)
        lines = self.data.handle_lines(obj, bpy.context.evaluated_depsgraph_get())
        self.assert_close(lines, [before, before + shift], 1e-5)
        obj.matrix_world = Matrix.Translation((5.0, 0.0, 0.0))
        lines = self.data.handle_lines(obj, bpy.context.evaluated_depsgraph_get())
        self.assert_close(lines, np.array([before, before + shift]) + np.array((5.0, 0.0, 0.0)), 1e-5)
        bpy.data.objects.remove(target)
        lines = self.data.handle_lines(obj, bpy.context.evaluated_depsgraph_get())
        self.assertEqual(lines.shape, (0, 3))

    def test_it_shows_a_mesh_with_pins_handles_or_a_pose(self):
        """ARAP Pull needs neither pins nor handles of the lists."""
        shows = module("show.overlay")._shows_anything
        obj = posable()
        obj.arap.overlay.show_strain = True
        self.assertTrue(shows(obj))
        obj.arap.controls.clear()
        self.assertFalse(shows(obj))
        module("scene.pose_key").ensure(obj)
        self.assertTrue(shows(obj))
        for name in ("show_pins", "show_handles", "show_strain"):
            setattr(obj.arap.overlay, name, False)
        self.assertFalse(shows(obj))

    def test_a_stroke_of_weights_reads_the_pins_once_it_has_ended_and_nothing_else(self):
        obj = posable()
        obj.arap.overlay.show_pins = obj.arap.overlay.show_strain = True
        overlay, compat = module("show.overlay"), module("scene.versions")
        reads = []
        plain = self.data.read_pinned
        with (
            mock.patch.object(overlay, "batches"),
            mock.patch.object(compat, "is_painting", return_value=False) as is_painting,
            mock.patch.object(self.data, "read_pinned", side_effect=lambda obj: reads.append(1) or plain(obj)),
        ):
            drawn = overlay._drawn[obj.session_uid] = overlay.Drawn(self.surface(obj))
            self.addCleanup(overlay._drawn.clear)
            batch = overlay.batches.plain_batch

            def draw():
                """How many pins there are."""
                bpy.context.view_layer.update()
                batch.reset_mock()
                drawn.update(obj, bpy.context.evaluated_depsgraph_get())
                points = [call.args[1] for call in batch.call_args_list if call.args[0] == "POINTS"]
                return len(points[0]) if points else None

            obj.arap.overlay.show_handles = False
            bpy.context.view_layer.objects.active = obj
            bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
            overlay._drawn[obj.session_uid] = drawn  # to go there may have been a change
            self.assertEqual((draw(), len(reads)), (len(BOTTOM), 1))
            for is_painting.return_value, added, n_pins, n_reads in (
                (True, MIDDLE[0], len(BOTTOM), 1),
                (True, MIDDLE[1], len(BOTTOM), 1),
                (False, MIDDLE[2], len(BOTTOM) + 3, 2),
            ):
                obj.vertex_groups["Feet"].add([added], 1.0, "REPLACE")
                self.assertEqual((draw(), len(reads)), (n_pins, n_reads))
                self.assertIs(overlay._drawn.get(obj.session_uid), drawn)
            obj.arap.overlay.show_pins = False
            obj.vertex_groups["Feet"].add([MIDDLE[3]], 1.0, "REPLACE")
            self.assertEqual((draw(), len(reads)), (None, 2))
            bpy.ops.object.mode_set(mode="OBJECT")
            obj.vertex_groups["Feet"].add([MIDDLE[4]], 1.0, "REPLACE")
            bpy.context.view_layer.update()
            self.assertEqual(overlay._drawn, {})

    def test_shaders_and_batches_of_this_version_draw(self):
        """Drawn, with its pixels looked at. Older versions draw only in windows, which have their own tests."""
        batches, point_shader = module("ui.batches"), module("scene.versions").POINT_SHADER
        if bpy.app.version < (4, 5, 0):
            self.assertEqual(point_shader, "UNIFORM_COLOR")
            return
        self.begin_drawing()
        for name in ("SMOOTH_COLOR", "POLYLINE_UNIFORM_COLOR", point_shader):
            self.assertIsNotNone(gpu.shader.from_builtin(name))
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float32)
        red = np.tile(np.array([1, 0, 0, 1], dtype=np.float32), (4, 1))
        square = batches.surface_batch(
            corners, red, batches.index_buffer(np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32))
        )
        pixels = self.drawn(lambda: square.draw(gpu.shader.from_builtin("SMOOTH_COLOR")))
        self.assert_close(pixels[SIZE // 2, SIZE // 2], (1.0, 0.0, 0.0, 1.0), 1e-2)

    def begin_drawing(self):
        """Without a window the gpu module works once something was rendered; 5.x can be told."""
        if hasattr(gpu, "init"):
            gpu.init()
            return
        self.scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        self.scene.collection.objects.link(self.scene.camera)
        self.scene.render.engine = "BLENDER_WORKBENCH"
        self.scene.render.resolution_x = self.scene.render.resolution_y = 16
        bpy.ops.render.render()

    def drawn(self, draw):
        """(h, w, 4) of what is drawn in a view from -1 to 1."""
        screen = gpu.types.GPUOffScreen(SIZE, SIZE)
        with screen.bind():
            framebuffer = gpu.state.active_framebuffer_get()
            framebuffer.clear(color=(0.0, 0.0, 0.0, 0.0))
            with gpu.matrix.push_pop():
                gpu.matrix.load_matrix(Matrix.Identity(4))
                gpu.matrix.load_projection_matrix(Matrix.Identity(4))
                draw()
            buffer = framebuffer.read_color(0, 0, SIZE, SIZE, 4, 0, "FLOAT")
        buffer.dimensions = SIZE * SIZE * 4
        screen.free()
        return np.array(buffer.to_list()).reshape(SIZE, SIZE, 4)
