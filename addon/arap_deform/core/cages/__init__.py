# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages: coarse closed meshes that move the mesh inside. No bpy."""
