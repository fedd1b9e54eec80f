// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "cages/cage.h"
#include "support/meshes.h"

namespace arap_test {

/// A concave cage of triangles: an L, .5 wide, whose inner edge is at (.5, .5) along z.
MeshData l_cage(double length = 1);
/// Closed meshes of triangles, quads or both, convex or not, oriented outwards.
std::vector<MeshData> all_cages();
/// Whether some of its quads are not flat.
bool has_bent_quads(const MeshData& mesh);
/// With the fronts of all faces inwards.
MeshData flipped(const MeshData& mesh);
/// Positions of a cage, bent and stretched by a tenth of its size.
Positions bent(const MeshData& cage);

/// n points inside of a cage, not nearer to its faces than a fiftieth of its diagonal.
Positions points_inside(const MeshData& cage, int n, std::uint64_t seed = 1);
/// How often the cage winds around a point: solid angles over 4 pi.
double winding(const MeshData& cage, const Vector3& point);

/// Integrals over the faces by a rule of the third order, each triangle cut in four `levels` times. A quad is the mean
/// of both its cuts.
/// @param kernel  of a point of a face, and the unit normal there
struct Quadrature {
  Eigen::VectorXd hats;    ///< (n_vertices,) of the vertices' hats times the kernel
  Eigen::VectorXd wholes;  ///< (n_triangles,) of the kernel alone, in the order of a Cage's triangles
};
Quadrature integrate(const arap::Cage& cage, int levels,
                     const std::function<double(const Vector3& place, const Vector3& normal)>& kernel);

/// Mean value coordinates by the algorithm of [JSW05] with its errata, in long double. For points off the planes of the
/// triangles.
Eigen::VectorXd printed_mean_values(const arap::Cage& cage, const Vector3& point);

}  // namespace arap_test
