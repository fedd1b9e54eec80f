// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/cage_transfer.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/eigen_compat.h"
#include "base/grouped.h"
#include "cages/cage_motion.h"
#include "cholesky/preconditioned_cg.h"
#include "cholesky/solver_choice.h"
#include "mesh/surface_measures.h"
#include "mesh/triangulation.h"
#include "models/input_checks.h"
#include "models/surface_arap/surface_assembler.h"
#include "parallel/meter.h"
#include "sparse/matrix_assembly.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

void require_same_faces(const PolygonMesh& source, const PolygonMesh& target) {
  require_surface(source, "the source");
  if (source.n_vertices() != target.n_vertices() || source.n_faces() != target.n_faces())
    throw InvalidInput(text("the target has ", target.n_vertices(), " vertices and ", target.n_faces(),
                            " faces, the source ", source.n_vertices(), " and ", source.n_faces(),
                            "; give cages of the same faces"));
  for (int f = 0; f < source.n_faces(); ++f)
    if (!std::equal(source.face(f).begin(), source.face(f).end(), target.face(f).begin(), target.face(f).end()))
      throw InvalidInput(text("face ", f,
                              " of the target has other vertices than that of the source; give cages of "
                              "the same faces"));
}

/// Two edges of a triangle and its normal, as long as the root of twice its area; singular where it has none.
Matrix3 frame(const Positions& p, const std::array<int, 3>& corners) {
  const Row u = p.row(corners[1]) - p.row(corners[0]);
  const Row v = p.row(corners[2]) - p.row(corners[0]);
  const Row normal = u.cross(v);
  const double twice_area = normal.norm();
  Matrix3 result;
  result << u.transpose(), v.transpose(), (twice_area > 0 ? Row(normal / std::sqrt(twice_area)) : normal).transpose();
  return result;
}

/// How the source has moved, component by component.
class SourceMotion {
 public:
  /// @param components  (n,) of each vertex the lowest one that is joined with it
  SourceMotion(const PolygonMesh& source, const Positions& moved, const std::vector<int>& components)
      : rest_(source.positions()), moved_(moved), components_(components) {
    const std::vector<int> used = vertices_in_faces(source);
    const Matrix3 whole = similarity_of(used);
    const Grouped members(source.n_vertices(), [&](const auto& add) {
      for (int v = 0; v < source.n_vertices(); ++v) add(components[v], v);
    });
    turns_.assign(components.size(), whole);
    for (int first = 0; first < source.n_vertices(); ++first)
      // A vertex alone tells no turn.
      if (members.of(first).size() > 1)
        turns_[first] = similarity_of({members.of(first).begin(), members.of(first).end()});
  }

  /// The linear part of the similarity that fits the motion of a vertex's component best.
  [[nodiscard]] const Matrix3& turn(int vertex) const { return turns_[components_[vertex]]; }

  /// Gradient of the triangle of these corners; of one without area that of its component.
  [[nodiscard]] Matrix3 gradient(const std::array<int, 3>& corners) const {
    const Matrix3 at_rest = frame(rest_, corners);
    constexpr double kLeast = 1e-6;  // of its height to its longest edge
    const double longest = at_rest.leftCols<2>().colwise().norm().maxCoeff();
    if (!(at_rest.col(2).squaredNorm() > kLeast * longest * longest)) return turn(corners[0]);
    return frame(moved_, corners) * at_rest.inverse();
  }

 private:
  [[nodiscard]] Matrix3 similarity_of(const std::vector<int>& vertices) const {
    return best_similarity(Positions(rest_(vertices, all)), Positions(moved_(vertices, all))).linear;
  }

  const Positions& rest_;
  const Positions& moved_;
  const std::vector<int>& components_;
  std::vector<Matrix3> turns_;  ///< of each component, by its lowest vertex
};

/// The energy of the target's gradients.
class TargetSystem {
 public:
  TargetSystem(const PolygonMesh& target, Meter& meter)
      : meter_(meter),
        rest_(target.positions().rowwise() - surface_box(target).center().transpose()),
        assembler_(target, options(), no_stiffness_) {
    const auto fill = [&](int i, RowAccumulator<double>& column) { assembler_.system_column(i, column); };
    K_ = assemble_matrix(target.n_vertices(), 1, fill, {&meter_, 0.2});
    components_ = connected_components(K_);
  }

  /// (n,) of each vertex the lowest one that is joined with it.
  [[nodiscard]] const std::vector<int>& components() const { return components_; }

  /// The positions whose gradients are nearest to those that the motion gives the triangles; each component is
  /// somewhere.
  [[nodiscard]] Positions driven_by(const SourceMotion& motion) const {
    Positions result(rest_.rows(), 3);
    for (int v = 0; v < static_cast<int>(rest_.rows()); ++v) result.row(v) = rest_.row(v) * motion.turn(v).transpose();
    Positions residual;
    multiply(K_, result, residual, workers_);
    residual = -residual;
    const auto drive = [&](const auto& items) {
      for (const auto& item : items) {
        const Matrix3 gradient = motion.gradient(item.vertices);
        add_rest_vectors(item, rest_, [&](int v, const Row& q) { residual.row(v) += q * gradient.transpose(); });
      }
    };
    meter_.tell();
    drive(assembler_.triangulation().triangles);
    drive(assembler_.triangulation().ties);
    return result + solved(std::move(residual));
  }

 private:
  static Options options() {
    Options result;
    result.energy = Energy::kSpokesAndRims;
    return result;
  }

  /// K^-1 b, 0 at the first vertex of each component.
  [[nodiscard]] Positions solved(Positions b) const {
    std::vector<char> is_fixed(components_.size());
    for (size_t v = 0; v < is_fixed.size(); ++v) is_fixed[v] = components_[v] == static_cast<int>(v) ? 1 : 0;
    const auto erase = [&](Positions& x) {
      for (size_t v = 0; v < is_fixed.size(); ++v)
        if (is_fixed[v] != 0) x.row(static_cast<Eigen::Index>(v)).setZero();
    };
    erase(b);
    const auto solver = make_linear_solver(K_, Workers(1), TileFormat::kHalf, {&meter_, 0.3});
    const auto factor = solver->factorize(K_, is_fixed, {&meter_, 0.3});
    meter_.tell();
    solve_with_cg(
        [&](const Positions& x, Positions& y) {
          multiply(K_, x, y, workers_);
          erase(y);
        },
        [&](Positions& residual, Positions& x) { factor->solve(residual, x); }, b, workers_);
    return b;
  }

  Meter& meter_;
  Positions rest_;  ///< centred: far from the origin, products with K lose digits
  std::vector<double> no_stiffness_;
  SurfaceAssembler assembler_;
  Workers workers_;
  SparseMatrix K_;
  std::vector<int> components_;
};

/// Of the points of each component the mean, by its lowest vertex.
Positions means_of(const std::vector<int>& components, const Positions& points) {
  Positions means = Positions::Zero(points.rows(), 3);
  std::vector<int> count(components.size(), 0);
  for (size_t v = 0; v < components.size(); ++v) {
    means.row(components[v]) += points.row(static_cast<Eigen::Index>(v));
    ++count[components[v]];
  }
  for (size_t v = 0; v < components.size(); ++v) means.row(static_cast<Eigen::Index>(v)) /= std::max(1, count[v]);
  return means;
}

Row middle_of(const PolygonMesh& mesh) {
  return Positions(mesh.positions()(vertices_in_faces(mesh), all)).colwise().mean();
}

}  // namespace

inline namespace ARAP_COMPILED_ALIKE {

Positions transfer_cage(const PolygonMesh& source, const Positions& moved_source, const PolygonMesh& target,
                        const Progress& progress) {
  require_same_faces(source, target);
  require_rows("moved_source", moved_source.rows(), source.n_vertices());
  require_finite("moved_source", moved_source, [](int v) { return text("vertex ", v); });
  Meter meter(progress, "the transfer was cancelled");
  const TargetSystem system(target, meter);
  const std::vector<int>& components = system.components();
  const SourceMotion motion(source, moved_source, components);
  Positions result = system.driven_by(motion);
  const Positions of_source = means_of(components, source.positions());
  const Positions of_moved = means_of(components, moved_source);
  const Positions of_target = means_of(components, target.positions());
  const Positions of_result = means_of(components, result);
  const Row shift = middle_of(target) - middle_of(source);
  // Components go as those of the source do. What they are elsewhere than these, seen from the middle, turns with them:
  // so those that turn alike turn about the common middle, and one that stays is not moved by others.
  for (Eigen::Index v = 0; v < result.rows(); ++v) {
    const int c = components[v];
    const Row beside = of_target.row(c) - shift - of_source.row(c);
    const Row place = of_moved.row(c) + beside * motion.turn(c).transpose() + shift;
    result.row(v) += place - of_result.row(c);
  }
  meter.reach(1);
  return result;
}

}  // namespace ARAP_COMPILED_ALIKE
}  // namespace arap
