# SPDX-License-Identifier: GPL-3.0-or-later
"""What is not folded in the tab, its first line, Advanced, and the menus."""
