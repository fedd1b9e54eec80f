# SPDX-License-Identifier: GPL-3.0-or-later
"""Models and scenes of the samples; see make_scenes.py."""
