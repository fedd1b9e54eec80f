# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves go along: hair strands, laces and straps beside the tube."""

import numpy as np
from clothes import AttachTest, new_object, sleeve
from looks import key_names
from support import bpy, module
from tubes import PLACED, bend, posable, solved

BACK, AHEAD = np.array([(0.0, 0.0, 0.1), (0.02, 0.0, 0.1)])
HEIGHTS = np.linspace(2.0, 3.8, 6)


def line(side):
    """(6, 3) along the tube, a little beside it."""
    return np.column_stack([np.full(6, side), 0.05 * np.arange(6), HEIGHTS])


def add_spline(curve, kind, places):
    spline = curve.splines.new(kind)
    if kind == "BEZIER":
        spline.bezier_points.add(len(places) - 1)
        for point, place in zip(spline.bezier_points, places, strict=True):
            point.handle_left_type = point.handle_right_type = "FREE"
            point.co, point.handle_left, point.handle_right = place, place - BACK, place + AHEAD
    else:
        spline.points.add(len(places) - 1)
        for point, place in zip(spline.points, places, strict=True):
            point.co = (*place, 1.0)


def strands(kind="POLY", matrix=None, sides=(0.6, -0.6), depth=0.02):
    curve = bpy.data.curves.new("Hair", "CURVE")
    curve.dimensions = "3D"
    curve.bevel_depth = depth
    for side in sides:
        add_spline(curve, kind, line(side))
    return new_object("Hair", curve, matrix)


def patch():
    """A NURBS surface."""
    bpy.ops.surface.primitive_nurbs_surface_surface_add(radius=0.3, location=(0.7, 0.0, 3.0))
    return bpy.context.object


def read(obj, name):
    """(n, 3) coordinates of a shape key, the plain way: points, then left handles, then right ones."""
    data = obj.data.shape_keys.key_blocks[name].data
    fields = ("co", "handle_left", "handle_right") if hasattr(data[0], "handle_left") else ("co",)
    return np.array([getattr(point, field)[:] for field in fields for point in data])


def own_points(obj):
    """As read(), of the splines themselves."""
    groups = [spline.bezier_points or spline.points for spline in obj.data.splines]
    fields = ("co", "handle_left", "handle_right") if obj.data.splines[0].bezier_points else ("co",)
    return np.array([getattr(point, field)[:3] for field in fields for points in groups for point in points])


def drawn(obj):
    """(n, 3) vertices of what Blender shows of the curve."""
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    return np.array([vertex.co[:] for vertex in mesh.vertices])


def distances(points):
    """(n, n) of each from each."""
    return np.linalg.norm(points[:, None] - points[None], axis=2)


class CurveTest(AttachTest):
    def assert_moves(self, curve, by=0.1):
        self.assertGreater(np.abs(read(curve, "ARAP") - read(curve, "Basis")).max(), by)

    def same_points_as_mesh(self, curve):
        mesh = bpy.data.meshes.new("Points")
        mesh.from_pydata(read(curve, "Basis").tolist(), [], [])
        return new_object("Points", mesh, curve.matrix_world.copy())

    def test_every_point_and_handle_goes_where_a_vertex_would(self):
        for kind in ("BEZIER", "POLY", "NURBS", "surface"):
            with self.subTest(kind=kind):
                host = posable(matrix=PLACED)
                curve = patch() if kind == "surface" else strands(kind, PLACED)
                before = drawn(curve)
                self.api.attach(host, [curve])
                self.assertEqual(host.arap.attachments[0].kind, "bend")
                self.api.attach(host, [mesh := self.same_points_as_mesh(curve)])
                bend(host)
                self.api.solve(host)
                self.assert_moves(curve)
                self.assertEqual(self.problem(host), "")
                self.assert_close(read(curve, "ARAP"), read(mesh, "ARAP"), 1e-6)
                self.assertGreater(np.abs(drawn(curve) - before).max(), 0.1)
                self.assertEqual(read(curve, "Basis").tolist(), own_points(curve).tolist())

    def test_of_rigid_curves_each_spline_keeps_its_shape(self):
        host, curve = posable(), strands("BEZIER")
        self.api.attach(host, [curve], "rigid")
        bend(host)
        self.api.solve(host)
        self.assert_moves(curve)
        first = np.tile(np.repeat([True, False], 6), 3)
        for rows, is_kept in ((first, True), (~first, True), (first | ~first, False)):
            rest, posed = (distances(read(curve, name)[rows]) for name in ("Basis", "ARAP"))
            self.assertEqual(np.abs(rest - posed).max() < 1e-5, is_kept)

    def test_the_new_rest_of_the_body_is_that_of_the_curve(self):
        for kind in ("BEZIER", "NURBS"):
            with self.subTest(kind=kind):
                host, curve = solved(), strands(kind)
                self.api.attach(host, [curve])
                posed = read(curve, "ARAP")
                self.api.apply_pose_as_rest(host)
                self.assert_close(read(curve, "Basis"), posed, 0.0)
                self.assert_close(own_points(curve), posed, 0.0)

    def test_an_edited_curve_is_bound_again(self):
        host, curve = solved(), strands("BEZIER")
        self.api.attach(host, [curve])
        bpy.context.view_layer.objects.active = curve
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(self.problem(host), "'Hair' is in Edit Mode: it follows again in Object Mode")
        bpy.ops.curve.select_all(action="SELECT")
        bpy.ops.curve.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
        self.assertEqual(self.problem(host), "")
        self.assertEqual(len(read(curve, "ARAP")), 3 * 2 * 11)
        self.api.attach(host, [mesh := self.same_points_as_mesh(curve)])
        self.assert_close(read(curve, "ARAP"), read(mesh, "ARAP"), 1e-6)

    def test_remove_takes_back_what_was_made(self):
        host, curve = solved(), strands("BEZIER")
        before = own_points(curve)
        self.api.attach(host, [curve])
        self.assertEqual(key_names(curve), ["Basis", "ARAP"])
        self.api.detach(host, curve)
        self.assertIsNone(curve.data.shape_keys)
        self.assert_close(own_points(curve), before, 0.0)

    def test_keys_of_its_own_stay(self):
        host, curve = solved(), strands("BEZIER")
        curve.shape_key_add(name="Basis", from_mix=False)
        key = curve.shape_key_add(name="Curl", from_mix=False)
        key.data[2].handle_left.x += 0.3
        shape = read(curve, key.name)
        self.api.attach(host, [curve])
        self.assert_moves(curve)
        self.assert_close(read(curve, key.name), shape, 0.0)

    def test_splines_of_several_types_are_told(self):
        text = "'Hair' has Bezier splines and others: make them one type (in Edit Mode: Curve > Set Spline Type)"
        host, curve = solved(), strands("BEZIER")
        self.api.attach(host, [curve])
        add_spline(curve.data, "POLY", line(0.7))
        curve.data.update_tag()
        bpy.context.view_layer.update()
        self.assertEqual(self.problem(host), text)
        self.api.solve(host)
        self.assert_error(ValueError, text, self.api.attach, host, [curve])

    def test_splines_that_a_script_has_changed_are_told(self):
        host, curve = solved(), strands("BEZIER")
        self.api.attach(host, [curve])
        for spline in curve.data.splines:
            spline.type = "POLY"
        curve.location.x += 0.1
        bpy.context.view_layer.update()
        text = "The shape keys of 'Hair' do not fit its splines: go to Edit Mode and back"
        self.assertEqual(self.problem(host), text)
        self.assert_error(ValueError, text, self.api.apply_pose_as_rest, host)
        bpy.context.view_layer.objects.active = curve
        for mode in ("EDIT", "OBJECT"):
            bpy.ops.object.mode_set(mode=mode)
        bpy.context.view_layer.update()
        self.assertEqual(self.problem(host), "")
        self.assert_moves(curve)

    def test_what_is_empty_is_told(self):
        host, curve = solved(), new_object("Strap", bpy.data.curves.new("Strap", "CURVE"))
        message = "'Strap' has no points: there is nothing to attach"
        self.assert_error(ValueError, message, self.api.attach, host, [curve])

    def test_a_shared_curve_is_told(self):
        host, curve = solved(), strands()
        new_object("Twin", curve.data)
        message = (
            "The curve of 'Hair' is shared with other objects, which would deform too: make it single-user "
            "(Object > Relations > Make Single User > Object & Data)"
        )
        self.assert_error(ValueError, message, self.api.attach, host, [curve])

    def test_thick_ones_are_found_near_the_body(self):
        host, curve, path = solved(), strands(), strands(depth=0.0)
        self.assertEqual(module("attach.near").find_near(host, bpy.context.view_layer), [curve])
        path.parent = host
        self.assertEqual(module("attach.near").find_near(host, bpy.context.view_layer), [curve])

    def test_they_are_no_pieces_of_a_stand_in_but_go_along_with_it(self):
        pieces, curve = [sleeve(), sleeve(name="Other")], strands()
        message = "'Hair' is no mesh: leave it out, and attach it to the stand-in"
        self.assert_error(ValueError, message, self.api.make_stand_in, [*pieces, curve])
        stand_in = self.api.make_stand_in(pieces)
        self.api.attach(stand_in, [curve])
        self.api.add_handle(stand_in, [0], name="Grip")
        stand_in.arap.handles[0].target.location.x += 1.0
        bpy.context.view_layer.update()
        self.api.solve(stand_in)
        self.assert_moves(curve)
        module("attach.stand_in").remove_stand_in(stand_in)
        self.assertIsNone(curve.data.shape_keys)

    def test_the_panel_of_a_curve_is_that_of_its_body(self):
        host, curve = solved(), strands()
        bpy.context.view_layer.objects.active = curve
        find = module("ui.checks").find_arap_object
        self.assertIsNone(find(bpy.context))
        self.api.attach(host, [curve])
        self.assertEqual(find(bpy.context), host)

    def test_a_ray_of_pull_passes_through_them(self):
        host, curve = solved(), strands(depth=0.0)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        ray = (np.array([5.0, 0.0, 1.0]), np.array([-1.0, 0.0, 0.0]))
        hit = module("pull.ray").cast(host, depsgraph, *ray)
        self.api.attach(host, [curve])
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.assert_close(module("pull.ray").cast(host, depsgraph, *ray).place, hit.place, 0.0)
