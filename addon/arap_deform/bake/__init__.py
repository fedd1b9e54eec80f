# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses and frames to shape keys and files."""
