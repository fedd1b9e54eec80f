# SPDX-License-Identifier: GPL-3.0-or-later
"""What posing is, in arrays. No bpy."""
