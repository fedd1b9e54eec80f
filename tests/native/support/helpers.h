// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arap/surface_arap.h"
#include "energy/cell_energy.h"
#include "sampling/edge_graph.h"
#include "sampling/rotation_nodes.h"
#include "support/meshes.h"
#include "support/reference.h"

namespace arap_test {

/// Fails unless `act` throws E with a message that holds each of `words`, in any case.
template <class E, class Act>
void expect_error(const Act& act, std::initializer_list<std::string_view> words) {
  const auto lower = [](std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
    return result;
  };
  try {
    act();
  } catch (const E& error) {
    for (const std::string_view word : words)
      EXPECT_NE(lower(error.what()).find(lower(word)), std::string::npos)
          << "'" << word << "' is not in the message: " << error.what();
    return;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another kind of exception: " << error.what();
    return;
  }
  ADD_FAILURE() << "nothing was thrown";
}

/// Constraints and their targets.
struct Task {
  arap::ConstraintSet constraints;
  Positions targets;

  void add(int vertex, const Vector3& target, double strength = 1);
  /// Call after all add(): the targets of patches come last.
  void add_patch(const std::vector<int>& vertices, const std::vector<double>& weights, const Vector3& target);
};

/// The ceil(fraction n) vertices, at least `least`, that are lowest along `axis`; the highest ones if `fraction` < 0.
std::vector<int> extreme_vertices(const Positions& positions, int axis, double fraction, int least = 1);

/// Axis along which the bounding box is longest.
int longest_axis(const Positions& positions);

/// Hard constraints on both ends along the longest axis, a fifth of the vertices each, at least three. The far end
/// moves by `motion` about its centre.
Task bend_task(const MeshData& mesh, const RigidMotion& motion);

/// A turn by 40 degrees and a shift by a tenth of the diagonal.
RigidMotion default_bend(const MeshData& mesh);

/// (n_targets, 3) the positions of the constrained vertices, then the averages of the patches.
Positions values_of(const arap::ConstraintSet& constraints, const Positions& positions);

/// The constraints with targets that are their rest positions moved by `motion`.
Task rigid_task(const MeshData& mesh, const arap::ConstraintSet& constraints, const RigidMotion& motion);

/// Hard constraints that hold the vertices at rest.
Task hold(const MeshData& mesh, const std::vector<int>& vertices);

arap::VertexProperties with_regions(std::vector<int> regions);

/// The library's own solver, as a factory.
constexpr const arap::SolverFactory* kOwnSolver = nullptr;
/// Eigen's Cholesky, in double: one correction is exact.
const arap::SolverFactory* exact_solver();

/// With a linear solver in double: every single iteration is exact, not only the limit.
arap::Options exactly(arap::Options options = {});

/// Exactly n iterations, unless nothing moves at all.
arap::SolveOptions iterations(int n, arap::InitialGuess guess = arap::InitialGuess::kPrevious);

/// The same without acceleration.
arap::SolveOptions plain_iterations(int n, arap::InitialGuess guess = arap::InitialGuess::kPrevious);

arap::SolveOptions to_accuracy(double accuracy, arap::InitialGuess guess = arap::InitialGuess::kPrevious,
                               int max_iterations = 200000);

/// Binds, sets the constraints and solves.
arap::SolveResult solve_once(const MeshData& mesh, const Task& task, const arap::SolveOptions& solve_options,
                             const arap::Options& options = {}, const arap::VertexProperties& properties = {});

/// Largest distance between rows.
double max_distance(const Positions& a, const Positions& b);

/// Largest distance between `posed` and its best rigid fit to `rest`, at `vertices`.
double off_rigid(const Positions& rest, const Positions& posed, const std::vector<int>& vertices);

/// sum_k weights[k] points[vertices[k]] / sum_k weights[k]
Vector3 average(const Positions& points, std::span<const int> vertices, std::span<const double> weights);

/// (n, 3) derivative of `function` at `p`, by central differences of width 2 h.
Positions differences(const std::function<double(const Positions&)>& function, Positions p, double h);

/// `rows` of `positions`.
Positions rows(const Positions& positions, const std::vector<int>& rows);

/// Expects that the energy after k + 1 iterations from rest is not higher than after k, for k < n.
/// @param options   guess and max_iterations are overwritten
/// @param rounding  tolerance relative to the initial energy plus the squared diagonal
void expect_energy_never_rises(arap::SurfaceArap& solver, const MeshData& mesh, const Positions& targets, int n,
                               const std::string& what, arap::SolveOptions options = iterations(1),
                               double rounding = 1e-13);

/// Energy and weights: the parameter of tests over all models.
struct Model {
  arap::Energy energy;
  arap::EdgeWeights weights;
  double rigidity_radius = arap::Options().rigidity_radius;

  [[nodiscard]] arap::Options options() const;
  [[nodiscard]] std::string name() const;
};
/// The models with one cell a vertex.
std::vector<Model> classic_models();
/// These and rotation nodes, whose radius spans several vertices even on small meshes.
std::vector<Model> all_models();

/// The energy of a surface, numbered as the mesh.
arap::CellEnergy surface_energy(const arap::PolygonMesh& mesh, const arap::Options& options = {},
                                const std::vector<double>& stiffness = {}, int threads = 1,
                                const std::function<arap::RotationNodes()>& choose_nodes = {});
/// A vertex of a cell and its rest vector.
struct CellEntry {
  int vertex;
  Vector3 q;
};
/// Cells of these entries, the first of each being its home.
arap::Cells make_cells(int n_vertices, const std::vector<std::vector<CellEntry>>& cells);
/// The entries of a cell, its home first.
std::vector<CellEntry> entries_of(const arap::Cells& cells, int cell);

/// The mesh in model space: centred, diagonal 1.
MeshData in_model_space(const MeshData& mesh);
/// Nodes of a mesh in model space.
arap::RotationNodes choose_nodes(const MeshData& mesh, double radius, const std::vector<std::vector<int>>& mirrors = {},
                                 const std::vector<int>& group = {}, int threads = 1);
/// Edges of a mesh, without links across its thickness.
arap::EdgeGraph edge_graph(const MeshData& mesh);
/// (n, n_nodes) weights.
Eigen::MatrixXd dense_weights(const arap::RotationNodes& nodes, int n);

/// The reference of a model, with the rotation nodes that the library chooses.
struct ModelReference : Reference {
  ModelReference(const MeshData& mesh, const Model& model, const std::vector<double>& stiffness = {},
                 const std::vector<int>& region_of_vertex = {});

  std::vector<int> homes;  ///< the vertex of each cell
};

/// Expects that a solve from rest converges where the model's reference does.
void expect_ends_at_reference(const MeshData& mesh, const Task& task, const Model& model,
                              const std::vector<double>& stiffness = {});

/// Tests of every model.
class OfEachModel : public testing::TestWithParam<Model> {
 protected:
  [[nodiscard]] static arap::Options options() { return GetParam().options(); }
  [[nodiscard]] static ModelReference reference(const MeshData& mesh, const std::vector<double>& stiffness = {},
                                                const std::vector<int>& region_of_vertex = {}) {
    return {mesh, GetParam(), stiffness, region_of_vertex};
  }
};

inline std::string model_name(const testing::TestParamInfo<Model>& info) { return info.param.name(); }

}  // namespace arap_test
