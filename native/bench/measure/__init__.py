# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the library and its peers: meshes and tasks, the drivers, the tables and plots of docs/performance.md.

native, peers and report are the drivers; each writes a JSON file that render turns into Markdown and pictures.
"""

import os

# Before numpy is there: the threads of its BLAS wait by spinning, on the cores of what is measured next.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
