# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that follows its handles all the time."""
