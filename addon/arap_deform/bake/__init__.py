# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses and frames to shape keys and files."""

# The modules that register something, in this order.
MODULES = ("operators", "panel")
