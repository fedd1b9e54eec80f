# SPDX-License-Identifier: GPL-3.0-or-later
"""What a .blend and the preferences save."""

# What registers something, in this order.
MODULES = ("preferences", "object")
