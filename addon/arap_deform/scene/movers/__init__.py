# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves handles: what they hang on, and why that does not move here."""
