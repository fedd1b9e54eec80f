# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins, handles and stiffness: made, listed, painted."""

# What registers something, in this order.
MODULES = (
    "handles",
    "pin_operators",
    "handle_operators",
    "stiffness_operators",
    "group_operators",
    "select_operators",
    "pin_panel",
    "handle_panel",
    "stiffness_panel",
)
