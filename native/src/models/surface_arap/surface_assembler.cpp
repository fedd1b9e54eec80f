// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/surface_assembler.h"

#include <algorithm>

namespace arap {

SurfaceAssembler::SurfaceAssembler(const PolygonMesh& mesh, const Options& options,
                                   const std::vector<double>& stiffness)
    : rest_(mesh.positions()),
      stiffness_(stiffness),
      is_spokes_(options.energy == Energy::kSpokes),
      triangulation_(triangulate(mesh, options.weights)),
      triangles_at_(mesh.n_vertices(), triangulation_.triangles),
      ties_at_(mesh.n_vertices(), triangulation_.ties) {
  if (!is_spokes_) return;
  for (Triangle& triangle : triangulation_.triangles)
    for (double& weight : triangle.half_cotangents) weight = std::max(0.0, weight);
}

void SurfaceAssembler::system_column(int i, RowAccumulator<double>& column) const {
  double diagonal = 0;
  triangles_at_.for_each(i, [&](int t) {
    const Triangle& triangle = triangulation_.triangles[t];
    for_edges_at(triangle, i, [&](size_t edge, int j) {
      const double value = 2 * triangle.half_cotangents[edge] * cells_of_edge(triangle, edge);
      diagonal += value;
      column[j] -= value;
    });
  });
  ties_at_.for_each(i, [&](int t) {
    const Tie& tie = triangulation_.ties[t];
    double own = 0;
    for (size_t a = 0; a < 3; ++a)
      if (tie.vertices[a] == i) own += tie.coefficients[a];
    const double factor = 2 * tie.weight * stiffness(tie.vertices[0]) * own;
    for (size_t a = 0; a < 3; ++a) column[tie.vertices[a]] += factor * tie.coefficients[a];
  });
  column[i] += diagonal;  // is always there, also of loose vertices
}

void SurfaceAssembler::cells_at(int j, RowAccumulator<Vector3>& cells) const {
  if (!is_spokes_) {
    for_each_term(j, [&](const std::array<int, 3>& /*vertices*/, int i, const Vector3& q) { cells[i] += q; });
    return;
  }
  triangles_at_.for_each(j, [&](int t) {
    const Triangle& triangle = triangulation_.triangles[t];
    for_edges_at(triangle, j, [&](size_t edge, int other) {
      const Vector3 pull = triangle.half_cotangents[edge] * (rest_.row(j) - rest_.row(other)).transpose();
      cells[j] += scale(j) * pull;
      cells[other] += scale(other) * pull;
    });
  });
  for_each_tie_term(j, [&](const std::array<int, 3>& /*vertices*/, int i, const Vector3& q) { cells[i] += q; });
}

double SurfaceAssembler::cells_of_edge(const Triangle& triangle, size_t edge) const {
  const double ends = stiffness(triangle.vertices[(edge + 1) % 3]) + stiffness(triangle.vertices[(edge + 2) % 3]);
  return is_spokes_ ? ends : (ends + stiffness(triangle.vertices[edge])) / 3;
}

}  // namespace arap
