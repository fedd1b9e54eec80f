# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps one mesh to its handles."""
