// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/cage_arap/cage_energy.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/available_memory.h"
#include "base/permutation.h"
#include "models/surface_arap/surface_model.h"
#include "parallel/parallel.h"
#include "sparse/matrix_assembly.h"

namespace arap {

namespace {

using Rows = CagePoints::Rows;
using Matrix = Eigen::MatrixXd;

/// Of the cage's own energy beside that of the mesh.
constexpr double kShareOfCage = 1e-3;

/// The energy of a surface with rotation nodes, whose model numbers its vertices as it likes.
struct Surface {
  SurfaceModel model;
  std::vector<int> numbers;  ///< (n,) the model's, of each vertex of the mesh

  Surface(const PolygonMesh& mesh, double rigidity_radius, int threads) {
    Options options;
    options.rigidity_radius = rigidity_radius;
    options.threads = threads;
    numbers = prepare_surface(model, mesh, options, {}, {}, {});
  }

  [[nodiscard]] const CellEnergy& energy() const { return model.prepared.energy; }
  /// K with the numbers of the mesh.
  [[nodiscard]] SparseMatrix matrix() const {
    return renumbered(energy().K, numbers, inverse_permutation(numbers), model.prepared.workers.threads());
  }
};

/// The energy of a mesh, as the cage's vertices feel it.
class Subspace {
 public:
  /// @param surface  of the mesh; must outlive this
  /// @param carried  the vertices that are points
  Subspace(const Surface& surface, const CagePoints& points, const std::vector<int>& carried)
      : energy_(surface.energy()),
        workers_(points.workers()),
        phi_(Rows::Zero(std::ssize(surface.numbers), points.cage().n_vertices())) {
    parallel_for<CagePoints::kRows>(workers_, points.size(), [&](int begin, int end) {
      const Rows read = points.rows(begin, end - begin);
      for (int k = begin; k < end; ++k) phi_.row(surface.numbers[carried[k]]) = read.row(k - begin);
    });
  }

  /// K_c, (c, c).
  [[nodiscard]] Matrix matrix(const MeterPart& meter) const {
    const auto n = static_cast<int>(phi_.rows());
    const auto c = phi_.cols();
    const auto of_range = [&](int begin, int end) {
      Matrix sum = Matrix::Zero(c, c);
      for (int first = begin; first < end; first += CagePoints::kRows) {
        const int size = std::min(CagePoints::kRows, end - first);
        Rows forces = Rows::Zero(size, c);
        for (int k = 0; k < size; ++k)
          for (SparseMatrix::InnerIterator it(energy_.K, first + k); it; ++it)
            forces.row(k) += it.value() * phi_.row(it.row());
        sum.triangularView<Eigen::Lower>() += phi_.middleRows(first, size).transpose() * forces;
      }
      meter.add(static_cast<double>(end - begin) / n);
      return sum;
    };
    constexpr int kSums = 8;  // that there is memory for
    const Matrix lower = parallel_reduce(
        workers_, n, Matrix(Matrix::Zero(c, c)), of_range,
        [](const Matrix& a, const Matrix& b) { return Matrix(a + b); }, std::max(CagePoints::kRows, n / kSums + 1));
    return lower.selfadjointView<Eigen::Lower>();
  }

  /// q_c of all cells, (n_cells, 3 c).
  [[nodiscard]] Rows cells() const {
    Rows result = Rows::Zero(energy_.n_cells(), 3 * phi_.cols());
    parallel_for<16>(workers_, energy_.n_cells(), [&](int begin, int end) {
      for (int cell = begin; cell < end; ++cell) {
        const int home = energy_.cells.home(cell);
        if (home < 0) continue;
        Eigen::Map<Eigen::Matrix3Xd> of_cell(result.row(cell).data(), 3, phi_.cols());
        energy_.cells.for_each_vertex(cell,
                                      [&](int v, const Vector3& q) { of_cell += q * (phi_.row(v) - phi_.row(home)); });
      }
    });
    return result;
  }

  /// Of each cell the vertex of the cage that carries most of it; -1 if it is empty.
  [[nodiscard]] std::vector<int> homes() const {
    std::vector<int> result(energy_.n_cells(), -1);
    for (int cell = 0; cell < energy_.n_cells(); ++cell)
      if (const int vertex = energy_.cells.home(cell); vertex >= 0) phi_.row(vertex).maxCoeff(&result[cell]);
    return result;
  }

 private:
  const CellEnergy& energy_;
  const Workers& workers_;
  Rows phi_;  ///< (n, c) by the numbers of the energy
};

/// A share of the cage's own matrix and that of the mesh, if there is one.
SparseMatrix sum_of(const SparseMatrix& of_cage, double share, const Matrix& of_mesh, int threads) {
  const auto fill = [&](int i, RowAccumulator<double>& column) {
    for (Eigen::Index j = 0; j < of_mesh.rows(); ++j)
      if (of_mesh(j, i) != 0) column[static_cast<int>(j)] += of_mesh(j, i);
    for (SparseMatrix::InnerIterator it(of_cage, i); it; ++it) column[static_cast<int>(it.row())] += share * it.value();
  };
  return assemble_matrix(static_cast<int>(of_cage.rows()), threads, fill, {});
}

/// Gives the energy the cells of the mesh, if there is one, and then the same share of the cage's own.
void add_cells(CellEnergy& energy, const Surface& of_cage, double share, const Subspace* of_mesh, int threads,
               const MeterPart& meter) {
  const Rows cells = of_mesh != nullptr ? of_mesh->cells() : Rows();
  std::vector<int> homes = of_mesh != nullptr ? of_mesh->homes() : std::vector<int>();
  const auto n_of_mesh = static_cast<int>(homes.size());
  const Cells& own = of_cage.energy().cells;
  const std::vector<int> vertices = inverse_permutation(of_cage.numbers);
  for (int cell = 0; cell < own.size(); ++cell) homes.push_back(own.home(cell) < 0 ? -1 : vertices[own.home(cell)]);
  const auto fill = [&](int j, RowAccumulator<Vector3>& row) {
    for (int cell = 0; cell < n_of_mesh; ++cell)
      if (const Vector3 q = cells.row(cell).segment<3>(3 * std::ptrdiff_t{j}); homes[cell] == j || !q.isZero(0))
        row[cell] += q;
    own.for_each_cell(of_cage.numbers[j], [&](int cell, const Vector3& q) { row[n_of_mesh + cell] += share * q; });
  };
  Cells::Rows rows(energy.n_vertices(), static_cast<int>(homes.size()), threads, [&] { return fill; });
  take_cells(energy, std::move(rows), homes, nullptr, threads, meter);
}

}  // namespace

void assemble_cage_energy(PreparedModel& model, const PolygonMesh& cage, const PolygonMesh& mesh,
                          const std::vector<int>& carried, const CagePoints& points, const CageArapOptions& options,
                          const MeterPart& meter) {
  const int threads = model.workers.threads();
  model.rest = cage.positions();
  model.part_of_vertex = cage.part_of_vertex();
  model.n_parts = cage.n_parts();
  const Surface of_cage(cage, options.rigidity_radius, threads);
  if (options.energy == CageEnergy::kCage) {
    model.energy.K = of_cage.matrix();
    add_cells(model.energy, of_cage, 1, nullptr, threads, meter);
    model.energy.rest_energy = of_cage.energy().rest_energy;
    return;
  }
  const Surface of_mesh(mesh, options.rigidity_radius, threads);
  meter.add(0.2);
  constexpr double kBytesOfNumber = 8;
  constexpr double kBytesOfIncidence = 80;  // three numbers here, and both ways in the cells
  require_memory(
      (kBytesOfNumber * mesh.n_vertices() + kBytesOfIncidence * of_mesh.energy().n_cells()) * cage.n_vertices(),
      "this mesh in the space of this cage");
  const Subspace subspace(of_mesh, points, carried);
  model.energy.K = sum_of(of_cage.matrix(), kShareOfCage, subspace.matrix(meter.part(0.6)), threads);
  add_cells(model.energy, of_cage, kShareOfCage, &subspace, threads, meter.part(0.2));
  model.energy.rest_energy = of_mesh.energy().rest_energy + kShareOfCage * of_cage.energy().rest_energy;
}

}  // namespace arap
