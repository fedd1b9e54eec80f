// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/surface_arap.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "base/format_message.h"
#include "constraints/bound_constraints.h"
#include "constraints/handle_rotations.h"
#include "constraints/rigid_regions.h"
#include "energy/cell_energy.h"
#include "energy/cell_passes.h"
#include "geometry/duplicate_points.h"
#include "models/model_space.h"
#include "models/surface_arap/surface_model.h"
#include "optimize/drag_predictor.h"
#include "optimize/initial_guess.h"
#include "optimize/local_global.h"
#include "optimize/nonlinear_cg.h"
#include "optimize/time_budget.h"
#include "parallel/parallel.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

/// Vertices closer than this part of the diagonal are at the same place.
constexpr double kSamePlace = 1e-9;

void require_lengths(const SurfaceArap::VertexProperties& properties, int n_vertices) {
  const auto n = static_cast<size_t>(n_vertices);
  if (!properties.stiffness.empty() && properties.stiffness.size() != n)
    throw InvalidInput(text("stiffness has ", properties.stiffness.size(), " entries, must have one per vertex, ", n));
  if (!properties.rigid_regions.empty() && properties.rigid_regions.size() != n)
    throw InvalidInput(
        text("rigid_regions has ", properties.rigid_regions.size(), " entries, must have one per vertex, ", n));
  for (size_t v = 0; v < properties.stiffness.size(); ++v)
    if (!(properties.stiffness[v] > 0) || std::isinf(properties.stiffness[v]))
      throw InvalidInput(text("stiffness of vertex ", v, " is ", properties.stiffness[v], ", must be finite and > 0"));
}

/// Radius of a patch, in rigidity radii.
constexpr double kPatchRadius = 1.5;

void require_rows(const char* what, Eigen::Index rows, Eigen::Index expected) {
  if (rows != expected) throw InvalidInput(text(what, " has ", rows, " rows, expected ", expected));
}

/// @param name  name(row) for the message
template <class Name>
void require_finite(const char* what, const Positions& positions, const Name& name) {
  constexpr double kLargest = 1e100;
  for (Eigen::Index k = 0; k < positions.rows(); ++k)
    if (!positions.row(k).allFinite() || positions.row(k).cwiseAbs().maxCoeff() > kLargest)
      throw InvalidInput(text(what, ": ", name(static_cast<int>(k)), " is (", positions(k, 0), ", ", positions(k, 1),
                              ", ", positions(k, 2), "), must be finite and below 1e100"));
}

/// What row k of the targets belongs to.
std::string target_name(const ConstraintSet& set, int k) {
  const int n_vertices = static_cast<int>(set.vertices.size());
  return k < n_vertices ? text("row ", k, ", vertex ", set.vertices[k], ",")
                        : text("row ", k, ", patch ", k - n_vertices, ",");
}

bool all_finite(const Workers& workers, const Positions& x) {
  return parallel_all<4096>(workers, static_cast<int>(x.rows()),
                            [&](int begin, int end) { return x.middleRows(begin, end - begin).allFinite(); });
}

/// Fits the rotations to positions that have nothing to do with those before; returns the sum of <R_c, Q_c>.
double fit_anew(CellPasses& passes, const Positions& positions) {
  passes.set_positions(positions);
  passes.reset_rotations();
  return passes.fit_rotations();
}

/// Of the first iterations: single where it can tell the edges of the mesh beside its whole extent.
Precision precision_for(const SolveOptions& options, const Positions& model_targets) {
  constexpr double kFinest = 1e-7;
  const bool is_coarse = options.accuracy >= kFinest;
  const bool is_near = model_targets.size() == 0 || model_targets.cwiseAbs().maxCoeff() <= kSinglePrecisionReach;
  return is_coarse && is_near ? Precision::kSingle : Precision::kDouble;
}

}  // namespace

struct SurfaceArap::Impl {
  Impl(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties, const Progress& progress)
      : space(mesh), input_part_of_vertex(mesh.n_vertices()) {
    const std::vector<int> same_as = coincident_with(space.points_to_model(mesh.positions()), kSamePlace,
                                                     choose_threads(options.threads, mesh.n_vertices()));
    report_coincident(same_as);
    if (options.join_seams) space.join(same_as);
    const PolygonMesh model_mesh = space.to_model(mesh);
    const std::vector<int> new_of_old = bind_surface(model, model_mesh, options, space.to_model(properties.stiffness),
                                                     space.regions_to_model(properties.rigid_regions), progress);
    space.renumber(new_of_old);
    for (size_t v = 0; v < input_part_of_vertex.size(); ++v) {
      input_part_of_vertex[v] = model.part_of_vertex[space.model_vertices()[v]];
      if (input_part_of_vertex[v] < 0) loose_vertices.push_back(static_cast<int>(v));
    }
    patch_radius = kPatchRadius * options.rigidity_radius;
    reset();
  }

  void report_coincident(const std::vector<int>& same_as) {
    std::vector<char> is_shared(same_as.size(), 0);
    for (size_t v = 0; v < same_as.size(); ++v)
      if (same_as[v] != static_cast<int>(v)) is_shared[v] = is_shared[same_as[v]] = 1;
    for (size_t v = 0; v < is_shared.size(); ++v)
      if (is_shared[v] != 0) coincident_vertices.push_back(static_cast<int>(v));
  }

  void reset() {
    if (steps != nullptr) steps->forget();
    pose.positions = model.rest;
    pose.rotations.assign(model.energy.n_cells(), Eigen::Quaterniond::Identity());
    pose.placements = model.regions.fit_placements(pose.positions);
  }

  SolveResult solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                    const Progress& progress, std::span<float> out);
  /// @param turns  rotation vectors of the targets' rows, no rows: nothing turns
  /// @param target_step  from the targets of the previous pose; no rows: unknown
  /// @param ahead  how far the forces begin ahead, see ForcePrediction
  /// Returns the largest movement of its global step, where that is half of an iteration.
  std::optional<double> apply_guess(const Positions& targets, InitialGuess guess, const Positions& turns,
                                    const Positions& target_step, double ahead);
  /// E at `positions` with the best rotations, on the model; sets the gradient.
  double evaluate(const Positions& positions, Positions& gradient) const {
    if (steps != nullptr) steps->forget();
    CellPasses& passes = model.passes(Precision::kDouble);
    double alignment = fit_anew(passes, positions);
    Positions of_turns = Positions::Zero(positions.rows(), 3);
    if (!model.regions.empty()) {
      Rotations rotations;
      passes.read_rotations(rotations);
      of_turns = model.regions.turn_cells(positions, rotations);
      passes.set_rotations(rotations);
      alignment = passes.alignment();
    }
    const double energy = passes.rest_energy() + passes.find_residual(gradient) - alignment;
    gradient = of_turns - gradient;
    return energy < 0 ? 0 : energy;
  }
  [[nodiscard]] Positions checked_to_model(const Positions& positions) const {
    require_rows("positions", positions.rows(), space.n_input_vertices());
    require_finite("positions", positions, [](int v) { return text("vertex ", v); });
    return space.to_model(positions, model.workers);
  }
  /// Puts the positions where they are wanted; false where they are not finite.
  [[nodiscard]] bool hand_over(SolveResult& result, std::span<float> out) const {
    if (!out.empty()) return space.write_to_input(pose.positions, model.workers, out);
    result.positions = space.to_input(pose.positions, model.workers);
    return all_finite(model.workers, pose.positions);
  }
  /// What a solve that fails goes back to.
  void keep_pose();
  void restore_pose();

  [[nodiscard]] Patch patch_around(const std::vector<int>& vertices, double radius) const;

  ModelSpace space;
  std::vector<int> loose_vertices;
  std::vector<int> coincident_vertices;
  std::vector<int> input_part_of_vertex;
  BoundModel model;
  ConstraintSet constraint_set;
  std::unique_ptr<BoundConstraints> constraints;
  std::unique_ptr<HandleTurns> handle_turns;
  std::unique_ptr<LocalGlobal> steps;   ///< over constraints
  std::unique_ptr<NonlinearCg> search;  ///< over steps
  Pose pose;
  Positions last_targets;      ///< of the pose; empty where it comes from somewhere else
  ForcePrediction prediction;  ///< of the next pose, from the last ones
  Pose kept;                   ///< lives as long as the model, so that its memory is there
  int n_factorizations = 0;
  double patch_radius;                          ///< of patches, where none is given
  mutable std::unique_ptr<EdgeGraph> graph;  ///< of the model; made when first needed
};

Patch SurfaceArap::Impl::patch_around(const std::vector<int>& vertices, double radius) const {
  require_patch_sources(vertices, radius, input_part_of_vertex);
  if (graph == nullptr) graph = std::make_unique<EdgeGraph>(model.energy.K, model.rest, model.workers.threads());
  std::vector<int> sources;
  sources.reserve(vertices.size());
  for (const int v : vertices) sources.push_back(space.model_vertices()[v]);
  Patch patch = find_patch(*graph, model.areas, model.rest, sources, radius > 0 ? radius : patch_radius);
  for (int& v : patch.vertices) v = space.input_vertices()[v];
  patch.rest_position = space.to_input(Eigen::RowVector3d(patch.rest_position)).transpose();
  return patch;
}

void SurfaceArap::Impl::keep_pose() {
  copy_rows(model.workers, pose.positions, kept.positions);
  kept.placements = pose.placements;
  kept.rotations = pose.rotations;
}

void SurfaceArap::Impl::restore_pose() {
  steps->forget();
  copy_rows(model.workers, kept.positions, pose.positions);
  pose.placements = kept.placements;
  pose.rotations = kept.rotations;
}

std::optional<double> SurfaceArap::Impl::apply_guess(const Positions& targets, InitialGuess guess,
                                                     const Positions& turns, const Positions& target_step,
                                                     double ahead) {
  if (guess != InitialGuess::kPrevious) reset();
  // The centers of rigid regions depend on the constraints.
  pose.placements = constraints->regions().fit_placements(pose.positions);
  const bool has_torn = steps->impose_constraints(pose);
  if (guess == InitialGuess::kNaiveLaplacian) {
    if (!constraints->has_laplacian_system()) ++n_factorizations;
    guess_naive_laplacian(model, *constraints, steps->vertex_targets(), constraints->patch_targets(targets), pose);
  }
  // With the rotations of the former pose: fitted to a torn one, they would turn what a single handle only moves.
  if (turns.rows() > 0) {
    const double turn_range = spread_turns(model, *constraints, turns, pose);
    steps->forget();
    // Brings the patches to their targets too, as the plain one does.
    steps->global_step_to(guess_accuracy(turn_range), pose);
    return std::nullopt;
  }
  if (ahead != 0) return steps->global_step(pose, prediction, ahead);
  if (guess == InitialGuess::kPrevious && (has_torn || (target_step.array() != 0).any()))
    return steps->global_step(pose);
  steps->project_on_patches(pose);
  return std::nullopt;
}

SolveResult SurfaceArap::Impl::solve(const Positions& targets, const SolveOptions& options,
                                     std::span<const Matrix3> rotations, const Progress& progress,
                                     std::span<float> out) {
  TimeBudget time(options.time_limit_s);
  const Positions model_targets = space.points_to_model(targets);
  const bool is_going_on = options.initial_guess == InitialGuess::kPrevious && last_targets.rows() > 0;
  const bool goes_on_there = is_going_on && last_targets == model_targets && steps->knows_pose();
  // A search that has come to double stays there, although a single estimate may be of a greater distance again.
  const bool is_near = goes_on_there && (needs_double(search->distance(), options.accuracy) ||
                                         (steps->is_in_double() && ends_in_double(options.accuracy)));
  steps->aim(model_targets,
             is_near || constraints->is_weak_hold() ? Precision::kDouble : precision_for(options, model_targets));
  const Positions turns =
      handle_turns->of_start(options.initial_guess, last_targets, pose.positions, model_targets, rotations);
  const Positions target_step = is_going_on ? Positions(model_targets - last_targets) : Positions(0, 3);
  const double ahead = turns.rows() > 0 ? 0 : prediction.share(target_step);
  const bool is_drag = turns.rows() == 0 && (target_step.array() != 0).any();
  keep_pose();
  SolveResult result;
  IterationReport report;
  try {
    time.begin_iteration();
    const std::optional<double> step = apply_guess(model_targets, options.initial_guess, turns, target_step, ahead);
    if (step || !goes_on_there) search->restart();
    report = minimize(*steps, *search, pose, options, progress, time, step, [&] {
      if (is_drag) steps->show_forces_to(prediction, ahead);
    });
    if (report.stop_reason == StopReason::kCancelled) restore_pose();
    if (!std::isfinite(report.energy_after) || !hand_over(result, out))
      throw SolverError("the positions are no longer finite; the last good pose is kept");
  } catch (...) {
    prediction.forget();
    restore_pose();
    if (!out.empty()) static_cast<void>(space.write_to_input(pose.positions, model.workers, out));
    throw;
  }
  if (report.stop_reason != StopReason::kCancelled) {
    last_targets = model_targets;
    // Where the targets were at rest there is nothing to learn.
    if (is_drag)
      prediction.learn(target_step, model.workers);
    else if (!is_going_on || turns.rows() > 0)
      prediction.forget();
  }
  result.energy_before = space.energy_to_input(report.energy_before);
  result.energy_after = space.energy_to_input(report.energy_after);
  result.iterations = report.iterations;
  result.step = report.step;
  result.stop_reason = report.stop_reason;
  result.parts_at_rest = constraints->parts_at_rest();
  result.loose_vertices = loose_vertices;
  return result;
}

SurfaceArap::SurfaceArap(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties,
                         const Progress& progress) {
  options.validate();
  require_lengths(properties, mesh.n_vertices());
  impl_ = std::make_unique<Impl>(mesh, options, properties, progress);
}

SurfaceArap::~SurfaceArap() = default;
SurfaceArap::SurfaceArap(SurfaceArap&&) noexcept = default;
SurfaceArap& SurfaceArap::operator=(SurfaceArap&&) noexcept = default;

void SurfaceArap::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  constraints.validate(n_vertices());
  if (impl_->constraints != nullptr && constraints == impl_->constraint_set) return;
  auto bound = std::make_unique<BoundConstraints>(impl_->model, constraints, impl_->space.model_vertices(), progress);
  ConstraintSet copy = constraints;
  auto handle_turns = std::make_unique<HandleTurns>(impl_->model, *bound);
  auto steps = std::make_unique<LocalGlobal>(impl_->model, *bound);
  impl_->search = std::make_unique<NonlinearCg>(*steps);
  impl_->steps = std::move(steps);
  impl_->handle_turns = std::move(handle_turns);
  impl_->constraints = std::move(bound);
  impl_->last_targets.resize(0, 3);
  impl_->constraint_set = std::move(copy);
  ++impl_->n_factorizations;
}

SolveResult SurfaceArap::solve(const Positions& targets, const SolveOptions& options,
                               std::span<const Matrix3> rotations, const Progress& progress, std::span<float> out) {
  options.validate();
  if (impl_->constraints == nullptr)
    throw InvalidInput("nothing is constrained; call set_constraints with at least one vertex before solve");
  const auto n_targets = impl_->constraint_set.size();
  require_rows("targets", targets.rows(), n_targets);
  require_finite("targets", targets, [&](int k) { return target_name(impl_->constraint_set, k); });
  if (!rotations.empty()) require_rows("rotations", rotations.size(), n_targets);
  for (size_t k = 0; k < rotations.size(); ++k)
    if (!rotations[k].allFinite()) throw InvalidInput(text("rotations[", k, "] is not finite"));
  const auto n_numbers = 3 * static_cast<size_t>(n_vertices());
  if (!out.empty() && out.size() != n_numbers)
    throw InvalidInput(text("out has ", out.size(), " numbers, must have three per vertex, ", n_numbers));
  return impl_->solve(targets, options, rotations, progress, out);
}

Patch SurfaceArap::patch_around(const std::vector<int>& vertices, double radius) const {
  return impl_->patch_around(vertices, radius);
}

void SurfaceArap::reset() {
  impl_->reset();
  impl_->last_targets.resize(0, 3);
}

void SurfaceArap::set_positions(const Positions& positions) {
  Positions checked = impl_->checked_to_model(positions);
  if (impl_->steps != nullptr) impl_->steps->forget();
  CellPasses& passes = impl_->model.passes(Precision::kSingle);
  static_cast<void>(fit_anew(passes, checked));
  passes.read_rotations(impl_->pose.rotations);
  impl_->pose.positions = std::move(checked);
  impl_->last_targets.resize(0, 3);
}

Positions SurfaceArap::positions() const { return impl_->space.to_input(impl_->pose.positions, impl_->model.workers); }

double SurfaceArap::energy(const Positions& positions) const {
  Positions gradient;
  return impl_->space.energy_to_input(impl_->evaluate(impl_->checked_to_model(positions), gradient));
}

Positions SurfaceArap::energy_gradient(const Positions& positions) const {
  Positions gradient;
  impl_->evaluate(impl_->checked_to_model(positions), gradient);
  return impl_->space.gradient_to_input(gradient);
}

int SurfaceArap::n_vertices() const { return impl_->space.n_input_vertices(); }
int SurfaceArap::n_parts() const { return impl_->model.n_parts; }
const std::vector<int>& SurfaceArap::part_of_vertex() const { return impl_->input_part_of_vertex; }
const std::vector<int>& SurfaceArap::loose_vertices() const { return impl_->loose_vertices; }
const std::vector<int>& SurfaceArap::coincident_vertices() const { return impl_->coincident_vertices; }
int SurfaceArap::n_factorizations() const { return impl_->n_factorizations; }
int SurfaceArap::threads() const { return impl_->model.workers.threads(); }

}  // namespace arap
