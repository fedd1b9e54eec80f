# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool's icon is what its script draws, in the form that Blender reads."""

import make_icon
from build_zip import SOURCE


def test_the_icon_in_the_add_on_is_what_the_script_draws():
    assert (SOURCE / "icons" / "arap.pull.dat").read_bytes() == make_icon.icon()


def test_the_icon_is_whole_triangles():
    data = make_icon.icon()
    assert data[:4] == b"VCO\0"
    assert len(data[8:]) % (3 * (2 + 4)) == 0
