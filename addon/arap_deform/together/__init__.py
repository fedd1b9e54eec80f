# SPDX-License-Identifier: GPL-3.0-or-later
"""Pose Together: several meshes are posed as one, through a stand-in that they go along with."""
