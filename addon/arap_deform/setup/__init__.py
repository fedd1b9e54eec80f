# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins, handles, stiffness: added, listed, painted."""

# What registers something, in this order.
MODULES = ("handles", "list_operators", "select_operators", "group_operators", "panels")
