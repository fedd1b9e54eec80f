# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay: what is drawn over the mesh."""
