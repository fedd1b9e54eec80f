# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses and frames to shape keys and files."""

# What registers something, in this order.
MODULES = ("operators", "cache_operator", "panel")
