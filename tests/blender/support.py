# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests inside Blender share: the installed add-on, and a test in an empty scene."""

from __future__ import annotations

import importlib
import sys
import tempfile
import unittest
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np

ZIP = Path()
PACKAGE = ""


def flattened(suite: unittest.TestSuite) -> Iterator[unittest.TestCase]:
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from flattened(test)
        else:
            yield test


class FakeLock:
    """An act that has a mesh for itself."""

    def __init__(self, doing: str) -> None:
        self.doing = doing


def module(name: str) -> ModuleType:
    """A module of the installed add-on."""
    return importlib.import_module(f"{PACKAGE}.{name}".rstrip("."))


def linked_back(obj: bpy.types.Object, *names: str) -> list[bpy.types.Object]:
    """The object, and others that it needs, by their names: written to a library and linked from a new, empty file."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "library.blend")
        bpy.data.libraries.write(path, {obj})
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with bpy.data.libraries.load(path, link=True) as (_, data):
            data.objects = list(names)
    return list(data.objects)


class SceneTest(unittest.TestCase):
    """Every test starts in an empty scene without live sessions."""

    def setUp(self) -> None:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.api = module("api")
        self.scene = bpy.context.scene
        self.new_is_dirty = bpy.data.is_dirty  # bpy 4.5 as a module of Python says so of every file

    def new_folder(self) -> Path:
        """An empty folder, removed after the test."""
        # On Windows Blender keeps Alembic files open.
        folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=sys.platform == "win32")
        self.addCleanup(folder.cleanup)
        return Path(folder.name).resolve()

    def assert_error(self, kind: type[Exception], message: str, function, *arguments, **keywords) -> None:
        """The whole message, so that every word that the user reads is tested."""
        with self.assertRaises(kind) as caught:
            function(*arguments, **keywords)
        self.assertEqual(str(caught.exception), message)

    def assert_close(self, actual, expected, atol: float = 1e-5) -> None:
        np.testing.assert_allclose(actual, expected, rtol=0.0, atol=atol)


def uid(name: str) -> int:
    """Of the local object of that name."""
    return bpy.data.objects[name, None].session_uid


def opened_again() -> bpy.types.Object:
    """The tube, after its file was saved and opened again."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
    return bpy.data.objects["Tube"]
