# SPDX-License-Identifier: GPL-3.0-or-later
"""What all operators and panels share."""
