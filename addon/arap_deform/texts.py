# SPDX-License-Identifier: GPL-3.0-or-later
"""Translation of the words that Blender does not look up by itself. Works without Blender: then they stay English.

Blender translates labels, names and descriptions that are one literal. A sentence with something in it is looked up
with its {} and filled in afterwards: ``iface_("Baked {} keys").format(n)``, never an f-string.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

CONTEXT = "ARAP"
"""Where the add-on's own words are looked up first: elsewhere Blender's translation of the same word wins, which may be
too long for the tab, or mean another thing. As ``text_ctxt`` of what is drawn."""

Translate = Callable[[str], str]
"""iface_, rpt_, or str: English, for scripts and the command line."""

try:
    from bpy.app import translations as _blender
except ModuleNotFoundError:  # the tests of what needs no Blender
    _blender: Any = None  # type: ignore[no-redef]


def iface_(text: str) -> str:
    """For labels, buttons and the status bar."""
    if not _blender:
        return text
    own = str(_blender.pgettext_iface(text, CONTEXT))
    return own if own != text else str(_blender.pgettext_iface(text))


def tip_(text: str) -> str:
    """For tooltips that are made while they are shown."""
    return str(_blender.pgettext_tip(text)) if _blender else text


def rpt_(text: str) -> str:
    """For reports, and for the reasons why something cannot be done."""
    if not _blender:
        return text
    translate = getattr(_blender, "pgettext_rpt", _blender.pgettext_tip)  # 4.1
    return str(translate(text))
