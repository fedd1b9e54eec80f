# SPDX-License-Identifier: GPL-3.0-or-later
"""What all operators and panels share."""

# What registers something, in this order.
MODULES = ("panels",)
