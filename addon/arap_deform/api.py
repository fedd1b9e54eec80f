# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Deform for scripts. Every function works on data, with or without a window, and never through selection.

    import bpy
    from bl_ext.user_default.arap_deform import api

    obj = bpy.data.objects["Creature"]
    api.add_pin(obj, range(0, 40), name="Feet")
    tail = api.add_handle(obj, [501, 502, 503], name="Tail")
    obj.arap.controls[tail].target.location.z += 0.5
    print(api.solve(obj))
    api.bake_pose(obj, name="Tail up")

What stays, what moves, what is stiff:

- add_pin(), add_pin_group(): vertices, or a vertex group, that stay where they are.
- add_handle(), add_handle_for(): vertices that follow a new empty, or an object or bone.
- add_bones(): bones of an armature move what they pass through inside the mesh, without vertex groups.
- remove_control(): one of these.
- copy_handles(): gives a copied mesh handles of its own, instead of those of the original.
- add_stiffness(), add_stiffness_group(), add_rigid(), remove_stiffness(): vertices that bend less, or not at all.
- soften_group(): gives a vertex group a soft edge.

What follows the mesh:

- attach(), detach(): clothes, hair and eyes follow a mesh however it is posed.
- make_stand_in(), remove_stand_in(): several meshes are posed as one, through a stand-in.
- make_cage(): a coarse closed mesh around the mesh, which moves all of it with Blender's Mesh Deform.

A pose:

- solve(): poses the mesh for the handles where they are now. begin_solve() does the same in steps.
- prepare_session(), then update_pose() whenever the handles have moved: a few iterations at a time, for live use.
  end_session() gives their memory back.
- reset_handles(), reset_pose(): the handles, or the mesh, back to rest.
- apply_pose_as_rest(): makes the pose the rest shape.
- bake_pose(): copies the pose to a shape key of its own.

Stored poses:

- store_pose(), delete_pose(): where the handles are, by a name.
- apply_pose(), blend_poses(), mirror_pose(): move the handles to stored poses, NOW and REST, or make a mirror image.
- poses_to_keys(): makes a shape key of each.

An animation of the handles:

- bake_animation(): to shape keys with keyframes.
- export_mesh_cache(): to an MDD or PC2 file.

Vertices are indices: a sequence or an integer array. Matrices are world matrices of evaluated objects, so parents,
constraints, drivers and animation count. Objects must be in Object Mode and their mesh must be local and used once.

Errors: ``ValueError`` if the scene or an argument is wrong. ``RuntimeError`` if the solver or the module is, or if
something else has the mesh for itself just now: an interaction, or the job of a solve, a bake or an export.
``MemoryError`` if the mesh needs more memory than there is, ``Cancelled`` (a RuntimeError) if ``progress`` returned
False; in both cases everything is as it was before the call. Each message is one sentence that says what to do.

``progress`` is called with the fraction done, 0 to 1; it stops the call by returning False.

Everything else in the add-on is free to change from one version to the next.
"""

from .attach.attachments import attach, detach
from .attach.cage import make_cage
from .attach.stand_in import make_stand_in, remove_stand_in
from .bake.cache import export_mesh_cache
from .bake.keys import bake_animation
from .core.background import Cancelled
from .engine.update import end_session, prepare_session, update_pose
from .pose.result import apply_pose_as_rest, bake_pose, reset_pose
from .pose.solve import begin_solve, solve
from .poses.keys import poses_to_keys
from .poses.library import NOW, REST, apply_pose, blend_poses, delete_pose, mirror_pose, store_pose
from .scene.placing import reset_handles
from .setup.bones import add_bones
from .setup.controls import remove_control
from .setup.handle_copies import copy_handles
from .setup.handles import add_handle, add_handle_for
from .setup.pins import add_pin, add_pin_group
from .setup.stiffness import add_rigid, add_stiffness, add_stiffness_group, remove_stiffness, soften_group

__all__ = [
    "NOW",
    "REST",
    "Cancelled",
    "add_bones",
    "add_handle",
    "add_handle_for",
    "add_pin",
    "add_pin_group",
    "add_rigid",
    "add_stiffness",
    "add_stiffness_group",
    "apply_pose",
    "apply_pose_as_rest",
    "attach",
    "bake_animation",
    "bake_pose",
    "begin_solve",
    "blend_poses",
    "copy_handles",
    "delete_pose",
    "detach",
    "end_session",
    "export_mesh_cache",
    "make_cage",
    "make_stand_in",
    "mirror_pose",
    "poses_to_keys",
    "prepare_session",
    "remove_control",
    "remove_stand_in",
    "remove_stiffness",
    "reset_handles",
    "reset_pose",
    "soften_group",
    "solve",
    "store_pose",
    "update_pose",
]
