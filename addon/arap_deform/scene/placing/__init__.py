# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves the objects, bones and cages that are handles, and puts them back."""
