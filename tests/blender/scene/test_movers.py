# SPDX-License-Identifier: GPL-3.0-or-later
"""What handles hang on, and what of it does not move here: refused before anything is solved."""

import bpy
from support import SceneTest, module
from tubes import BOTTOM, armature, empty_at, mesh_object, posable

PYTHON = "float(str(frame * 0.1))"  # needs Python, which files may not run unless the user allows it


def driven(obj: bpy.types.ID, path: str, index: int = -1, expression: str = PYTHON) -> bpy.types.Driver:
    driver = obj.driver_add(path, index).driver
    driver.expression = expression
    bpy.context.view_layer.update()
    return driver


def reading(driver: bpy.types.Driver, obj: bpy.types.ID, path: str = "", bone: str = "") -> None:
    """Lets it read a property, or without a path the place of an object or bone."""
    variable = driver.variables.new()
    variable.name, variable.type = "read", "SINGLE_PROP" if path else "TRANSFORMS"
    variable.targets[0].id = obj
    if path:
        variable.targets[0].data_path = path
    variable.targets[0].bone_target = bone
    driver.expression = "read"
    bpy.context.view_layer.update()


class MoversTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.folder = self.new_folder()

    def moved_by(self, target: bpy.types.Object, bone: str = "") -> bpy.types.Object:
        """The tube with a handle for an object or bone."""
        obj = mesh_object()
        self.api.add_pin(obj, BOTTOM, name="Feet")
        obj.arap.controls[self.api.add_handle_for(obj, target, bone, 0.7)].name = "Head"
        return obj

    def linked(self, *names: str) -> list[bpy.types.Object]:
        """Objects of this file, linked from a library into a new one."""
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "library.blend"))
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with bpy.data.libraries.load(str(self.folder / "library.blend"), link=True) as (_, data):
            data.objects = list(names)
        for obj in data.objects:
            bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        return list(data.objects)

    def without_library(self) -> bpy.types.Object:
        """The tube, opened again when the library is gone."""
        path = str(self.folder / "shot.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        (self.folder / "library.blend").unlink()
        bpy.ops.wm.open_mainfile(filepath=path)
        return bpy.data.objects["Tube"]

    def assert_refused(self, obj, reason: str, whose: str = "Handle 'Head' of 'Tube'") -> None:
        """By all that solves, and nothing is written."""
        message = f"{whose} does not move as it should: {reason}"
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2)
        self.assert_error(ValueError, message, self.api.export_mesh_cache, obj, self.folder / "a.pc2", 1, 2)
        self.assert_error(ValueError, message, self.api.solve, obj)
        self.assert_error(ValueError, message, self.api.begin_solve, obj)
        self.assert_error(ValueError, message, self.api.prepare_session, obj)
        self.assertIsNone(obj.data.shape_keys)
        self.assertFalse((self.folder / "a.pc2").exists())

    def assert_missing(self, obj, name: str, whose: str = "Handle 'Head' of 'Tube'") -> None:
        reason = f"'{name}' is missing from //library.blend; bring that file back, or link it again"
        self.assert_refused(obj, reason, whose)

    def assert_moves(self, obj) -> None:
        module("scene.movers.still").check(obj)

    def test_a_handle_of_a_library_that_is_gone(self):
        empty_at((0.0, 0.0, 4.0), "Control")
        (control,) = self.linked("Control")
        self.moved_by(control)
        obj = self.without_library()
        message = (
            "Handle 'Head' of 'Tube': 'Control' is missing from //library.blend; bring that file back, or link it again"
        )
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2)
        message = message.replace("Handle 'Head' of 'Tube'", "'Tube' cannot take the handle")
        self.assert_error(ValueError, message, self.api.add_handle_for, obj, bpy.data.objects["Control"])

    def test_what_the_handle_hangs_on_is_gone(self):
        def parent(empty, control):
            empty.parent = control

        def constraint(empty, control):
            empty.constraints.new("COPY_LOCATION").target = control

        def driver(empty, control):
            reading(driven(empty, "location", 0), control)

        def farther(empty, control):
            between = empty_at((0.0, 0.0, 0.0), "Between")
            between.parent = control
            reading(driven(empty, "location", 0), between)

        for hang in (parent, constraint, driver, farther):
            with self.subTest(hang.__name__):
                bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
                empty_at((0.0, 0.0, 0.0), "Control")
                (control,) = self.linked("Control")
                empty = empty_at((0.0, 0.0, 4.0))
                hang(empty, control)
                self.moved_by(empty)
                self.assert_missing(self.without_library(), "Control")

    def test_the_armature_of_an_armature_constraint_is_gone(self):
        armature()
        (rig,) = self.linked("Rig")
        empty = empty_at((0.0, 0.0, 4.0))
        target = empty.constraints.new("ARMATURE").targets.new()
        target.target, target.subtarget = rig, "Upper"
        self.moved_by(empty)
        self.assert_missing(self.without_library(), "Rig")

    def test_what_the_mesh_hangs_on_is_gone(self):
        empty_at((0.0, 0.0, 0.0), "Control")
        (control,) = self.linked("Control")
        posable().parent = control
        self.assert_missing(self.without_library(), "Control", "'Tube'")

    def test_an_action_or_an_original_of_an_override_is_gone(self):
        empty = empty_at((0.0, 0.0, 4.0), "Control")
        empty.keyframe_insert("location", frame=1)
        empty.animation_data.action.name = "Walk"
        (control,) = self.linked("Control")
        action = control.animation_data.action
        empty = empty_at((0.0, 0.0, 4.0))
        empty.animation_data_create().action = action
        self.moved_by(empty)
        self.assert_missing(self.without_library(), "Walk")
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        empty_at((0.0, 0.0, 4.0), "Control")
        (control,) = self.linked("Control")
        own = control.override_create()
        bpy.context.scene.collection.objects.link(own)
        parented = empty_at((0.0, 0.0, 4.0))
        parented.parent = own
        own.name = "Own"
        self.moved_by(parented)
        self.assert_missing(self.without_library(), "Own")

    if bpy.app.alembic.supported:  # Debian builds Blender without, and no file can move anything there

        def test_the_file_of_a_cached_motion_is_gone(self):
            empty = empty_at((0.0, 0.0, 4.0))
            obj = self.moved_by(empty)
            path = self.folder / "motion.abc"
            bpy.ops.wm.alembic_export(filepath=str(path), start=1, end=2, as_background_job=False)
            bpy.ops.cachefile.open(filepath=str(path))
            constraint = empty.constraints.new("TRANSFORM_CACHE")
            constraint.cache_file, constraint.object_path = bpy.data.cache_files[0], "/Empty"
            bpy.context.view_layer.update()
            self.assert_moves(obj)
            gone = self.folder / "gone.abc"  # on Windows no file is removed that Blender has open
            constraint.cache_file.filepath = str(gone)
            self.assert_refused(obj, f"the file of 'motion.abc', {gone}, is missing; bring it back")

    def test_a_driver_that_may_not_run_python(self):
        obj = posable()
        driven(obj.arap.handles[0].target, "location", 1)
        reason = (
            f"the driver of 'location' of 'Head' needs Python ({PYTHON}), which may not run; allow scripts "
            "(--enable-autoexec on the command line)"
        )
        self.assert_refused(obj, reason)
        obj.arap.handles[0].is_enabled = False
        self.assert_moves(obj)

    def test_a_driver_of_what_the_handle_hangs_on(self):
        control, empty = empty_at((0.0, 0.0, 0.0), "Control"), empty_at((0.0, 0.0, 4.0))
        control["turn"] = 0.0
        driver = driven(control, '["turn"]')
        reading(driven(empty, "location", 0), control, '["turn"]')
        obj = self.moved_by(empty)
        with self.assertRaisesRegex(ValueError, r"""the driver of '\["turn"\]' of 'Control' needs Python"""):
            self.api.solve(obj)
        driver.expression = "frame"
        bpy.context.view_layer.update()
        self.assert_moves(obj)
        reading(driver, control, "nothing")
        reason = """the driver of '["turn"]' of 'Control' does not work; mend or remove it"""
        self.assert_refused(obj, reason)

    def test_drivers_that_do_not_move_the_handle_do_not_matter(self):
        obj = posable()
        target = obj.arap.handles[0].target
        for path in ("hide_viewport", "empty_display_size"):
            driven(target, path)
        constraint = target.constraints.new("COPY_LOCATION")
        constraint.target, constraint.mute = empty_at((0.0, 0.0, 0.0), "Control"), True
        driven(constraint.target, "location", 0)
        self.assert_moves(obj)
        constraint.mute = False
        self.assertRaises(ValueError, self.assert_moves, obj)

    def test_a_rig_in_edit_mode_or_rest_position(self):
        rig = armature()
        obj = self.moved_by(rig, "Upper")
        self.assert_moves(obj)
        rig.data.pose_position = "REST"
        self.assert_refused(obj, "armature 'Rig' shows its rest position; set it to Pose Position")
        rig.data.pose_position = "POSE"
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        self.assert_refused(obj, "armature 'Rig' is in Edit Mode; go back to Object Mode first")

    def test_a_rig_of_which_only_the_object_counts(self):
        rig = armature()
        rig.data.pose_position = "REST"
        empty = empty_at((0.0, 0.0, 4.0))
        empty.parent = rig
        obj = self.moved_by(empty)
        self.assert_moves(obj)
        empty.parent_type, empty.parent_bone = "BONE", "Upper"
        self.assertRaises(ValueError, self.assert_moves, obj)

    def test_bones_that_a_bone_does_not_hang_on_do_not_matter(self):
        rig = armature()
        obj = self.moved_by(rig, "Lower")
        control = empty_at((0.0, 0.0, 5.0), "Control")
        driven(control, "location", 0)
        constraint = rig.pose.bones["Upper"].constraints.new("COPY_ROTATION")
        constraint.target = control
        self.assert_moves(obj)
        rig.pose.bones["Upper"].constraints.remove(constraint)
        constraint = rig.pose.bones["Upper"].constraints.new("IK")  # moves its parents, too
        constraint.target = control
        self.assertRaises(ValueError, self.assert_moves, obj)
        constraint.target, constraint.pole_target = empty_at((0.0, 1.0, 5.0), "Sound"), control
        self.assertRaises(ValueError, self.assert_moves, obj)
        constraint.chain_count = 1
        self.assert_moves(obj)

    def test_what_moves_handles_is_found_through_every_constraint_and_driver(self):
        rig, obj = armature(), posable()
        names = ["Pole", "Goal", "Read", "Above"]
        pole, goal, read, above = (empty_at((0.0, 0.0, 0.0), name) for name in names)
        bone = obj.arap.handles[0].target.constraints.new("ARMATURE").targets.new()
        bone.target, bone.subtarget = rig, "Lower"
        reach = rig.pose.bones["Upper"].constraints.new("IK")
        reach.target, reach.pole_target = goal, pole
        reading(driven(goal, "location", 0), read)
        read.parent = above
        movers = module("scene.movers.chain").transform_sources(obj, obj.arap.handles)
        self.assertEqual({mover.name for mover in movers}, {"Head", "Rig", *names})

    def test_a_circle_of_constraints_ends(self):
        first, second = empty_at((0.0, 0.0, 4.0), "First"), empty_at((0.0, 0.0, 5.0), "Second")
        first.constraints.new("COPY_LOCATION").target = second
        second.constraints.new("COPY_LOCATION").target = first
        obj = self.moved_by(first)
        self.assert_moves(obj)
        self.assertEqual(len(module("scene.movers.chain").transform_sources(obj, obj.arap.handles)), 2)
