# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins, handles and stiffness: made, listed, painted."""

# What registers something, in this order.
MODULES = ("list_operators", "select_operators", "group_operators", "panels")
