# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of deformation, ours and other libraries', all behind measure.base.contender.Contender."""
