# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn over the mesh."""

# What registers something, in this order.
MODULES = ("overlay", "panel")
