// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/tet_arap.h"

#include <array>
#include <utility>

#include "models/tet_arap/tet_model.h"

namespace arap_test {

namespace {

/// Edges from the first vertex, as columns.
Matrix3 edges(const TetMesh& mesh, int tet) {
  Matrix3 result;
  for (int k = 0; k < 3; ++k)
    result.col(k) =
        (mesh.positions().row(mesh.tets()[tet][k + 1]) - mesh.positions().row(mesh.tets()[tet][0])).transpose();
  return result;
}

}  // namespace

TetMesh tet_blocks(int nx, int ny, int nz) {
  const auto index = [&](int x, int y, int z) { return x + (nx + 1) * (y + (ny + 1) * z); };
  Positions positions((nx + 1) * (ny + 1) * (nz + 1), 3);
  const double size = Vector3(nx, ny, nz).norm();
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) positions.row(index(x, y, z)) = Eigen::RowVector3d(x, y, z) / size;
  // The paths along the edges from one corner of a cube to the opposite one.
  constexpr int kPaths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  std::vector<TetMesh::Tet> tets;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        for (const auto& path : kPaths) {
          std::array<int, 3> at{x, y, z};
          TetMesh::Tet tet{index(x, y, z)};
          for (int k = 0; k < 3; ++k) {
            ++at[path[k]];
            tet[k + 1] = index(at[0], at[1], at[2]);
          }
          tets.push_back(tet);
        }
  return {std::move(positions), std::move(tets)};
}

TetMesh transformed(const TetMesh& mesh, const std::function<Vector3(const Vector3&)>& map) {
  Positions positions = mesh.positions();
  for (auto row : positions.rowwise()) row = map(row.transpose()).transpose();
  return {std::move(positions), mesh.tets()};
}

Eigen::Matrix<double, 4, 3> gradients(const TetMesh& mesh, int tet) {
  Eigen::Matrix<double, 4, 3> result;
  result.bottomRows<3>() = edges(mesh, tet).inverse();
  result.row(0) = -result.bottomRows<3>().colwise().sum();
  return result;
}

double tet_volume(const TetMesh& mesh, int tet) { return edges(mesh, tet).determinant() / 6; }

arap::LinearRow point_in(const TetMesh& mesh, int tet, const Eigen::Vector4d& coordinates) {
  const TetMesh::Tet& vertices = mesh.tets()[tet];
  return {{vertices.begin(), vertices.end()}, {coordinates.begin(), coordinates.end()}};
}

arap::PreparedModel& assemble(arap::PreparedModel& model, const TetMesh& mesh, int threads,
                              const std::vector<int>& region_of_vertex, const arap::SolverFactory* solver_factory) {
  arap::assemble_tet_energy(model.energy, mesh.positions(), mesh.tets(), {}, region_of_vertex, threads, {},
                            [] { return nullptr; });
  model.rest = mesh.positions();
  model.part_of_vertex = mesh.part_of_vertex();
  model.n_parts = mesh.n_parts();
  model.workers = arap::Workers(threads);
  model.solver_factory = solver_factory;
  model.regions = arap::RigidRegions(region_of_vertex, model.energy, model.rest);
  model.solver = model.make_solver();
  model.keep_numbers();
  return model;
}

}  // namespace arap_test
