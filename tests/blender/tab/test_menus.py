# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels and tooltips of all operators and properties; what the menus have."""

from types import SimpleNamespace

from support import SceneTest, bpy, module
from tubes import mesh_object

OPERATORS = sorted(name for name in dir(bpy.ops.arap) if not name.startswith("_"))
NOT_IN_THE_MENU = {
    "pull": "the tool's own key",
    "pose_end": "a button while a mesh is posed",
    "preparing_cancel": "Esc while a mesh is prepared",
}


class Layout:
    """Remembers the operators and menus that a draw function adds."""

    operator_context = ""

    def __init__(self) -> None:
        self.said: list[str] = []

    def operator(self, name, **_keywords):
        self.said.append(name)
        return SimpleNamespace()

    menu = operator

    def prop(self, _settings, _name):
        pass

    def separator(self):
        pass


def drawn(draw, context=None) -> list[str]:
    layout = Layout()
    draw(SimpleNamespace(layout=layout), context or bpy.context)
    return layout.said


class LabelTest(SceneTest):
    def test_operators_have_labels_and_tooltips(self):
        self.assertGreater(len(OPERATORS), 15)
        for name in OPERATORS:
            rna = getattr(bpy.ops.arap, name).get_rna_type()
            # F3 shows the menu's name before the label. The tool's operator is in no menu.
            self.assertEqual("ARAP" in rna.name, name == "pull", name)
            self.assertGreater(len(rna.description), 20, name)
            self.assertFalse(rna.description.endswith("."), f"{name}: Blender adds the full stop")

    def test_properties_have_labels_and_tooltips(self):
        operators = [getattr(bpy.ops.arap, name).get_rna_type() for name in OPERATORS]
        saved = [
            cls.bl_rna
            for name in module("").MODULES["props"]
            for cls in module("scene.registration").classes(module(f"props.{name}"))
        ]
        ours = [(group, prop) for group in (*operators, *saved) for prop in group.properties if prop.is_runtime]
        self.assertGreater(len(ours), 60)
        for group, prop in ours:
            with self.subTest(f"{group.name}.{prop.identifier}"):
                self.assertTrue(prop.name or prop.is_hidden)
                self.assertTrue(prop.description or (prop.is_hidden and group in operators))
                self.assertFalse(prop.description.endswith("."))


class MenuTest(SceneTest):
    def test_the_menu_has_each_operator_and_is_in_the_menus_of_its_modes(self):
        said = {*drawn(bpy.types.ARAP_MT_main.draw), *drawn(bpy.types.ARAP_MT_poses.draw)}
        self.assertEqual(
            said, {"ARAP_MT_poses", *(f"arap.{name}" for name in OPERATORS if name not in NOT_IN_THE_MENU)}
        )
        for parent, draw in module("tab.menus").ADDITIONS:
            self.assertIn(draw, getattr(bpy.types, parent).draw._draw_funcs, parent)

    def test_the_context_menu_fits_the_mode(self):
        obj = mesh_object()
        for mode, wanted in (
            ("OBJECT", "arap.pose"),
            ("EDIT_MESH", "arap.handle_add"),
            ("PAINT_WEIGHT", "arap.pin_add"),
        ):
            self.assertIn(wanted, drawn(bpy.types.ARAP_MT_context.draw, SimpleNamespace(mode=mode)))
        add = module("tab.menus")._draw_in_context
        self.assertEqual(drawn(add), [], "there is no mesh to work on")
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(drawn(add), ["ARAP_MT_context"])
