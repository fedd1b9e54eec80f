# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose now: Pose, Solve, Reset, Apply as Rest."""
