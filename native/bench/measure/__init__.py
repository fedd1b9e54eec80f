# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the library and its peers.

Rooms, each imports only those before it: base (processes, machine, convergence), inputs (meshes, tasks, poses),
metrics (of deformed meshes), runs (each writes a JSON file), pages (these files as the tables and pictures of
docs/performance.md, docs/quality.md and docs/comparison.md).
"""

import os

# Before numpy is there: the threads of its BLAS wait by spinning, on the cores of what is measured next.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
