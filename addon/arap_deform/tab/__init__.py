# SPDX-License-Identifier: GPL-3.0-or-later
"""First Pose, Advanced, and the menus."""

# What registers something, in this order.
MODULES = ("first_pose", "advanced_panel", "menus")
