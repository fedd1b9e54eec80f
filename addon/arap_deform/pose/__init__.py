# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose now: Pose, Solve, Reset, Apply as Rest."""

# The modules that register something, in this order.
MODULES = ("undo", "operators", "job_operator", "panel")
