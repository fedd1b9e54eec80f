// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/piece_stiffness.h"

#include <cmath>

#include "base/grouped.h"

namespace arap {

namespace {

constexpr double kOfRigidRegions = 100;

/// Writes the mean of what is known beside a piece to those of which nothing is known, layer by layer.
void spread(const Lattice& lattice, std::vector<double>& values, std::vector<char>& is_known) {
  const Grouped pieces(lattice.n_control_points(), [&](const auto& add) {
    for (int piece = 0; piece < lattice.n_pieces(); ++piece)
      for (const int c : lattice.control_points(piece)) add(c, piece);
  });
  std::vector<int> unknown;
  for (int piece = 0; piece < lattice.n_pieces(); ++piece)
    if (is_known[piece] == 0) unknown.push_back(piece);
  for (size_t before = 0; !unknown.empty() && before != unknown.size();) {
    before = unknown.size();
    std::vector<int> found;
    std::vector<int> left;
    for (const int piece : unknown) {
      double sum = 0;
      int n = 0;
      for (const int c : lattice.control_points(piece))
        for (const int other : pieces.of(c))
          if (is_known[other] != 0) {
            sum += values[other];
            ++n;
          }
      if (n > 0) values[piece] = sum / n;
      (n > 0 ? found : left).push_back(piece);
    }
    for (const int piece : found) is_known[piece] = 1;
    unknown = std::move(left);
  }
}

}  // namespace

std::vector<double> piece_stiffness(const Lattice& lattice, const VertexProperties& properties) {
  if (properties.stiffness.empty() && properties.rigid_regions.empty()) return {};
  std::vector<double> logarithms(lattice.n_pieces(), 0);
  std::vector<int> n_vertices(lattice.n_pieces(), 0);
  for (size_t v = 0; v < lattice.piece_of_vertex().size(); ++v) {
    const int piece = lattice.piece_of_vertex()[v];
    if (piece < 0) continue;
    ++n_vertices[piece];
    if (!properties.stiffness.empty()) logarithms[piece] += std::log(properties.stiffness[v]);
    if (!properties.rigid_regions.empty() && properties.rigid_regions[v] >= 0)
      logarithms[piece] += std::log(kOfRigidRegions);
  }
  std::vector<char> is_known(lattice.n_pieces());
  for (int piece = 0; piece < lattice.n_pieces(); ++piece) {
    is_known[piece] = n_vertices[piece] > 0 ? 1 : 0;
    if (n_vertices[piece] > 0) logarithms[piece] /= n_vertices[piece];
  }
  spread(lattice, logarithms, is_known);
  for (double& value : logarithms) value = std::exp(value);
  return logarithms;
}

}  // namespace arap
