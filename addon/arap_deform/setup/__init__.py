# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins, handles, stiffness: added, listed, painted."""
