# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: clothes, hair and eyes follow a host mesh; many meshes a stand-in; a mesh its cage."""
