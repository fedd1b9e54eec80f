# SPDX-License-Identifier: GPL-3.0-or-later
"""What the monkey does: each act a function of the monkey. ACTS says how often each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from mathutils import Matrix

if TYPE_CHECKING:
    from monkey import Monkey

NAN = float("nan")
NAMES = ["Tube", "Ünïcode ✓", "名前" * 12, "a" * 63, "x.y/..", "\"q'", "Tube.001"]
MODES = ["EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT"]
MODIFIERS = ["SUBSURF", "ARRAY", "MIRROR", "SOLIDIFY", "NODES", "ARMATURE", "DECIMATE", "MESH_CACHE", "LATTICE", "WELD"]
CONSTRAINTS = ["COPY_LOCATION", "CHILD_OF", "TRACK_TO", "FOLLOW_PATH", "SHRINKWRAP"]
EXPRESSIONS = ["var", "var/0", "frame/0", "nope", 'float("nan")', "var*1e30"]
MOST_MESHES, MOST_OBJECTS = 5, 25
IDENTITY = Matrix.Identity(4)

Act = Callable[["Monkey"], None]


def changes_rest(act: Act) -> Act:
    """Marks an act that may change rest shapes, or which mesh has a name."""
    act.changes_rest = True
    return act


def add_on(act: Act) -> Act:
    """Marks an act that needs the add-on."""
    act.needs_add_on = True
    return act


# ---------------------------------------------------------------------------------------------------- meshes


@changes_rest
def new_mesh(monkey: Monkey) -> None:
    if len(monkey.meshes()) >= MOST_MESHES:
        return
    name = monkey.choice(NAMES)
    if monkey.is_control:
        monkey.tubes.mesh_object(name)
        monkey.tubes.empty_at((0, 0, 4), "Head")
        return
    kind = monkey.random.randrange(5)
    if kind <= 2:
        monkey.tubes.posable(name)
        return
    if kind == 3:
        bpy.ops.mesh.primitive_uv_sphere_add(segments=monkey.choice([8, 16, 64]), ring_count=monkey.choice([6, 12, 48]))
    else:
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=monkey.choice([2, 20, 80]), y_subdivisions=20)
    obj = bpy.context.object
    n = len(obj.data.vertices)
    monkey.api.add_pin(obj, range(n // 5))
    monkey.api.add_handle(obj, range(n - n // 8, n) if kind == 3 else [n - 1], name="H")


@changes_rest
def duplicate(monkey: Monkey) -> None:
    if len(bpy.data.objects) > MOST_OBJECTS:
        return
    obj = monkey.mesh()
    copy = obj.copy()
    if monkey.random.random() < 0.7:
        copy.data = obj.data.copy()
    bpy.context.scene.collection.objects.link(copy)


@changes_rest
def delete(monkey: Monkey) -> None:
    obj = monkey.choice(bpy.data.objects)
    if len(monkey.meshes()) > 1 or obj.type != "MESH":
        bpy.data.objects.remove(obj)


@changes_rest
def join(monkey: Monkey) -> None:
    """Not of flat, huge or lost meshes, of which Blender itself makes NaN, nor of keys, at which 5.2 hangs."""
    meshes = [obj for obj in monkey.meshes() if 1e-6 < abs(obj.matrix_world.determinant()) < 1e9]
    if bpy.app.version >= (5, 0):
        meshes = [obj for obj in meshes if obj.data.shape_keys is None]
    if len(meshes) > 2:
        monkey.select(*monkey.random.sample(meshes, 2))
        bpy.ops.object.join()


@changes_rest
def separate(monkey: Monkey) -> None:
    if len(monkey.meshes()) < MOST_MESHES:
        in_edit_mode(monkey, lambda: bpy.ops.mesh.separate(type="SELECTED"))


@changes_rest
def edit_faces(monkey: Monkey) -> None:
    edits: list[Callable[[], Any]] = [
        lambda: bpy.ops.mesh.subdivide(number_cuts=1),
        lambda: bpy.ops.mesh.delete(type="VERT"),
        lambda: bpy.ops.mesh.delete(type="ONLY_FACE"),
        bpy.ops.mesh.extrude_region,
        lambda: bpy.ops.mesh.merge(type="CENTER"),
    ]
    in_edit_mode(monkey, monkey.choice(edits))


def in_edit_mode(monkey: Monkey, edit: Callable[[], Any]) -> None:
    monkey.select(monkey.mesh())
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.mesh.select_random(ratio=0.05)
        edit()
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


@add_on
@changes_rest
def act_in_another_mode(monkey: Monkey) -> None:
    monkey.select(monkey.mesh())
    bpy.ops.object.mode_set(mode=monkey.choice(MODES))
    for _ in range(monkey.random.randint(0, 3)):
        monkey.choice([solve, move, change_frame, toggle_follow, bake_pose, reset_pose, store_pose])(monkey)


def modifiers(monkey: Monkey) -> None:
    obj = monkey.mesh()
    if len(obj.modifiers) < 3:
        obj.modifiers.new("m", monkey.choice(MODIFIERS))
    elif monkey.random.random() < 0.5:
        obj.modifiers.clear()


@changes_rest
def apply_modifier(monkey: Monkey) -> None:
    obj = monkey.mesh()
    modifier = monkey.choice(obj.modifiers)
    monkey.select(obj)
    bpy.ops.object.modifier_apply(modifier=modifier.name)


@changes_rest
def apply_transform(monkey: Monkey) -> None:
    monkey.select(monkey.mesh())
    bpy.ops.object.transform_apply()


# ---------------------------------------------------------------------------------------------------- shape keys


@changes_rest
def add_key(monkey: Monkey) -> None:
    """In Object Mode. A step of undo of Edit Mode holds no new key, and Blender itself crashes when it is undone."""
    monkey.to_object_mode()
    monkey.mesh().shape_key_add(name=monkey.choice(["K", "ARAP", "Basis"]), from_mix=monkey.random.random() < 0.3)


def keys_of(monkey: Monkey) -> Any:
    """Not of a library: as with Monkey.moved_by()."""
    keys = monkey.mesh().data.shape_keys
    return keys.key_blocks if keys and keys.library is None else []


def change_key(monkey: Monkey) -> None:
    keys = keys_of(monkey)
    key = monkey.choice(keys)
    changes: list[Callable[[], Any]] = [
        lambda: setattr(key, "name", monkey.choice(["ARAP", "Z", "Basis", "ARAP_0001"])),
        lambda: setattr(key, "mute", not key.mute),
        lambda: setattr(key, "relative_key", monkey.choice(keys)),
        lambda: setattr(key, "vertex_group", monkey.choice(["", "Head", "none"])),
        lambda: setattr(key, "value", monkey.random.random()),
        lambda: key.keyframe_insert("value", frame=3),
    ]
    monkey.choice(changes)()


def remove_key(monkey: Monkey) -> None:
    obj = monkey.mesh()
    key = monkey.choice(obj.data.shape_keys.key_blocks if obj.data.shape_keys else ())
    if key != obj.data.shape_keys.reference_key:
        # In Blender 4.5 this call, unlike the button, takes a driver away from under the evaluation, and that crashes.
        obj.data.shape_keys.driver_remove(f'key_blocks["{bpy.utils.escape_identifier(key.name)}"].value')
        obj.shape_key_remove(key)


@changes_rest
def move_key(monkey: Monkey) -> None:
    obj = monkey.mesh()
    if obj.data.shape_keys:
        monkey.select(obj)
        obj.active_shape_key_index = monkey.random.randrange(len(obj.data.shape_keys.key_blocks))
        bpy.ops.object.shape_key_move(type=monkey.choice(["TOP", "UP", "DOWN", "BOTTOM"]))


@changes_rest
def absolute_keys(monkey: Monkey) -> None:
    keys = monkey.mesh().data.shape_keys
    if keys:
        keys.use_relative = not keys.use_relative


# ---------------------------------------------------------------------------------------------------- handles' objects


def move(monkey: Monkey) -> None:
    monkey.tubes.move(monkey.handle(), monkey.vector(1), monkey.vector(1))


def move_wildly(monkey: Monkey) -> None:
    """To where no mesh can follow, for a few acts."""
    name = monkey.handle().name
    places: list[tuple[str, Any]] = [
        ("scale", (0, 0, 0)), ("scale", (-1, 1, 1)), ("scale", (1e-20, 1, 1)), ("location", (1e3, 0, 0)),
        ("location", (float("inf"), 0, 0)), ("location", (1e30, 0, 0)), ("location", (NAN, 0, 0)),
        ("rotation_euler", (1e20, 0, 0)), ("matrix_world", Matrix(((NAN,) * 4,) * 4)),
    ]  # fmt: skip
    setattr(bpy.data.objects[name], *monkey.choice(places))
    bpy.context.view_layer.update()

    def calm() -> None:
        obj = bpy.data.objects[name]
        obj.matrix_basis = IDENTITY
        obj.location = (monkey.random.uniform(-1, 1), 0, 4)

    monkey.soon(calm)


def scale_wildly(monkey: Monkey) -> None:
    obj = monkey.mesh()
    name = obj.name
    obj.scale = monkey.choice([(0, 1, 1), (-1, 1, 1), (1e-9, 1e-9, 1e-9), (1e6, 1, 1), (NAN, 1, 1), (0, 0, 0)])
    bpy.context.view_layer.update()
    monkey.soon(lambda: setattr(bpy.data.objects[name], "scale", (1, 1, 1)))


def keyframe(monkey: Monkey) -> None:
    handle = monkey.handle()
    for frame in (1, 5):
        handle.location.z += monkey.random.uniform(-0.5, 0.5)
        handle.keyframe_insert("location", frame=frame)


def constrain(monkey: Monkey) -> None:
    handle = monkey.handle()
    name = handle.name
    constraint = handle.constraints.new(monkey.choice(CONSTRAINTS))
    if constraint.type != "FOLLOW_PATH":
        constraint.target = monkey.choice(bpy.data.objects)
    bpy.context.view_layer.update()
    monkey.soon(lambda: clear_constraints(name))


def clear_constraints(name: str) -> None:
    bpy.data.objects[name].constraints.clear()


def drive(monkey: Monkey) -> None:
    handle = monkey.handle()
    name = handle.name
    driver = handle.driver_add("location", 2).driver
    target = driver.variables.new().targets[0]
    target.id = monkey.choice(bpy.data.objects)
    target.data_path = "location.x"
    driver.expression = monkey.choice(EXPRESSIONS)
    bpy.context.view_layer.update()
    monkey.soon(lambda: bpy.data.objects[name].driver_remove("location"))


def parent(monkey: Monkey) -> None:
    child = monkey.choice(bpy.data.objects)
    child.parent = monkey.choice(bpy.data.objects)
    bpy.context.view_layer.update()
    if monkey.random.random() < 0.7:
        child.parent = None


# ---------------------------------------------------------------------------------------------------- scenes and files


def undo(monkey: Monkey) -> None:
    if bpy.ops.ed.undo.poll():
        bpy.ops.ed.undo()


def redo(monkey: Monkey) -> None:
    if bpy.ops.ed.redo.poll():
        bpy.ops.ed.redo()


undo, redo = changes_rest(undo), changes_rest(redo)


def change_frame(monkey: Monkey) -> None:
    bpy.context.scene.frame_set(monkey.random.randint(-5, 20))


@changes_rest
def rename(monkey: Monkey) -> None:
    monkey.choice(bpy.data.objects).name = monkey.choice(NAMES)


def rename_group(monkey: Monkey) -> None:
    monkey.choice(monkey.mesh().vertex_groups).name = monkey.choice(["Head", "Feet", "G", "Ü"])


def delete_group(monkey: Monkey) -> None:
    obj = monkey.mesh()
    group = monkey.choice(obj.vertex_groups)
    if monkey.random.random() < 0.5:
        obj.vertex_groups.remove(group)


def hide(monkey: Monkey) -> None:
    obj = monkey.choice(bpy.data.objects)
    obj.hide_viewport = not obj.hide_viewport


def show_all(monkey: Monkey) -> None:
    for obj in bpy.data.objects:
        if obj.library is None:
            obj.hide_viewport = False


def save(monkey: Monkey) -> None:
    path = monkey.folder / monkey.choice(["m.blend", "Ü ✓.blend"])
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=monkey.random.random() < 0.3)


@changes_rest
def load(monkey: Monkey) -> None:
    path = monkey.folder / "m.blend"
    if path.exists():
        bpy.ops.wm.open_mainfile(filepath=str(path))


@changes_rest
def change_scene(monkey: Monkey) -> None:
    others = [scene for scene in bpy.data.scenes if scene != bpy.context.scene]
    if len(others) > 1:
        bpy.data.scenes.remove(monkey.choice(others))
    elif others and monkey.random.random() < 0.6:
        bpy.context.window.scene = monkey.choice(others)
    else:
        bpy.ops.scene.new(type=monkey.choice(["NEW", "LINK_COPY", "FULL_COPY", "EMPTY"]))


@changes_rest
def link_library(monkey: Monkey) -> None:
    path = monkey.folder / "m.blend"
    if not path.exists() or len(bpy.data.objects) > MOST_OBJECTS:
        return
    with bpy.data.libraries.load(str(path), link=monkey.random.random() < 0.6) as (there, here):
        here.objects = there.objects[:2]
    for obj in filter(None, here.objects):
        bpy.context.scene.collection.objects.link(obj)
        if obj.library and monkey.random.random() < 0.4:
            obj.override_create(remap_local_usages=True)


def render(monkey: Monkey) -> None:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.cycles.samples, scene.cycles.device, scene.cycles.use_denoising = 1, "CPU", False
    if not scene.camera:
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
    scene.render.filepath = str(monkey.folder / "r")
    scene.frame_start, scene.frame_end = 1, monkey.choice([1, 2])
    bpy.ops.render.render(animation=monkey.random.random() < 0.5)


def purge(monkey: Monkey) -> None:
    bpy.data.orphans_purge()


# ---------------------------------------------------------------------------------------------------- the add-on


@add_on
def operator(monkey: Monkey) -> None:
    monkey.select(monkey.mesh())
    name = monkey.choice(dir(bpy.ops.arap))
    print(monkey.step, "  ", name, file=monkey.trace, flush=True)
    act = getattr(bpy.ops.arap, name)
    if act.poll():
        act("EXEC_DEFAULT")


operator = changes_rest(operator)


@add_on
def solve(monkey: Monkey) -> None:
    monkey.api.solve(monkey.mesh())


@add_on
def bake_pose(monkey: Monkey) -> None:
    monkey.api.bake_pose(monkey.mesh(), name=monkey.choice(["P", "ARAP", "Basis", "Ü" * 40, ""]))


@add_on
def reset_pose(monkey: Monkey) -> None:
    monkey.choice([monkey.api.reset_pose, monkey.api.reset_handles])(monkey.mesh())


@add_on
@changes_rest
def pose_as_rest(monkey: Monkey) -> None:
    monkey.api.apply_pose_as_rest(monkey.mesh())


@add_on
def bake_animation(monkey: Monkey) -> None:
    left = monkey.random.randint(0, 40)

    def progress(_: float) -> bool | None:
        nonlocal left
        left -= 1
        return left > 0

    monkey.api.bake_animation(
        monkey.mesh(), 1, monkey.random.randint(1, 6), monkey.choice([1, 2]), progress=monkey.choice([None, progress])
    )


@add_on
def bake_that_raises(monkey: Monkey) -> None:
    """It leaves no keys."""
    obj = monkey.mesh()
    left = monkey.random.randint(0, 12)

    class Stop(Exception):
        pass

    def progress(_: float) -> None:
        nonlocal left
        left -= 1
        if left < 0:
            raise Stop

    def names() -> set[str]:
        return {key.name for key in obj.data.shape_keys.key_blocks} if obj.data.shape_keys else set()

    before = names()
    try:
        monkey.api.bake_animation(obj, 1, 5, progress=progress)
    except Stop:
        if names() != before:
            monkey.fail("keys left by a bake that raised", names() ^ before)


@add_on
def export(monkey: Monkey) -> None:
    folder = monkey.folder
    paths = [
        folder / "c.mdd", folder / "c.pc2", folder / ".." / folder.name / "Ü ✓.mdd", Path("/proc/x.mdd"), folder,
        folder / "no/such.mdd", Path("/dev/full"), Path("//c.mdd"), folder / "a.txt",
    ]  # fmt: skip
    monkey.api.export_mesh_cache(monkey.mesh(), monkey.choice(paths), 1, monkey.random.randint(1, 5))


@add_on
def toggle_follow(monkey: Monkey) -> None:
    obj = monkey.mesh()
    obj.arap.use_follow = not obj.arap.use_follow
    bpy.context.view_layer.update()


@add_on
def change_target(monkey: Monkey) -> None:
    handle = monkey.choice(monkey.mesh().arap.handles)
    handle.target = monkey.choice([*bpy.data.objects, None])
    handle.bone = monkey.choice(["", "B"])


@add_on
def new_handle(monkey: Monkey) -> None:
    obj = monkey.mesh()
    n = len(obj.data.vertices)
    vertices = [monkey.choice([0, 1, n - 1, n, -1, 10**9]) for _ in range(monkey.random.randint(0, 3))]
    monkey.api.add_handle(
        obj, vertices, name=monkey.choice(["H", "", "Ü" * 40]), use_exact=monkey.random.random() < 0.5
    )


@add_on
def new_pin(monkey: Monkey) -> None:
    obj = monkey.mesh()
    monkey.api.add_pin(obj, [monkey.random.randrange(len(obj.data.vertices)) for _ in range(3)])


@add_on
def remove_control(monkey: Monkey) -> None:
    obj = monkey.mesh()
    if len(obj.arap.handles) > 1:
        monkey.api.remove_control(obj, monkey.choice([*(control.name for control in obj.arap.controls), "None"]))


@add_on
def stiffen(monkey: Monkey) -> None:
    obj = monkey.mesh()
    n = len(obj.data.vertices)
    vertices = [monkey.random.randrange(n) for _ in range(n // 3)]
    monkey.choice([monkey.api.add_rigid, monkey.api.add_stiffness])(obj, vertices)


@add_on
def soften(monkey: Monkey) -> None:
    monkey.mesh().arap.stiffness.clear()


@add_on
def change_setting(monkey: Monkey) -> None:
    values: dict[str, list[Any]] = {
        "energy": ["rotation_nodes", "spokes", "spokes_and_rims"], "rigidity": [0.1, 2, 100],
        "weights": ["uniform", "cotangent"], "use_weld": [True, False], "accuracy": [1e-9, 0.1, 1e-6],
        "max_iterations": [1, 50, 200], "use_loose_parts": [True, False],
    }  # fmt: skip
    name = monkey.choice(values)
    setattr(monkey.mesh().arap, name, monkey.choice(values[name]))


@add_on
def store_pose(monkey: Monkey) -> None:
    monkey.api.store_pose(monkey.mesh(), monkey.choice(["A", "B", "Ü" * 40, ""]))


@add_on
def use_pose(monkey: Monkey) -> None:
    obj = monkey.mesh()
    name = monkey.choice(obj.arap.poses).name
    api = monkey.api
    uses: list[Callable[[], Any]] = [
        lambda: api.apply_pose(obj, name),
        lambda: api.blend_poses(obj, name, monkey.choice([0, 0.5, 1, -3, 100, NAN])),
        lambda: api.mirror_pose(obj, name),
        lambda: api.delete_pose(obj, name),
        lambda: api.poses_to_keys(obj),
    ]
    monkey.choice(uses)()


@add_on
def use_session(monkey: Monkey) -> None:
    monkey.choice([monkey.api.prepare_session, monkey.api.update_pose])(monkey.mesh())


@add_on
def attach(monkey: Monkey) -> None:
    body = monkey.mesh()
    others = [obj for obj in monkey.meshes() if obj != body]
    monkey.api.attach(body, [monkey.choice(others)], monkey.choice(["", "bend", "rigid"]))


@add_on
def make_stand_in(monkey: Monkey) -> None:
    stand_ins = [obj for obj in monkey.meshes() if obj.arap.is_stand_in]
    if stand_ins and monkey.random.randrange(2):
        monkey.api.remove_stand_in(monkey.choice(stand_ins))
    else:
        pieces = monkey.random.sample(list(monkey.meshes()), 2)
        monkey.api.make_stand_in(pieces, monkey.choice([50, 200_000]))


@add_on
def change_follower(monkey: Monkey) -> None:
    body = monkey.choice(obj for obj in monkey.meshes() if obj.arap.attachments)
    attachment = monkey.choice(body.arap.attachments)
    kind = monkey.random.randrange(4)
    if kind == 0:
        attachment.is_enabled = not attachment.is_enabled
    elif kind == 1:
        attachment.kind = "bend" if attachment.kind == "rigid" else "rigid"
    elif kind == 2:
        attachment.object = monkey.choice(bpy.data.objects)
    else:
        monkey.api.detach(body, attachment.object)


def tried(act: Act, monkey: Monkey) -> None:
    try:
        act(monkey)
    except (ValueError, RuntimeError):
        return


@add_on
def act_beside_a_job(monkey: Monkey) -> None:
    """A solve in steps, and other acts on the same mesh between its steps."""
    obj = monkey.mesh()
    job = monkey.api.begin_solve(obj)
    try:
        for act in (solve, bake_animation, toggle_follow, move, change_frame):
            tried(act, monkey)
        for _ in range(3):
            if not job.step():
                job.finish()
                return
    finally:
        job.cancel()


ACTS: dict[Act, int] = {
    operator: 12, move: 10, undo: 6, solve: 5, change_frame: 5, attach: 4, toggle_follow: 4, use_pose: 4,
    use_session: 4, make_stand_in: 3, new_mesh: 3, redo: 3, bake_animation: 3, change_setting: 3, store_pose: 2,
    export: 2, keyframe: 2, change_key: 2, show_all: 2,
} | dict.fromkeys([
    duplicate, delete, join, separate, edit_faces, act_in_another_mode, modifiers, apply_modifier, add_key, remove_key,
    move_key, absolute_keys, move_wildly, scale_wildly, constrain, drive, parent, rename, rename_group, delete_group,
    hide, save, load, change_scene, link_library, render, purge, bake_pose, reset_pose, pose_as_rest, bake_that_raises,
    change_target, new_handle, new_pin, remove_control, stiffen, soften, act_beside_a_job, change_follower,
    apply_transform,
], 1)  # fmt: skip
