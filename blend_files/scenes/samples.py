# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample scenes: models, pins, handles, motion and studio of each. Runs in Blender with the add-on registered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, degrees, radians, sin
from types import ModuleType

import bpy

from . import blender_scene as scenes
from .bar import SIZE, bar, bar_groups
from .blender_scene import LAST_FRAME, Finish, Move
from .cactus import TOP, cactus, cactus_groups, flower, pot
from .creature import creature, creature_groups
from .figure import figure, figure_groups
from .figure_clothes import belt, buttons, shirt
from .figure_head import eyes, hair, smile
from .quad_mesh import Ints

FUR = Finish("Fur", None, roughness=0.65, specular=0.2)
EYES = Finish("Eyes", (0.012, 0.010, 0.012), roughness=0.05, specular=0.6)
NOSE = Finish("Nose", (0.030, 0.020, 0.020), roughness=0.25, specular=0.5)

# What the handles turn around: neck, shoulder, root of the tail, root of the ear.
CREATURE_PIVOTS = {
    "Head": (0.0, -0.46, 0.95),
    "Paw front L": (0.19, -0.24, 0.42),
    "Tail": (0.0, 0.55, 0.68),
    "Ear L": (0.32, -0.58, 1.40),
}
CREATURE_MOVES = {
    "Head": (
        Move(1),
        Move(7, (7, 0, 0), (0.0, -0.01, -0.03)),
        Move(16, (-4, -9, 24), (0.0, 0.02, 0.02)),
        Move(24, (-3, -14, 31), (0.0, 0.02, 0.03)),
        Move(32, (2, -13, 29), (0.0, 0.02, 0.02)),
        Move(40, (-5, -15, 32), (0.0, 0.02, 0.03)),
        Move(48, (-4, -15, 32), (0.0, 0.02, 0.03)),
    ),
    "Paw front L": (
        Move(1),
        Move(6),
        Move(15, (-54, 0, 0), (0.03, -0.03, 0.03), (-10, 0, 0)),
        Move(21, (-76, 0, 14), (0.05, -0.04, 0.04), (-12, 0, 0)),
        Move(27, (-58, 0, 2), (0.03, -0.03, 0.03), (-10, 0, 0)),
        Move(33, (-78, 0, 16), (0.05, -0.04, 0.04), (-12, 0, 0)),
        Move(39, (-60, 0, 4), (0.03, -0.03, 0.03), (-10, 0, 0)),
        Move(48, (-74, 0, 12), (0.05, -0.04, 0.04), (-12, 0, 0)),
    ),
    "Tail": (
        Move(1),
        Move(9, (0, -16, 0), tilt=(0, -14, 0)),
        Move(17, (0, 18, 0), tilt=(0, 18, 0)),
        Move(25, (0, -14, 0), tilt=(0, -12, 0)),
        Move(33, (0, 20, 0), tilt=(0, 22, 0)),
        Move(42, (4, 26, -6), tilt=(0, 34, 0)),
        Move(48, (4, 25, -6), tilt=(0, 32, 0)),
    ),
    "Ear L": (
        Move(1),
        Move(26),
        Move(29, (0, 20, 0)),
        Move(32, (0, -5, 0)),
        Move(35, (0, 16, 0)),
        Move(42, (12, 32, 0)),
        Move(48, (12, 30, 0)),
    ),
}


def make_creature(api: ModuleType) -> bpy.types.Object:
    """The fox cub: it looks aside, lifts a paw and curls its tail."""
    scene = scenes.empty_file()
    mesh = creature()
    obj = scenes.mesh_object("Creature", mesh, (FUR, EYES, NOSE))
    groups = creature_groups(mesh)
    pins = ("Paw front R", "Paw hind L", "Paw hind R")
    handles = _bind(api, obj, groups, pins, tuple(CREATURE_MOVES))
    # The ear rides on the head: its empty turns with the head's.
    _parent(handles["Ear L"], handles["Head"])
    for name, moves in CREATURE_MOVES.items():
        scenes.animate(handles[name], moves, CREATURE_PIVOTS[name])
    scenes.studio(scene, (0.20, 0.42, 0.40), (0.0, -0.03, 0.86), (3.0, -5.0, 1.75), lens=77.0)
    return obj


SKIN = Finish("Skin", None, roughness=0.55)
CLAY = Finish("Clay", (0.50, 0.17, 0.08), roughness=0.8)
SOIL = Finish("Soil", (0.055, 0.032, 0.022), roughness=0.95)
PETALS = Finish("Petals", (0.85, 0.13, 0.30), roughness=0.5)
HEART = Finish("Heart", (0.95, 0.60, 0.10), roughness=0.7)

CACTUS_PIVOTS = {"Top": (0.0, 0.0, 0.9), "Arm R": (0.45, 0.0, 1.0), "Arm L": (-0.42, 0.0, 1.34)}
CACTUS_MOVES = {
    "Top": (
        Move(1),
        Move(10, (0, -13, 0)),
        Move(22, (0, 18, 0)),
        Move(34, (0, -17, 0)),
        Move(48, (6, 15, 0)),
    ),
    "Arm R": (
        Move(1),
        Move(10, (0, -12, 0), (-0.14, 0.0, 0.03)),
        Move(22, (0, 58, 0), (0.12, 0.0, -0.04)),
        Move(34, (0, -14, 0), (-0.16, 0.0, 0.03)),
        Move(48, (0, 64, 0), (0.10, 0.0, -0.04)),
    ),
    "Arm L": (
        Move(1),
        Move(10, (0, -52, 0), (-0.12, 0.0, -0.04)),
        Move(22, (0, 14, 0), (0.16, 0.0, 0.03)),
        Move(34, (0, -58, 0), (-0.14, 0.0, -0.04)),
        Move(48, (0, 12, 0), (0.14, 0.0, 0.02)),
    ),
}


def make_cactus(api: ModuleType) -> bpy.types.Object:
    """A cactus that dances in its pot. The pot is not deformed; the flower goes where the top's handle goes."""
    scene = scenes.empty_file()
    mesh = cactus()
    obj = scenes.mesh_object("Cactus", mesh, (SKIN,))
    scenes.mesh_object("Pot", pot(), (CLAY, SOIL))
    blossom = scenes.mesh_object("Flower", flower(), (PETALS, HEART))
    blossom.location = (0.0, 0.0, TOP)
    handles = _bind(api, obj, cactus_groups(mesh), ("Roots",), tuple(CACTUS_MOVES))
    _parent(blossom, handles["Top"])
    for name, moves in CACTUS_MOVES.items():
        scenes.animate(handles[name], moves, CACTUS_PIVOTS[name])
    scenes.studio(scene, (0.62, 0.47, 0.30), (0.05, 0.0, 1.10), (2.2, -6.8, 2.1), size=1.2, lens=88.0)
    return obj


BODY = (
    Finish("Child", None, roughness=0.55),
    Finish("Scalp", (0.20, 0.070, 0.020), roughness=0.8),
    Finish("Trousers", (0.035, 0.085, 0.26), roughness=0.85),
    Finish("Shoes", (0.26, 0.075, 0.030), roughness=0.4),
)
WORN = {
    "Shirt": (shirt, (Finish("Cloth", (0.72, 0.10, 0.055), roughness=0.8),)),
    "Belt": (belt, (Finish("Leather", (0.10, 0.040, 0.018), roughness=0.45),)),
    "Buttons": (buttons, (Finish("Horn", (0.90, 0.80, 0.58), 0.35), Finish("Brass", (0.85, 0.52, 0.10), 0.25, 0.6))),
    "Eyes": (
        eyes,
        (
            Finish("White", (0.90, 0.90, 0.90), 0.1, 0.6),
            Finish("Iris", (0.06, 0.27, 0.33), 0.1, 0.6),
            Finish("Pupil", (0.008, 0.008, 0.010), 0.05, 0.6),
        ),
    ),
    "Hair": (hair, (Finish("Hair", None, roughness=0.5),)),
    "Smile": (smile, (Finish("Lips", (0.50, 0.065, 0.055)), Finish("Brows", (0.13, 0.042, 0.014), 0.8))),
}
DRESSED_PIVOTS = {"Head": (0.0, 0.0, 1.14), "Hand L": (0.22, 0.0, 0.95), "Hand R": (-0.22, 0.0, 0.95)}
DRESSED_MOVES = {
    "Head": (
        Move(1),
        Move(14, (0, 9, 8)),
        Move(31, (0, 5, 12)),
        Move(48, (-2, 9, 10)),
    ),
    "Hand L": (
        Move(1),
        Move(10, (0, -60, 0), (0.0, -0.03, 0.0)),
        Move(18, (0, -86, 0), (0.02, -0.05, 0.0)),
        Move(26, (0, -66, 0), (0.02, -0.05, 0.0)),
        Move(34, (0, -86, 0), (0.02, -0.05, 0.0)),
        Move(41, (0, -68, 0), (0.02, -0.05, 0.0)),
        Move(48, (0, -84, 0), (0.02, -0.05, 0.0)),
    ),
    "Hand R": (
        Move(1),
        Move(16, (0, -18, 0)),
        Move(48, (0, -14, 0)),
    ),
}


def make_dressed(api: ModuleType) -> bpy.types.Object:
    """The child in its clothes, which are objects of their own: it waves, and they go along."""
    scene = scenes.empty_file()
    mesh = figure()
    obj = scenes.mesh_object("Child", mesh, BODY)
    worn = [scenes.mesh_object(name, make(mesh), finishes) for name, (make, finishes) in WORN.items()]
    handles = _bind(api, obj, figure_groups(mesh), ("Foot L", "Foot R"), tuple(DRESSED_MOVES))
    api.attach(obj, worn)
    obj.arap.active_attachment_index = 0
    for name, moves in DRESSED_MOVES.items():
        scenes.animate(handles[name], moves, DRESSED_PIVOTS[name])
    scenes.studio(scene, (0.30, 0.44, 0.52), (0.0, 0.0, 0.90), (1.5, -6.4, 1.6), lens=108.0)
    return obj


TWIST_DEGREES = 135.0
BEND_DEGREES = 90.0
STEPS = (1, 9, 17, 25, 33, 41, LAST_FRAME)


def make_bars(api: ModuleType) -> bpy.types.Object:
    """Two bars, the papers' twist and bend."""
    scene = scenes.empty_file()
    bars = {}
    moves = {"Bar twist": [_twist(f) for f in STEPS], "Bar bend": [_bend(f) for f in STEPS]}
    finishes = {
        "Bar twist": (Finish("Sand", (0.85, 0.62, 0.32), 0.5), Finish("Brick", (0.62, 0.16, 0.07), 0.5)),
        "Bar bend": (Finish("Ice", (0.68, 0.80, 0.82), 0.5), Finish("Sea", (0.04, 0.26, 0.38), 0.5)),
    }
    for name, x in (("Bar twist", -0.85), ("Bar bend", 0.15)):
        mesh = bar()
        obj = bars[name] = scenes.mesh_object(name, mesh, finishes[name], is_smooth=False)
        obj.location.x = x
        bpy.context.view_layer.update()
        handles = _bind(api, obj, bar_groups(mesh), ("Bottom",), ("Top",))
        scenes.animate(handles["Top"], moves[name])
    scenes.studio(scene, (0.46, 0.45, 0.50), (0.35, 0.0, 0.95), (1.6, -7.6, 2.5), size=1.2, lens=76.0)
    return bars["Bar twist"]


def _share(frame: int) -> float:
    return (frame - 1) / (LAST_FRAME - 1)


def _twist(frame: int) -> Move:
    return Move(frame, (0.0, 0.0, TWIST_DEGREES * _share(frame)))


def _bend(frame: int) -> Move:
    """The end of a bar that bends along an arc of its own length."""
    angle = radians(BEND_DEGREES) * _share(frame)
    if angle == 0.0:
        return Move(frame)
    radius = SIZE[2] / angle
    return Move(frame, (0.0, degrees(angle), 0.0), (radius * (1 - cos(angle)), 0.0, radius * sin(angle) - SIZE[2]))


def _bind(
    api: ModuleType, obj: bpy.types.Object, groups: Mapping[str, Ints], pins: Sequence[str], handles: Sequence[str]
) -> dict[str, bpy.types.Object]:
    """Adds pins and handles; returns the handles' empties by name."""
    for name in pins:
        api.add_pin(obj, groups[name], name=name)
    made = {name: api.add_handle(obj, groups[name], name=name) for name in handles}
    return {name: obj.arap.controls[control].target for name, control in made.items()}


def _parent(child: bpy.types.Object, parent: bpy.types.Object) -> None:
    """Parents without moving the child."""
    bpy.context.view_layer.update()
    matrix = child.matrix_world.copy()
    child.parent = parent
    child.matrix_parent_inverse = parent.matrix_world.inverted()
    child.matrix_basis = matrix
    bpy.context.view_layer.update()
