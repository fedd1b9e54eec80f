# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose pieces of a mesh, such as eyes and buttons, that go along with what they sit in. No bpy."""
