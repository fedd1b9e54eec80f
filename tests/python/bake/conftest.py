# SPDX-License-Identifier: GPL-3.0-or-later
"""A disk with little room."""

import shutil
from types import SimpleNamespace

import pytest


@pytest.fixture
def small_disk(monkeypatch):
    """Every folder is on it: a megabyte is free."""
    monkeypatch.setattr(shutil, "disk_usage", lambda _folder: SimpleNamespace(free=1_000_000))
