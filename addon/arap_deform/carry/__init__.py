# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: clothes, hair and eyes go along with the mesh that they belong to."""
