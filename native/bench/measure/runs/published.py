# SPDX-License-Identifier: GPL-3.0-or-later
"""What the student report measured, and the cases that are measured anew beside it; see report.py."""

MOVES = {"small": 0.25, "medium": 0.5, "large": 1.0}  # shares of the move that tasks.displacement describes
GUESSES = ("rest", "naive_laplacian", "handle_rotations", "previous")
SOLVER_MESHES = ("armadillo_1k", "armadillo_10k")
ENERGY_MESHES = ("armadillo_250", "armadillo_1k", "armadillo_10k")

# Seconds for 200 iterations without and with OpenMP, on 4 cores (8 threads) at 2.4 GHz.
PUBLISHED_S = {
    "armadillo_250": (0.25, 0.16),
    "armadillo_500": (0.33, 0.19),
    "armadillo_1k": (1.38, 0.93),
    "armadillo_2k": (1.89, 1.08),
    "armadillo_5k": (5.53, 4.63),
    "armadillo_10k": (13.47, 11.86),
    "cactus_small": (0.91, 0.54),
    "cactus_highres": (3.59, 2.54),
    "dino": (64.22, 51.19),
}
PUBLISHED_SOLVERS_S = {"sparse_lu": 0.93, "sparse_qr": 21.23, "bicgstab": 1.69}
