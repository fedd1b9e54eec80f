# SPDX-License-Identifier: GPL-3.0-or-later
"""Several meshes as one connected mesh, in arrays: the stand-in that is posed in their place."""
