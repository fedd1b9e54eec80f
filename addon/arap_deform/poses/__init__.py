# SPDX-License-Identifier: GPL-3.0-or-later
"""The pose library."""

# What registers something, in this order.
MODULES = ("library", "operators", "blend_operator", "panel")
