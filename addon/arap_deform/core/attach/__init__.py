# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects attached to a mesh, in arrays; no bpy."""
