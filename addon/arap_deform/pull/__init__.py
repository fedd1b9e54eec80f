# SPDX-License-Identifier: GPL-3.0-or-later
"""Dragging the surface itself."""

# What registers something, in this order.
MODULES = ("tool", "operators", "draw")
