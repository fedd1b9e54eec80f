# SPDX-License-Identifier: GPL-3.0-or-later
"""The points that shape keys move: the vertices of a mesh, or the points of a curve with their handles."""
