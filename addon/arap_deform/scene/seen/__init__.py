# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of a shape key on its way to what is seen."""
