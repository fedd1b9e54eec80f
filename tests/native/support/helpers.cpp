// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/helpers.h"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/eigen_compat.h"
#include "mesh/mirror_symmetry.h"
#include "mesh/thickness_links.h"
#include "models/model_space.h"
#include "models/surface_arap/surface_energies.h"
#include "references/eigen_solvers.h"
#include "sampling/rotation_nodes.h"
#include "sampling/surface_patch.h"

namespace arap_test {

void Task::add(int vertex, const Vector3& target, double strength) {
  constraints.vertices.push_back(vertex);
  constraints.strengths.push_back(strength);
  targets.conservativeResize(targets.rows() + 1, 3);
  targets.bottomRows(1) = target.transpose();
}

void Task::add_patch(const std::vector<int>& vertices, const std::vector<double>& weights, const Vector3& target) {
  auto& patches = constraints.patches;
  if (patches.offsets.empty()) patches.offsets.push_back(0);
  patches.vertices.insert(patches.vertices.end(), vertices.begin(), vertices.end());
  patches.weights.insert(patches.weights.end(), weights.begin(), weights.end());
  patches.offsets.push_back(static_cast<int>(patches.vertices.size()));
  targets.conservativeResize(targets.rows() + 1, 3);
  targets.bottomRows(1) = target.transpose();
}

std::vector<int> extreme_vertices(const Positions& positions, int axis, double fraction, int least) {
  std::vector<int> order(static_cast<size_t>(positions.rows()));
  std::iota(order.begin(), order.end(), 0);
  const double sign = fraction < 0 ? -1 : 1;
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return sign * positions(a, axis) < sign * positions(b, axis); });
  const double count = std::ceil(std::abs(fraction) * static_cast<double>(order.size()));
  order.resize(std::min(order.size(), static_cast<size_t>(std::max(count, double(least)))));
  return order;
}

int longest_axis(const Positions& positions) {
  int axis = 0;
  (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).maxCoeff(&axis);
  return axis;
}

Task bend_task(const MeshData& mesh, const RigidMotion& motion) {
  const Positions p = mesh.positions();
  const int axis = longest_axis(p);
  Task task;
  for (const int v : extreme_vertices(p, axis, .2, 3)) task.add(v, mesh.vertices[v]);
  const std::vector<int> far_end = extreme_vertices(p, axis, -.2, 3);
  const Vector3 centre = rows(p, far_end).colwise().mean().transpose();
  for (const int v : far_end) {
    const auto& pinned = task.constraints.vertices;
    if (std::find(pinned.begin(), pinned.end(), v) == pinned.end())
      task.add(v, centre + motion.apply(Vector3(mesh.vertices[v] - centre)));
  }
  return task;
}

RigidMotion default_bend(const MeshData& mesh) {
  return {rotation_about({1, .5, .3}, .7), Vector3(.04, .08, .04) * mesh.diagonal()};
}

Positions values_of(const arap::ConstraintSet& constraints, const Positions& positions) {
  Positions values(constraints.n_targets(), 3);
  const auto n = static_cast<Eigen::Index>(constraints.vertices.size());
  values.topRows(n) = rows(positions, constraints.vertices);
  const auto& [offsets, vertices, weights] = constraints.patches;
  for (int k = 0; k < constraints.patches.size(); ++k) {
    const auto first = static_cast<size_t>(offsets[k]);
    const size_t size = static_cast<size_t>(offsets[k + 1]) - first;
    values.row(n + k) =
        average(positions, std::span(vertices).subspan(first, size), std::span(weights).subspan(first, size));
  }
  return values;
}

Task rigid_task(const MeshData& mesh, const arap::ConstraintSet& constraints, const RigidMotion& motion) {
  return {constraints, values_of(constraints, motion.apply(mesh.positions()))};
}

Task hold(const MeshData& mesh, const std::vector<int>& vertices) {
  Task task;
  for (const int v : vertices) task.add(v, mesh.vertices[v]);
  return task;
}

arap::VertexProperties with_regions(std::vector<int> regions) {
  arap::VertexProperties properties;
  properties.rigid_regions = std::move(regions);
  return properties;
}

arap::SolveOptions iterations(int n, arap::InitialGuess guess) {
  arap::SolveOptions options;
  options.initial_guess = guess;
  options.max_iterations = n;
  options.accuracy = 0;
  return options;
}

const arap::SolverFactory* exact_solver() { return &arap::reference_solver(arap::ReferenceSolver::kSimplicialLdlt); }

arap::Options exactly(arap::Options options) {
  options.solver_factory = exact_solver();
  return options;
}

arap::SolveOptions plain_iterations(int n, arap::InitialGuess guess) {
  arap::SolveOptions options = iterations(n, guess);
  options.acceleration = arap::Acceleration::kNone;
  return options;
}

arap::SolveOptions to_accuracy(double accuracy, arap::InitialGuess guess, int max_iterations) {
  arap::SolveOptions options;
  options.initial_guess = guess;
  options.max_iterations = max_iterations;
  options.accuracy = accuracy;
  return options;
}

void expect_energy_never_rises(arap::SurfaceArap& solver, const MeshData& mesh, const Positions& targets, int n,
                               const std::string& what, arap::SolveOptions options, double rounding) {
  options.initial_guess = arap::InitialGuess::kRest;
  double energy = std::numeric_limits<double>::infinity();
  for (int k = 1; k <= n; ++k) {
    options.max_iterations = k;
    const arap::SolveResult result = solver.solve(targets, options);
    const double limit = k == 1 ? result.energy_before : energy;
    const double scale = result.energy_before + mesh.diagonal() * mesh.diagonal();
    EXPECT_LE(result.energy_after, limit + rounding * scale) << what << ", iteration " << k;
    energy = result.energy_after;
  }
}

arap::SolveResult solve_once(const MeshData& mesh, const Task& task, const arap::SolveOptions& solve_options,
                             const arap::Options& options, const arap::VertexProperties& properties) {
  arap::SurfaceArap solver(mesh.mesh(), options, properties);
  solver.set_constraints(task.constraints);
  return solver.solve(task.targets, solve_options);
}

double max_distance(const Positions& a, const Positions& b) { return (a - b).rowwise().norm().maxCoeff(); }

double off_rigid(const Positions& rest, const Positions& posed, const std::vector<int>& vertices) {
  const Positions from = rows(rest, vertices);
  const Positions to = rows(posed, vertices);
  return max_distance(best_rigid_motion(from, to).apply(from), to);
}

Vector3 average(const Positions& points, std::span<const int> vertices, std::span<const double> weights) {
  Vector3 sum = Vector3::Zero();
  for (size_t k = 0; k < vertices.size(); ++k) sum += weights[k] * points.row(vertices[k]).transpose();
  return sum / std::accumulate(weights.begin(), weights.end(), 0.0);
}

Positions differences(const std::function<double(const Positions&)>& function, Positions p, double h) {
  Positions result(p.rows(), 3);
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    const double middle = p.data()[k];
    p.data()[k] = middle + h;
    const double forth = function(p);
    p.data()[k] = middle - h;
    result.data()[k] = (forth - function(p)) / (2 * h);
    p.data()[k] = middle;
  }
  return result;
}

Positions rows(const Positions& positions, const std::vector<int>& rows) { return positions(rows, arap::all); }

arap::Options Model::options() const {
  arap::Options options;
  options.energy = energy;
  options.weights = weights;
  options.rigidity_radius = rigidity_radius;
  return options;
}

std::string Model::name() const {
  const char* const kind = energy == arap::Energy::kSpokes          ? "Spokes"
                           : energy == arap::Energy::kSpokesAndRims ? "SpokesAndRims"
                                                                    : "RotationNodes";
  return std::string(kind) + (weights == arap::EdgeWeights::kCotangent ? "Cotangent" : "Uniform");
}

std::vector<Model> classic_models() {
  using arap::EdgeWeights;
  using arap::Energy;
  return {{Energy::kSpokesAndRims, EdgeWeights::kCotangent},
          {Energy::kSpokesAndRims, EdgeWeights::kUniform},
          {Energy::kSpokes, EdgeWeights::kCotangent},
          {Energy::kSpokes, EdgeWeights::kUniform}};
}

std::vector<Model> all_models() {
  std::vector<Model> models = classic_models();
  models.push_back({arap::Energy::kRotationNodes, arap::EdgeWeights::kCotangent, .2});
  return models;
}

arap::CellEnergy surface_energy(const arap::PolygonMesh& mesh, const arap::Options& options,
                                const std::vector<double>& stiffness, int threads,
                                const std::function<arap::RotationNodes()>& choose_nodes) {
  arap::CellEnergy energy;
  arap::assemble_surface_energy(energy, mesh, options, stiffness, threads, {}, choose_nodes);
  return energy;
}

arap::Cells make_cells(int n_vertices, const std::vector<std::vector<CellEntry>>& cells) {
  std::vector<int> homes;
  std::vector<std::vector<std::pair<int, Vector3>>> at(static_cast<size_t>(n_vertices));
  for (const std::vector<CellEntry>& cell : cells) {
    for (const auto& [v, q] : cell) at[v].emplace_back(static_cast<int>(homes.size()), q);
    homes.push_back(cell.empty() ? 0 : cell.front().vertex);
  }
  arap::Cells::Rows rows(n_vertices, static_cast<int>(cells.size()), 1, [&] {
    return [&](int v, arap::RowAccumulator<Vector3>& row) {
      for (const auto& [c, q] : at[v]) row[c] += q;
    };
  });
  return {std::move(rows), homes};
}

std::vector<CellEntry> entries_of(const arap::Cells& cells, int cell) {
  if (cells.home(cell) < 0) return {};
  std::vector<CellEntry> entries{{cells.home(cell), Vector3::Zero()}};
  cells.for_each_vertex(cell, [&](int v, const Vector3& q) {
    entries.push_back({v, q});
    entries.front().q -= q;
  });
  return entries;
}

MeshData in_model_space(const MeshData& mesh) {
  const Positions rest = arap::ModelSpace(mesh.mesh()).points_to_model(mesh.positions());
  MeshData result = mesh;
  for (int v = 0; v < mesh.n_vertices(); ++v) result.vertices[v] = rest.row(v).transpose();
  return result;
}

arap::EdgeGraph edge_graph(const MeshData& mesh) { return {surface_energy(mesh.mesh()).K, mesh.positions(), 1}; }

arap::RotationNodes choose_nodes(const MeshData& mesh, double radius, const std::vector<std::vector<int>>& mirrors,
                                 const std::vector<int>& group, int threads) {
  const arap::PolygonMesh polygons = mesh.mesh();
  const arap::EdgeGraph graph(surface_energy(polygons).K, mesh.positions(), threads,
                              arap::find_thickness_links(polygons, radius, mirrors, threads));
  return arap::choose_rotation_nodes(graph, polygons, arap::vertex_areas(polygons), radius, mirrors, group, threads);
}

Eigen::MatrixXd dense_weights(const arap::RotationNodes& nodes, int n) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(n, nodes.size());
  for (int j = 0; j < n; ++j)
    for (int k = nodes.offsets[j]; k < nodes.offsets[j + 1]; ++k) W(j, nodes.nodes[k]) += nodes.weights[k];
  return W;
}

ModelReference::ModelReference(const MeshData& mesh, const Model& model, const std::vector<double>& stiffness,
                               const std::vector<int>& region_of_vertex)
    : Reference(mesh, model.energy, model.weights, stiffness) {
  if (model.energy != arap::Energy::kRotationNodes) {
    homes.resize(static_cast<size_t>(mesh.n_vertices()));
    std::iota(homes.begin(), homes.end(), 0);
    return;
  }
  const MeshData centred = in_model_space(mesh);
  const arap::RotationNodes nodes =
      choose_nodes(centred, model.rigidity_radius, arap::find_mirrors(centred.mesh(), 1), region_of_vertex);
  share_rotations(dense_weights(nodes, mesh.n_vertices()));
  homes = nodes.vertices;
}

void expect_ends_at_reference(const MeshData& mesh, const Task& task, const Model& model,
                              const std::vector<double>& stiffness) {
  const ModelReference plain(mesh, model, stiffness);
  const Reference::Solution expected =
      plain.solve(task.constraints, task.targets, plain.rest_guess(task.constraints, task.targets), 20000, 1e-10);
  const arap::SolveResult result =
      solve_once(mesh, task, to_accuracy(1e-10, arap::InitialGuess::kRest), model.options(), {stiffness, {}});
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged) << mesh.name << model.name();
  EXPECT_LT(max_distance(result.positions, expected.positions), 1e-6 * mesh.diagonal()) << mesh.name << model.name();
  EXPECT_NEAR(result.energy_after, expected.energies.back(), 1e-9 * expected.energies.back())
      << mesh.name << model.name();
}

}  // namespace arap_test
