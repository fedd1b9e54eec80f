# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's data to arrays and back. Only this room writes coordinates and weights."""

# What registers something, in this order.
MODULES = ("owners", "redraw")
