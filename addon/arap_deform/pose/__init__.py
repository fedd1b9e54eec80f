# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose now: Pose, Solve, Reset, Apply as Rest."""

# What registers something, in this order.
MODULES = ("undo", "operators", "solve_operator", "reset_operators", "job_operator", "panel")
