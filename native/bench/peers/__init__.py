# SPDX-License-Identifier: GPL-3.0-or-later
"""Other libraries' as-rigid-as-possible deformation, each behind the same four commands."""
