# SPDX-License-Identifier: GPL-3.0-or-later
"""First Pose, Advanced, and the menus."""
