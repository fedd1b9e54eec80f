# SPDX-License-Identifier: GPL-3.0-or-later
"""What goes along with a mesh, in arrays; no bpy."""
