// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/embedded_deformation.h"

#include <utility>

#include "base/option_bounds.h"
#include "geometry/rotation.h"
#include "mesh/surface_measures.h"
#include "models/embedded_deformation/newton_steps.h"
#include "models/input_checks.h"
#include "models/model_space.h"
#include "models/user_vertices.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

void require_weight(const char* name, double weight) {
  // Terms that differ by more: a step is lost in the largest of them.
  require_between(name, weight, 0.1, 1000);
}

/// In model space.
GraphConstraints constraints_on(const DeformationGraph& graph, const ConstraintSet& set) {
  GraphConstraints result;
  for (size_t k = 0; k < set.vertices.size(); ++k) {
    const double strength = set.strengths.empty() ? 1 : set.strengths[k];
    result.combinations.push_back(graph.of_state({set.vertices[k]}, {1}));
    result.weights.push_back(strength < 1 ? strength / (1 - strength) : LinearRows::kHard);
  }
  const Patches& patches = set.patches;
  for (int p = 0; p < patches.size(); ++p) {
    const std::vector<int> vertices(patches.vertices.begin() + patches.offsets[p],
                                    patches.vertices.begin() + patches.offsets[p + 1]);
    std::vector<double> factors(patches.weights.begin() + patches.offsets[p],
                                patches.weights.begin() + patches.offsets[p + 1]);
    double sum = 0;
    for (const double factor : factors) sum += factor;
    for (double& factor : factors) factor /= sum;
    result.combinations.push_back(graph.of_state(vertices, factors));
    result.weights.push_back(LinearRows::kHard);
  }
  return result;
}

}  // namespace

void EmbeddedOptions::validate() const {
  constexpr double kSmallest = 0.005;
  require_between("node_distance", node_distance, kSmallest, 1);
  require_weight("rotation_weight", rotation_weight);
  require_weight("regularization_weight", regularization_weight);
  require_weight("constraint_weight", constraint_weight);
  require_threads(threads);
}

struct EmbeddedDeformation::Impl {
  /// Where the mesh is.
  struct Pose {
    Positions state;
    std::vector<std::pair<int, Eigen::RowVector3d>> loose;  ///< held vertices that no node moves, and their places
  };

  Impl(const PolygonMesh& mesh, const EmbeddedOptions& of_bind, const Progress& progress)
      : space(mesh),
        options(of_bind),
        n_parts(mesh.n_parts()),
        workers(choose_threads(of_bind.threads, mesh.n_vertices())),
        user(space, mesh.part_of_vertex(), workers) {
    Meter meter(progress, "binding was cancelled");
    graph = make_graph(space.make_model(mesh), options, workers.threads(), {&meter, 1});
    reset();
    meter.reach(1);
  }

  void reset() { take({graph.rest_state(), {}}); }

  void take(Pose next) noexcept {
    pose = std::move(next);
    if (solver) solver->forget();
  }

  void set_constraints(const ConstraintSet& set, const Progress& progress) {
    user.require_constraints(set);
    if (solver && set == constraints) return;
    Meter meter(progress, "setting constraints was cancelled");
    ConstraintSet copy = set;
    const std::vector<char> is_held = held_parts(set);
    std::vector<char> node_is_held;
    node_is_held.reserve(graph.size());
    for (const int v : graph.vertices) node_is_held.push_back(is_held[user.part_of_vertex()[v]]);
    auto next = std::make_unique<NewtonSteps>(graph, options, constraints_on(graph, space.to_model(set)), node_is_held,
                                              workers, MeterPart{&meter, 1});
    std::vector<int> at_rest;
    for (int part = 0; part < n_parts; ++part)
      if (is_held[part] == 0) at_rest.push_back(part);
    Positions state = graph.rest_state();
    for (int j = 0; j < graph.size(); ++j)
      if (node_is_held[j] != 0) rows_of(state, j) = rows_of(pose.state, j);
    meter.reach(1);
    // Nothing fails from here on.
    if (solver) former_factorizations += solver->n_factorizations();
    solver = std::move(next);
    constraints = std::move(copy);
    parts_at_rest = std::move(at_rest);
    pose.loose.clear();
    pose.state.swap(state);
  }

  SolveResult solve(const Positions& targets, const SolveOptions& with, const Progress& progress,
                    std::span<float> out) {
    const Positions of_model = space.targets_to_model(targets, constraints);
    Pose next{start(with.initial_guess, of_model), loose_at(of_model)};
    SolveResult result;
    result.parts_at_rest = parts_at_rest;
    result.loose_vertices = user.loose_vertices();
    NewtonSteps::Report report;
    try {
      report = solver->solve(of_model, with, progress, next.state);
      const bool is_done = report.stop_reason != StopReason::kCancelled;
      if (!user.hand_over(placed(is_done ? next : pose), out, result))
        throw SolverError("the positions are too large for a number; look for targets far away");
      if (is_done)
        pose = std::move(next);
      else
        solver->forget();
    } catch (...) {
      solver->forget();
      if (!out.empty()) static_cast<void>(user.hand_over(placed(pose), out, result));
      throw;
    }
    result.energy_before = report.energy_before;
    result.energy_after = report.energy_after;
    result.iterations = report.iterations;
    result.step = report.step;
    result.stop_reason = report.stop_reason;
    return result;
  }

  /// Each node as its neighbourhood has turned and moved.
  void fit(const Positions& positions) {
    const Positions to = user.checked_to_model(positions);
    std::vector<Matrix3> covariances(graph.size(), Matrix3::Zero());
    std::vector<Moments> moments(graph.size());
    for_entries([&](int v, int j, double weight) {
      moments[j].weight += weight;
      moments[j].from += weight * graph.rest.row(v);
      moments[j].to += weight * to.row(v);
    });
    for (Moments& of_node : moments) {
      of_node.from /= of_node.weight;
      of_node.to /= of_node.weight;
    }
    for_entries([&](int v, int j, double weight) {
      covariances[j] += weight * (to.row(v) - moments[j].to).transpose() * (graph.rest.row(v) - moments[j].from);
    });
    Pose next{graph.rest_state(), {}};
    for (int j = 0; j < graph.size(); ++j) {
      const Matrix3 R = nearest_rotation(covariances[j], Matrix3::Identity());
      rows_of(next.state, j).topRows<3>() = R.transpose();
      rows_of(next.state, j).row(3) =
          moments[j].to - moments[j].from + (moments[j].from - graph.node(j)) * (Matrix3::Identity() - R.transpose());
    }
    for (const int v : user.loose_vertices()) next.loose.emplace_back(v, to.row(v));
    take(std::move(next));
  }

  [[nodiscard]] Positions positions() const { return space.to_input(placed(pose), workers); }

  [[nodiscard]] int n_factorizations() const {
    return former_factorizations + (solver ? solver->n_factorizations() : 0);
  }

  ModelSpace space;
  EmbeddedOptions options;
  int n_parts;
  Workers workers;
  UserVertices user;
  DeformationGraph graph;
  ConstraintSet constraints;
  std::unique_ptr<NewtonSteps> solver;
  Pose pose;
  int former_factorizations = 0;
  std::vector<int> parts_at_rest;

  struct Moments {
    double weight = 0;
    Eigen::RowVector3d from = Eigen::RowVector3d::Zero();
    Eigen::RowVector3d to = Eigen::RowVector3d::Zero();
  };

  template <class Use>
  void for_entries(const Use& use) const {
    for (int v = 0; v < space.n_input_vertices(); ++v)
      for (int k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) use(v, graph.nodes[k], graph.weights[k]);
  }

  [[nodiscard]] std::vector<char> held_parts(const ConstraintSet& set) const {
    const std::vector<int>& part_of_vertex = user.part_of_vertex();
    std::vector<char> is_held(n_parts, 0);
    for (const int v : set.vertices)
      if (part_of_vertex[v] >= 0) is_held[part_of_vertex[v]] = 1;
    for (size_t k = 0; k < set.patches.vertices.size(); ++k)
      if (set.patches.weights[k] > 0) is_held[part_of_vertex[set.patches.vertices[k]]] = 1;
    return is_held;
  }

  [[nodiscard]] Positions start(InitialGuess guess, const Positions& targets) const {
    switch (guess) {
      case InitialGuess::kPrevious:
        return pose.state;
      case InitialGuess::kHandleRotations:
        return solver->turned(targets, graph.rest_state());
      default:
        return graph.rest_state();
    }
  }

  [[nodiscard]] std::vector<std::pair<int, Eigen::RowVector3d>> loose_at(const Positions& targets) const {
    std::vector<std::pair<int, Eigen::RowVector3d>> loose;
    for (size_t k = 0; k < constraints.vertices.size(); ++k)
      if (user.part_of_vertex()[constraints.vertices[k]] < 0)
        loose.emplace_back(constraints.vertices[k], targets.row(static_cast<Eigen::Index>(k)));
    return loose;
  }

  /// (n, 3) in the model.
  [[nodiscard]] Positions placed(const Pose& of) const {
    Positions result;
    graph.move(of.state, workers, result);
    for (const auto& [v, place] : of.loose) result.row(v) = place;
    return result;
  }
};

EmbeddedDeformation::EmbeddedDeformation(const PolygonMesh& mesh, const EmbeddedOptions& options,
                                         const Progress& progress) {
  options.validate();
  require_surface(mesh);
  impl_ = std::make_unique<Impl>(mesh, options, progress);
}

EmbeddedDeformation::~EmbeddedDeformation() = default;
EmbeddedDeformation::EmbeddedDeformation(EmbeddedDeformation&&) noexcept = default;
EmbeddedDeformation& EmbeddedDeformation::operator=(EmbeddedDeformation&&) noexcept = default;

void EmbeddedDeformation::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  impl_->set_constraints(constraints, progress);
}

SolveResult EmbeddedDeformation::solve(const Positions& targets, const SolveOptions& options,
                                       std::span<const Matrix3> rotations, const Progress& progress,
                                       std::span<float> out) {
  options.validate();
  require_constrained(impl_->solver != nullptr);
  require_targets(impl_->constraints, targets, rotations);
  require_out(out, n_vertices());
  return impl_->solve(targets, options, progress, out);
}

void EmbeddedDeformation::reset() { impl_->reset(); }

void EmbeddedDeformation::set_positions(const Positions& positions) { impl_->fit(positions); }

Positions EmbeddedDeformation::positions() const { return impl_->positions(); }

Positions EmbeddedDeformation::nodes() const {
  Positions result(n_nodes(), 3);
  for (int j = 0; j < n_nodes(); ++j) result.row(j) = impl_->graph.node(j);
  return impl_->space.points_to_input(result);
}

int EmbeddedDeformation::n_nodes() const { return impl_->graph.size(); }
int EmbeddedDeformation::n_vertices() const { return impl_->user.size(); }
int EmbeddedDeformation::n_parts() const { return impl_->n_parts; }
const std::vector<int>& EmbeddedDeformation::part_of_vertex() const { return impl_->user.part_of_vertex(); }
const std::vector<int>& EmbeddedDeformation::loose_vertices() const { return impl_->user.loose_vertices(); }
int EmbeddedDeformation::n_parts_at_rest() const { return static_cast<int>(impl_->parts_at_rest.size()); }
int EmbeddedDeformation::n_factorizations() const { return impl_->n_factorizations(); }
int EmbeddedDeformation::threads() const { return impl_->workers.threads(); }

}  // namespace arap
