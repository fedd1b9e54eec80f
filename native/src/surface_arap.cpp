// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/surface_arap.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "bound_constraints.h"
#include "cell_energy.h"
#include "initial_guess.h"
#include "local_global.h"
#include "parallel.h"
#include "rigid_regions.h"
#include "surface_energies.h"
#include "text.h"

namespace arap {

namespace {

/// Vertices closer than this part of the diagonal are at the same place.
constexpr double kSamePlace = 1e-9;

/// Maps the input's space to one where the mesh has its box's centre at 0 and its diagonal 1.
struct Normalization {
  Eigen::RowVector3d center = Eigen::RowVector3d::Zero();
  double size = 1;

  explicit Normalization(const Positions& positions)
      : center(0.5 * (positions.colwise().maxCoeff() + positions.colwise().minCoeff())) {
    const double diagonal = (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).norm();
    if (diagonal > 0) size = diagonal;
  }

  [[nodiscard]] Positions to_model(const Positions& p) const { return (p.rowwise() - center) / size; }
  [[nodiscard]] Positions to_input(const Positions& p) const { return (p * size).rowwise() + center; }
  [[nodiscard]] double energy_to_input(double energy) const { return energy * size * size; }
};

/// Joins the vertices at one place: model vertex of each input vertex, and the mesh of the model vertices.
struct SeamJoin {
  std::vector<int> model_vertex;
  std::vector<int> first_input_vertex;  ///< of each model vertex

  explicit SeamJoin(const std::vector<int>& same_as) : model_vertex(same_as.size()) {
    for (int v = 0; v < std::ssize(same_as); ++v) {
      const int first = same_as[v];
      if (first == v) {
        model_vertex[v] = static_cast<int>(first_input_vertex.size());
        first_input_vertex.push_back(v);
      } else {
        model_vertex[v] = model_vertex[first];
      }
    }
  }

  template <class Value>
  [[nodiscard]] std::vector<Value> to_model(const std::vector<Value>& of_input) const {
    std::vector<Value> result;
    if (of_input.empty()) return result;
    result.reserve(first_input_vertex.size());
    for (const int v : first_input_vertex) result.push_back(of_input[v]);
    return result;
  }

  /// A vertex belongs to the region of any of its copies; of several, to the lowest.
  [[nodiscard]] std::vector<int> regions_to_model(const std::vector<int>& of_input) const {
    std::vector<int> result(of_input.empty() ? 0 : first_input_vertex.size(), -1);
    for (size_t v = 0; v < of_input.size(); ++v) {
      int& region = result[model_vertex[v]];
      if (of_input[v] >= 0 && (region < 0 || of_input[v] < region)) region = of_input[v];
    }
    return result;
  }

  [[nodiscard]] Positions to_model(const Positions& of_input) const {
    Positions result(first_input_vertex.size(), 3);
    for (size_t v = 0; v < first_input_vertex.size(); ++v) result.row(v) = of_input.row(first_input_vertex[v]);
    return result;
  }

  [[nodiscard]] Positions to_input(const Positions& of_model) const {
    Positions result(model_vertex.size(), 3);
    for (size_t v = 0; v < model_vertex.size(); ++v) result.row(v) = of_model.row(model_vertex[v]);
    return result;
  }

  [[nodiscard]] PolygonMesh to_model(const PolygonMesh& mesh, Positions positions) const {
    std::vector<int> corners;
    std::vector<int> sizes;
    for (int f = 0; f < mesh.n_faces(); ++f) {
      for (const int v : mesh.face(f)) corners.push_back(model_vertex[v]);
      sizes.push_back(static_cast<int>(mesh.face(f).size()));
    }
    return {std::move(positions), std::move(corners), std::move(sizes)};
  }
};

std::vector<int> no_join(int n) {
  std::vector<int> same_as(n);
  for (int v = 0; v < n; ++v) same_as[v] = v;
  return same_as;
}

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

}  // namespace

struct SurfaceArap::Impl {
  Impl(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties, const Progress& progress)
      : normalization(mesh.positions()),
        loose_vertices(mesh.loose_vertices()),
        input_part_of_vertex(mesh.part_of_vertex()),
        join(no_join(0)) {
    const Positions normalized = normalization.to_model(mesh.positions());
    const std::vector<int> same_as = coincident_with(normalized, kSamePlace);
    report_coincident(same_as);
    join = SeamJoin(options.join_seams ? same_as : no_join(mesh.n_vertices()));
    const PolygonMesh model_mesh = join.to_model(mesh, join.to_model(normalized));
    model.rest = model_mesh.positions();
    model.part_of_vertex = model_mesh.part_of_vertex();
    model.n_parts = model_mesh.n_parts();
    model.threads = choose_threads(options.threads, model_mesh.n_vertices());
    model.energy =
        assemble_surface_energy(model_mesh, options, join.to_model(properties.stiffness), model.threads, progress);
    model.passes = std::make_unique<CellPasses>(model.energy, model.threads);
    model.regions = RigidRegions(join.regions_to_model(properties.rigid_regions), model.energy, model.rest);
    model.system_matrix = model.regions.reduce(model.energy.K);
    model.linear_solver = options.linear_solver;
    model.solver = make_linear_solver(model.system_matrix, model.linear_solver, model.threads);
    for (size_t v = 0; v < input_part_of_vertex.size(); ++v)
      input_part_of_vertex[v] = model.part_of_vertex[join.model_vertex[v]];
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
    pose.positions = model.rest;
    pose.rotations = identity_rotations(model.energy.n_cells());
    pose.placements = model.regions.fit_placements(pose.positions);
  }

  SolveResult solve(const Positions& targets, const SolveOptions& options, std::span<const Matrix3> rotations,
                    const Progress& progress);
  void apply_guess(LocalGlobal& iteration, const Positions& targets, const SolveOptions& options,
                   std::span<const Matrix3> rotations);
  /// min over R of E at `positions`, on the model; sets the gradient.
  [[nodiscard]] Rotations fitted_rotations(const Positions& positions) const {
    Rotations rotations = identity_rotations(model.energy.n_cells());
    model.passes->set_positions(positions);
    model.passes->fit_rotations(rotations);
    return rotations;
  }
  /// min over R of E at `positions`, on the model; sets the gradient.
  double evaluate(const Positions& positions, Positions& gradient) const {
    const Rotations rotations = fitted_rotations(positions);
    const double energy = model.energy.rest_energy + model.passes->find_residual(rotations, gradient);
    gradient = -gradient;
    return std::max(0.0, energy);
  }
  [[nodiscard]] Positions checked_to_model(const Positions& positions) const {
    require_rows("positions", positions.rows(), join.model_vertex.size());
    require_finite("positions", positions, [](int v) { return text("vertex ", v); });
    return join.to_model(normalization.to_model(positions));
  }

  Normalization normalization;
  std::vector<int> loose_vertices;
  std::vector<int> coincident_vertices;
  std::vector<int> input_part_of_vertex;
  SeamJoin join;
  BoundModel model;
  ConstraintSet constraint_set;
  std::unique_ptr<BoundConstraints> constraints;
  Pose pose;
  Pose before;  ///< what a cancelled solve goes back to; kept, so that its memory is there
  int n_factorizations = 0;
};

void SurfaceArap::Impl::apply_guess(LocalGlobal& iteration, const Positions& targets, const SolveOptions& options,
                                    std::span<const Matrix3> rotations) {
  if (options.initial_guess != InitialGuess::kPrevious) reset();
  // The centers of rigid regions depend on the constraints.
  pose.placements = constraints->regions().fit_placements(pose.positions);
  const bool has_torn = iteration.impose_constraints(pose);
  // With the rotations of the former pose: fitted to a torn one, they would turn what a single handle only moves.
  if (options.initial_guess == InitialGuess::kPrevious && has_torn) iteration.global_step(pose);
  if (options.initial_guess == InitialGuess::kNaiveLaplacian) {
    if (!constraints->has_laplacian_system()) ++n_factorizations;
    guess_naive_laplacian(model, *constraints, constraints->vertex_targets(targets),
                          constraints->patch_targets(targets), pose);
  }
  if (options.initial_guess == InitialGuess::kHandleRotations) {
    const std::vector<Matrix3> given(rotations.begin(), rotations.end());
    spread_handle_rotations(model, *constraints,
                            given.empty() ? estimate_rotations(model, *constraints, targets) : given, pose);
    iteration.global_step(pose);
  }
  iteration.project_on_patches(pose);
}

SolveResult SurfaceArap::Impl::solve(const Positions& targets, const SolveOptions& options,
                                     std::span<const Matrix3> rotations, const Progress& progress) {
  const Positions model_targets = normalization.to_model(targets);
  LocalGlobal iteration(model, *constraints, model_targets);
  before = pose;
  IterationReport report;
  try {
    apply_guess(iteration, model_targets, options, rotations);
    report = iteration.run(pose, options, progress);
    if (!pose.positions.allFinite())
      throw SolverError("the positions are no longer finite; the last good pose is kept");
  } catch (...) {
    std::swap(pose, before);
    throw;
  }
  if (report.stop_reason == StopReason::kCancelled) std::swap(pose, before);

  SolveResult result;
  result.positions = normalization.to_input(join.to_input(pose.positions));
  result.energy_before = normalization.energy_to_input(report.energy_before);
  result.energy_after = normalization.energy_to_input(report.energy_after);
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
  auto bound = std::make_unique<BoundConstraints>(impl_->model, constraints, impl_->join.model_vertex, progress);
  ConstraintSet copy = constraints;
  impl_->constraints = std::move(bound);
  impl_->constraint_set = std::move(copy);
  ++impl_->n_factorizations;
}

SolveResult SurfaceArap::solve(const Positions& targets, const SolveOptions& options,
                               std::span<const Matrix3> rotations, const Progress& progress) {
  options.validate();
  if (impl_->constraints == nullptr)
    throw InvalidInput("nothing is constrained; call set_constraints with at least one vertex before solve");
  const auto n_targets = impl_->constraint_set.size();
  require_rows("targets", targets.rows(), n_targets);
  require_finite("targets", targets, [&](int k) { return target_name(impl_->constraint_set, k); });
  if (!rotations.empty()) require_rows("rotations", rotations.size(), n_targets);
  for (size_t k = 0; k < rotations.size(); ++k)
    if (!rotations[k].allFinite()) throw InvalidInput(text("rotations[", k, "] is not finite"));
  return impl_->solve(targets, options, rotations, progress);
}

void SurfaceArap::reset() { impl_->reset(); }

void SurfaceArap::set_positions(const Positions& positions) {
  Positions checked = impl_->checked_to_model(positions);
  impl_->pose.rotations = impl_->fitted_rotations(checked);
  impl_->pose.positions = std::move(checked);
}

Positions SurfaceArap::positions() const {
  return impl_->normalization.to_input(impl_->join.to_input(impl_->pose.positions));
}

double SurfaceArap::energy(const Positions& positions) const {
  Positions gradient;
  return impl_->normalization.energy_to_input(impl_->evaluate(impl_->checked_to_model(positions), gradient));
}

Positions SurfaceArap::energy_gradient(const Positions& positions) const {
  Positions gradient;
  impl_->evaluate(impl_->checked_to_model(positions), gradient);
  return impl_->join.to_input(gradient) * impl_->normalization.size;
}

int SurfaceArap::n_vertices() const { return static_cast<int>(impl_->join.model_vertex.size()); }
int SurfaceArap::n_parts() const { return impl_->model.n_parts; }
const std::vector<int>& SurfaceArap::part_of_vertex() const { return impl_->input_part_of_vertex; }
const std::vector<int>& SurfaceArap::loose_vertices() const { return impl_->loose_vertices; }
const std::vector<int>& SurfaceArap::coincident_vertices() const { return impl_->coincident_vertices; }
int SurfaceArap::n_factorizations() const { return impl_->n_factorizations; }
int SurfaceArap::threads() const { return impl_->model.threads; }

}  // namespace arap
