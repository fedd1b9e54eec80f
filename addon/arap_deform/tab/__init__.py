# SPDX-License-Identifier: GPL-3.0-or-later
"""What ties the tab together."""

# What registers something, in this order.
MODULES = ("first_pose_panel", "settings_panel", "menus")
