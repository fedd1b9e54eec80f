# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's data to arrays and back. Only this room writes coordinates and weights."""
