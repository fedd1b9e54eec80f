// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/tet_arap.h"

#include <utility>

#include "support/helpers.h"

namespace arap_test {

TetMesh TetMesh::blocks(int nx, int ny, int nz) {
  TetMesh mesh;
  const auto index = [&](int x, int y, int z) { return x + (nx + 1) * (y + (ny + 1) * z); };
  mesh.positions.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  const double size = Vector3(nx, ny, nz).norm();
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) mesh.positions.row(index(x, y, z)) = Eigen::RowVector3d(x, y, z) / size;
  // The paths along the edges from one corner of a cube to the opposite one.
  constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        for (int p = 0; p < 6; ++p) {
          std::array<int, 3> at{x, y, z};
          std::array<int, 4> tet{index(x, y, z)};
          for (int k = 0; k < 3; ++k) {
            ++at[kPaths[p][k]];
            tet[k + 1] = index(at[0], at[1], at[2]);
          }
          if (p >= 3) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        }
  return mesh;
}

Eigen::Matrix<double, 4, 3> TetMesh::gradients(int tet) const {
  Matrix3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = (positions.row(tets[tet][k + 1]) - positions.row(tets[tet][0])).transpose();
  Eigen::Matrix<double, 4, 3> result;
  result.bottomRows<3>() = edges.inverse();
  result.row(0) = -result.bottomRows<3>().colwise().sum();
  return result;
}

double TetMesh::volume(int tet) const {
  Matrix3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = (positions.row(tets[tet][k + 1]) - positions.row(tets[tet][0])).transpose();
  return edges.determinant() / 6;
}

arap::LinearRow TetMesh::point_in(int tet, const Eigen::Vector4d& coordinates) const {
  return {{tets[tet].begin(), tets[tet].end()}, {coordinates.begin(), coordinates.end()}};
}

// V |F - R|^2 = V |F|^2 - <R, 2 V F> + 3 V with F = sum_j x_j g_j^T: K_jk = 2 V <g_j, g_k>, q_j = 2 V g_j.
arap::PreparedModel& assemble(arap::PreparedModel& model, const TetMesh& mesh, int threads,
                              const std::vector<int>& region_of_vertex, arap::LinearSolverKind solver) {
  arap::CellEnergy& energy = model.energy;
  const auto n = static_cast<int>(mesh.positions.rows());
  const auto n_tets = static_cast<int>(mesh.tets.size());
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<std::vector<CellEntry>> cells(mesh.tets.size());
  for (int t = 0; t < n_tets; ++t) {
    const Eigen::Matrix<double, 4, 3> g = mesh.gradients(t);
    const double volume = mesh.volume(t);
    for (int j = 0; j < 4; ++j) {
      cells[t].push_back({mesh.tets[t][j], 2 * volume * g.row(j).transpose()});
      for (int k = 0; k < 4; ++k)
        entries.emplace_back(mesh.tets[t][j], mesh.tets[t][k], 2 * volume * g.row(j).dot(g.row(k)));
    }
    energy.rest_energy += 3 * volume;
  }
  energy.K.resize(n, n);
  energy.K.setFromTriplets(entries.begin(), entries.end());
  energy.cells = make_cells(n, cells);
  model.rest = mesh.positions;
  model.part_of_vertex.assign(static_cast<size_t>(n), 0);
  model.n_parts = 1;
  model.workers = arap::Workers(threads);
  model.linear_solver = solver;
  model.regions = arap::RigidRegions(region_of_vertex, energy, model.rest);
  model.solver = model.make_solver();
  model.keep_numbers();
  return model;
}

}  // namespace arap_test
