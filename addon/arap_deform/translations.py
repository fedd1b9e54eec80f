# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives Blender the translations of the add-on's words."""

from __future__ import annotations

import bpy

from . import translation_german
from .texts import CONTEXT

Messages = dict[tuple[str, str], str]

# "*" is Blender's default one; buttons look into the one of their operator.
CONTEXTS = ("*", "Operator", CONTEXT)
# Newer Blenders name languages without a country where one is enough.
LANGUAGES = {"de_DE": translation_german.MESSAGES, "de": translation_german.MESSAGES}


def dictionary() -> dict[str, Messages]:
    """As ``bpy.app.translations.register()`` takes it."""
    return {
        language: {(context, text): translated for text, translated in messages.items() for context in CONTEXTS}
        for language, messages in LANGUAGES.items()
    }


def register() -> None:
    bpy.app.translations.register(__package__ or "", dictionary())


def unregister() -> None:
    bpy.app.translations.unregister(__package__ or "")
