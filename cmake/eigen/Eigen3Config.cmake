# SPDX-License-Identifier: GPL-3.0-or-later
# Eigen from a folder that holds its headers alone, as a package of PyPI brings them:
#   cmake -DEigen3_DIR=.../cmake/eigen -DARAP_EIGEN_HEADERS=/folder/with/Eigen
add_library(Eigen3::Eigen INTERFACE IMPORTED)
set_target_properties(Eigen3::Eigen PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${ARAP_EIGEN_HEADERS}")
