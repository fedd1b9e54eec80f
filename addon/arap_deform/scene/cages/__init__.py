# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages in Blender: how they are read, and saved."""
