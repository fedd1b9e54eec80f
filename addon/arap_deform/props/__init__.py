# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings: saved in the .blend, or in the preferences."""
