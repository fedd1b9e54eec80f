# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module is found in its place. If it is missing, the add-on still registers and says why."""

import gc
import json
import os
import re
import subprocess
import sys
import tempfile
import weakref
import zipfile
from pathlib import Path
from types import FunctionType

import support
from support import SceneTest, bpy, module
from tubes import posable

HERE = Path(__file__).resolve().parents[1]
PROBE = """
import json, sys
from pathlib import Path
sys.path.insert(0, {here!r})
import run
package = run.install(Path({zip!r}))
import bpy, importlib
api, native = (importlib.import_module(package + name) for name in (".api", ".core.native"))
mesh = bpy.data.meshes.new("M")
mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
obj = bpy.data.objects.new("M", mesh)
bpy.context.scene.collection.objects.link(obj)
api.add_pin(obj, [0])
try:
    api.solve(obj)
    raised = ""
except RuntimeError as error:
    raised = str(error)
print("PROBE " + json.dumps([native.problem(), raised, len(obj.arap.pins)]), flush=True)
"""


class NativeTest(SceneTest):
    def test_the_module_is_the_installed_one(self):
        native = module("core.native")
        self.assertEqual(native.problem(), "")
        place = Path(native.load().__file__)
        self.assertIn(Path(os.environ["ARAP_TEST_USER_FOLDER"]).resolve(), place.resolve().parents)

    def test_without_a_module_everything_says_so(self):
        obj = posable()
        native = module("core.native")
        self.addCleanup(setattr, native, "_problem", native._problem)
        native._problem = "The solver module is missing"
        for function in (self.api.solve, module("engine.update").prepare_session):
            self.assert_error(RuntimeError, "The solver module is missing", function, obj)
        self.assertEqual(module("core.native").problem(), "The solver module is missing")

    def test_a_zip_for_another_python_registers_and_says_what_to_do(self):
        """The same zip without its wheels."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / support.ZIP.name
            with zipfile.ZipFile(support.ZIP) as source, zipfile.ZipFile(path, "w") as target:
                for name in source.namelist():
                    content = source.read(name)
                    if name == "blender_manifest.toml":
                        content = re.sub(rb"wheels = \[.*?\]", b"", content, flags=re.DOTALL)
                    if not name.startswith("wheels/"):
                        target.writestr(name, content)
            problem, raised, n_pins = self.probe(path, folder)
        here = f"Python {sys.version_info.major}.{sys.version_info.minor} on "
        self.assertTrue(problem.startswith(f"The solver module is missing for {here}"), problem)
        self.assertRegex(problem, r"install arap_deform-\S+\.zip$")
        self.assertEqual(raised, problem)
        self.assertEqual(n_pins, 1)

    def probe(self, zip_path: Path, folder: str) -> list:
        code = PROBE.format(here=str(HERE), zip=str(zip_path))
        if bpy.app.binary_path:
            command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-expr", code]
        else:
            command = [sys.executable, "-c", "import bpy\n" + code]
        env = {**os.environ, "BLENDER_USER_RESOURCES": f"{folder}/user"}
        (Path(folder) / "user").mkdir()
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=env)
        found = re.search(r"^PROBE (.*)$", done.stdout, re.MULTILINE)
        self.assertIsNotNone(found, done.stdout + done.stderr)
        return json.loads(found[1])


class RegisterTest(SceneTest):
    def test_disabling_and_enabling_again_works(self):
        obj = posable()
        self.api.solve(obj)
        bpy.ops.preferences.addon_disable(module=support.PACKAGE)
        self.assertFalse(hasattr(bpy.types.Object, "arap"))
        self.assertFalse([name for name in sys.modules if name.startswith(f"{support.PACKAGE}.")])
        bpy.ops.preferences.addon_enable(module=support.PACKAGE)
        obj = bpy.data.objects["Tube"]
        self.assertEqual(obj.arap.handles[0].name, "Head")
        module("api").solve(obj)
        # One set of modules, not old ones beside new ones.
        self.assertIs(module("engine.update").sessions, sys.modules[f"{support.PACKAGE}.core.sessions"])
        self.assertIs(module("pose.result").sessions, module("engine.update").sessions)
        self.assertIsNotNone(module("core.sessions").stats(obj.session_uid))

    def test_disabled_it_leaves_nothing_in_memory(self):
        """Its modules hold the module bpy, and Blender as a module of Python ends when that one goes."""
        former = [
            weakref.ref(item)
            for name, loaded in sys.modules.items()
            if name.startswith(f"{support.PACKAGE}.")
            for item in vars(loaded).values()
            if isinstance(item, (FunctionType, type)) and item.__module__ == name
        ]
        self.assertGreater(len(former), 500)
        del self.api
        bpy.ops.preferences.addon_disable(module=support.PACKAGE)
        gc.collect()
        left = {item.__module__.removeprefix(f"{support.PACKAGE}.") for item in (ref() for ref in former) if item}
        bpy.ops.preferences.addon_enable(module=support.PACKAGE)
        # Some Blenders never let go of a class with properties.
        of_properties = {name for name in left if name.startswith("props.")}
        self.assertEqual(left - of_properties if bpy.app.binary_path else left, set())
