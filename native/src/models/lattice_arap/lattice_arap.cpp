// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/lattice_arap.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <utility>

#include "arap/error.h"
#include "base/available_memory.h"
#include "base/eigen_compat.h"
#include "base/format_message.h"
#include "base/option_bounds.h"
#include "lattice/lattice.h"
#include "lattice/segment_core.h"
#include "lattice/voids.h"
#include "mesh/surface_measures.h"
#include "models/input_checks.h"
#include "models/lattice_arap/exact_vertices.h"
#include "models/lattice_arap/held_segments.h"
#include "models/lattice_arap/held_vertices.h"
#include "models/lattice_arap/lattice_energy.h"
#include "models/lattice_arap/lattice_fit.h"
#include "models/lattice_arap/piece_stiffness.h"
#include "models/lattice_arap/sheets.h"
#include "models/model_space.h"
#include "optimize/engine.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

/// Around hard vertices, in cubes.
constexpr double kReach = 2;

/// Of keep_volume = 1. A stiffer one keeps hardly more and takes far more iterations.
constexpr double kVolumeStiffness = 2;

/// Pieces of a part without an inside that is carried by cubes all the same: as small as it is, nobody sees it bend.
constexpr int kMostHollow = 8;

/// Of the progress of an act, the part of the sheets.
constexpr double kShareOfSheets = 0.3;

/// Beyond this ratio of the stiffest piece to the softest, rounded forces of the one would bend the other.
constexpr double kSinglePrecisionContrast = 1e4;

/// A little more than what the energy of a lattice and its solver take beside the factor. Measured on a solid block and
/// on thousands of specks.
double bytes_to_bind(const Lattice& lattice) {
  constexpr double kPerControlPoint = 900;
  constexpr double kPerPiece = 1500;
  return kPerControlPoint * lattice.n_control_points() + kPerPiece * lattice.n_pieces();
}

double contrast(const std::vector<double>& stiffness) {
  if (stiffness.empty()) return 1;
  const auto [least, most] = std::minmax_element(stiffness.begin(), stiffness.end());
  return *most / *least;
}

/// Row by row; false if one is beyond the range of single precision.
bool write_single(const Positions& positions, const Workers& workers, std::span<float> out) {
  return parallel_all<4096>(workers, static_cast<int>(positions.rows()), [&](int begin, int end) {
    Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>> rows(out.data() + 3 * std::ptrdiff_t{begin},
                                                                              end - begin, 3);
    rows = positions.middleRows(begin, end - begin).cast<float>();
    return rows.allFinite();
  });
}

/// What all constraints of a set mean for a lattice.
class Held {
 public:
  Held(const Lattice& lattice, const std::vector<double>& areas, const ConstraintSet& set)
      : vertices_(lattice, areas, set),
        segments_(lattice, set.segments, static_cast<int>(set.vertices.size()) + set.patches.size()) {}

  [[nodiscard]] LinearRows rows() const {
    LinearRows result = vertices_.rows();
    const auto& [rows, weights] = segments_.rows();
    result.rows.insert(result.rows.end(), rows.begin(), rows.end());
    result.weights.insert(result.weights.end(), weights.begin(), weights.end());
    return result;
  }
  [[nodiscard]] Positions targets(const Positions& of_set) const {
    Positions result(vertices_.rows().size() + segments_.rows().size(), 3);
    result << vertices_.targets(of_set), segments_.targets(of_set);
    return result;
  }
  [[nodiscard]] std::vector<int> sources() const {
    std::vector<int> result = vertices_.sources();
    const std::vector<int> of_segments = segments_.sources();
    result.insert(result.end(), of_segments.begin(), of_segments.end());
    return result;
  }

 private:
  HeldVertices vertices_;
  HeldSegments segments_;
};

PolygonMesh make_model(const PolygonMesh& input, ModelSpace& space, bool join_seams, int threads) {
  if (join_seams) space.join(input.same_places(threads));
  return join_voids(space.make_model(input));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

void LatticeOptions::validate() const {
  if (cube_size != 0) require_between("cube_size", cube_size, 1e-3, 1, ", or 0");
  require_between("keep_volume", keep_volume, 0, 1);
  require_threads(threads);
}

struct LatticeArap::Impl {
  Impl(const PolygonMesh& input, const LatticeOptions& options, const VertexProperties& of_input,
       const Progress& progress)
      : space(input),
        mesh(make_model(input, space, options.join_seams, choose_threads(options.threads, input.n_vertices()))),
        areas(vertex_areas(mesh)),
        properties{space.to_model(of_input.stiffness), space.regions_to_model(of_input.rigid_regions)},
        engine(prepare(options, part_of(progress, 0, 1 - kShareOfSheets))),
        sheets(mesh, *lattice, properties, options.threads, part_of(progress, 1 - kShareOfSheets, 1)),
        shown(input.positions()) {
    for (int v = 0; v < input.n_vertices(); ++v) {
      part_of_vertex.push_back(mesh.part_of_vertex()[space.model_vertices()[v]]);
      if (part_of_vertex.back() < 0) loose_vertices.push_back(v);
    }
  }

  const PreparedModel& prepare(const LatticeOptions& options, const Progress& progress) {
    Meter meter(progress, "binding was cancelled");
    int threads = choose_threads(options.threads, mesh.n_vertices());
    meter.tell();
    const double size = choose_cube_size(mesh, options.cube_size, threads, {&meter, 0});
    meter.tell();
    make_lattice(size, {&meter, 0.6});
    if (options.cube_size == 0) coarsen(size, meter);
    require_memory(bytes_to_bind(*lattice), "the lattice of this mesh");
    meter.tell();
    // A control point has about as many incidences as five vertices of a surface.
    threads = choose_threads(options.threads, 5 * lattice->n_control_points());
    model.workers = Workers(threads);
    const std::vector<double> stiffness = piece_stiffness(*lattice, properties);
    // The cubes of sheets have no volume to keep.
    model.energy.volume_stiffness = lattice->pieces().has_inside() ? kVolumeStiffness * options.keep_volume : 0;
    assemble_lattice_energy(model.energy, *lattice, stiffness, threads, {&meter, 0.2}, [&] {
      model.rest = lattice->rest();
      model.part_of_vertex = lattice->part_of_control_point();
      model.n_parts = mesh.n_parts();
      model.solver = model.make_solver({&meter, 0.2});
      // Control points at the rim of the lattice are far softer than others, so rounded forces move them farther. The
      // surface feels them as little: a converged pose is within 2e-6 of its size of that in double. So the rule for
      // surfaces, which refuses this contrast, is not asked.
      constexpr int kFewControlPoints = 2000;
      model.fits_single =
          lattice->n_control_points() >= kFewControlPoints && contrast(stiffness) <= kSinglePrecisionContrast;
      return model.solver->ordering();
    });
    lattice->renumber(model.take_solver_numbers());
    meter.reach(1);
    return model;
  }

  /// Sheets have cubes only if there is nothing else.
  void make_lattice(double size, const MeterPart& meter) {
    lattice.emplace(mesh, size, meter, kMostHollow);
    if (lattice->n_pieces() == 0) lattice.emplace(mesh, size);
  }

  /// Makes the cubes larger until there are not too many pieces. If much of a mesh crosses itself, they are far more
  /// than the cubes; only the lattice knows how many.
  void coarsen(double size, Meter& meter) {
    constexpr double kManyPieces = 50'000;
    while (lattice->n_pieces() > kManyPieces && size < 1) {
      // Crossed cubes fall with the square of the size.
      size = std::min(1.0, size * std::max(1.1, std::sqrt(lattice->n_pieces() / kManyPieces)));
      make_lattice(size, {&meter, 0});
    }
  }

  /// Writes where the vertices are to `next`.
  void embed(const Positions& control_points, const Positions& targets) {
    if (points.rows() == 0) points = mesh.positions();  // loose ones stay there
    lattice->embed(control_points, model.workers, points);
    sheets.write(points);
    exact->apply(targets, model.workers, points);
    space.to_input(points, model.workers, next);
  }

  /// Writes positions of the input into `out`, or into the result's own where that is empty; false if one of them is
  /// not finite.
  [[nodiscard]] bool hand_over(const Positions& positions, std::span<float> out, SolveResult& result) const {
    if (!out.empty()) return write_single(positions, model.workers, out);
    result.positions = positions;
    return all_finite(positions, model.workers);
  }

  void take(Pose of_engine, Pose of_sheets, Positions of_input) noexcept {
    engine.take(std::move(of_engine));
    sheets.take(std::move(of_sheets));
    shown.swap(of_input);
  }

  /// (n_parts,) whether nothing constrains a part: no row of the engine, and nothing of the sheets' parts.
  [[nodiscard]] std::vector<char> parts_at_rest(const LinearRows& rows, const std::vector<int>& of_sheets) const {
    std::vector<char> result(mesh.n_parts(), 1);
    for (const LinearRow& row : rows.rows)
      for (const int c : row.indices) result[lattice->part_of_control_point()[c]] = 0;
    for (const int part : of_sheets) result[part] = 0;
    return result;
  }

  /// Of each row of the engine's targets, from those of the set's.
  [[nodiscard]] std::vector<Matrix3> of_rows(std::span<const Matrix3> rotations) const {
    std::vector<Matrix3> result;
    if (!rotations.empty())
      for (const int source : held->sources()) result.push_back(rotations[source]);
    return result;
  }

  /// Adds what the engine did to what the sheets did. Energies are those of what has an inside.
  void add(const IterationReport& report, SolveResult& result) const {
    const double unit = space.size() * space.size() * space.size();
    result.energy_before = report.energy_before * unit;
    result.energy_after = report.energy_after * unit;
    result.iterations = std::max(result.iterations, report.iterations);
    result.step = std::max(result.step, report.step);
    if (report.stop_reason != StopReason::kConverged) result.stop_reason = report.stop_reason;
  }

  ModelSpace space;
  PolygonMesh mesh;  ///< in model space
  std::vector<double> areas;
  VertexProperties properties;  ///< of mesh
  std::optional<Lattice> lattice;
  PreparedModel model;
  Engine engine;
  Sheets sheets;
  ConstraintSet constraints;
  std::unique_ptr<Held> held;
  std::unique_ptr<ExactVertices> exact;
  std::unique_ptr<LatticeFit> fit;  ///< made when first needed
  Positions shown;                  ///< the input's positions that were handed over last
  // Their memory lives on between solves: a frame of a large mesh would spend its time on new pages.
  Positions points;                 ///< of mesh
  Positions next;                   ///< in the input's space
  std::vector<int> part_of_vertex;  ///< of each vertex of the input, -1 = loose
  std::vector<int> loose_vertices;
};

LatticeArap::LatticeArap(const PolygonMesh& mesh, const LatticeOptions& options, const VertexProperties& properties,
                         const Progress& progress) {
  options.validate();
  properties.validate(mesh.n_vertices());
  require_surface(mesh);
  impl_ = std::make_unique<Impl>(mesh, options, properties, progress);
  Meter(progress, "binding was cancelled").reach(1);
}

LatticeArap::~LatticeArap() = default;
LatticeArap::LatticeArap(LatticeArap&&) noexcept = default;
LatticeArap& LatticeArap::operator=(LatticeArap&&) noexcept = default;

void LatticeArap::set_constraints(const ConstraintSet& constraints, const Progress& progress) {
  constraints.validate(n_vertices());
  ConstraintSet of_model = impl_->space.to_model(constraints);
  require_movable_patches(of_model.patches, impl_->mesh.part_of_vertex());
  require_strength(of_model, impl_->mesh.part_of_vertex());
  if (impl_->engine.has_constraints() && constraints == impl_->constraints) return;
  auto held = std::make_unique<Held>(*impl_->lattice, impl_->areas, of_model);
  ConstraintSet copy = constraints;
  const double share = impl_->sheets.empty() ? 0 : kShareOfSheets;
  Sheets::Change of_sheets = impl_->sheets.prepare(of_model, part_of(progress, 0, share));
  const LinearRows rows = held->rows();
  auto exact = std::make_unique<ExactVertices>(
      impl_->mesh, of_model, impl_->lattice->piece_of_vertex(), impl_->properties.rigid_regions,
      impl_->parts_at_rest(rows, of_sheets.constrained_parts), kReach * impl_->lattice->cube_size());
  Engine::Change of_engine = impl_->engine.prepare({{}, rows}, part_of(progress, share, 1));
  // Nothing fails from here on.
  impl_->sheets.take(std::move(of_sheets));
  impl_->engine.take(std::move(of_engine));
  impl_->points.resize(0, 3);  // a loose vertex that was held goes back
  impl_->held = std::move(held);
  impl_->exact = std::move(exact);
  impl_->constraints = std::move(copy);
}

SolveResult LatticeArap::solve(const Positions& targets, const SolveOptions& options,
                               std::span<const Matrix3> rotations, const Progress& progress, std::span<float> out) {
  options.validate();
  require_constrained(impl_->engine.has_constraints());
  require_targets(impl_->constraints, targets, rotations);
  require_out(out, n_vertices());
  const Positions of_model = impl_->space.targets_to_model(targets, impl_->constraints);
  const double share = impl_->sheets.empty() ? 0 : kShareOfSheets;
  const auto start = std::chrono::steady_clock::now();
  SolveOptions of_sheets = options;
  of_sheets.time_limit_s *= kShareOfSheets;
  SolveResult result = impl_->sheets.solve(of_model, of_sheets, rotations, part_of(progress, 0, share));
  const bool have_sheets_moved = result.stop_reason != StopReason::kCancelled;
  try {
    result.parts_at_rest = impl_->exact->parts_at_rest();
    result.loose_vertices = impl_->loose_vertices;
    if (have_sheets_moved) {
      SolveOptions left = options;
      left.time_limit_s = std::max(1e-9, left.time_limit_s - seconds_since(start));
      const auto hand_over = [&](const Positions& control_points) {
        impl_->embed(control_points, of_model);
        return impl_->hand_over(impl_->next, out, result);
      };
      impl_->add(impl_->engine.solve(impl_->held->targets(of_model), left, impl_->of_rows(rotations),
                                     part_of(progress, share, 1), hand_over),
                 result);
    }
  } catch (...) {
    if (have_sheets_moved) impl_->sheets.undo();
    if (!out.empty()) static_cast<void>(write_single(impl_->shown, impl_->model.workers, out));
    throw;
  }
  if (result.stop_reason != StopReason::kCancelled) {
    impl_->shown.swap(impl_->next);
    return result;
  }
  if (have_sheets_moved) impl_->sheets.undo();
  // What was spread around the former targets is in no other place.
  static_cast<void>(impl_->hand_over(impl_->shown, out, result));
  return result;
}

void LatticeArap::reset() {
  impl_->take(impl_->engine.at_rest(), impl_->sheets.at_rest(),
              impl_->space.to_input(impl_->mesh.positions(), impl_->model.workers));
}

void LatticeArap::set_positions(const Positions& positions) {
  require_rows("positions", positions.rows(), n_vertices());
  require_finite("positions", positions, [](int v) { return text("vertex ", v); });
  if (impl_->fit == nullptr)
    impl_->fit =
        std::make_unique<LatticeFit>(*impl_->lattice, impl_->areas, impl_->mesh.positions(), impl_->model.energy.K);
  const Workers& workers = impl_->model.workers;
  const Positions of_model = impl_->space.to_model(positions, workers);
  impl_->take(impl_->engine.fitted(impl_->fit->fit(of_model, workers)),
              impl_->sheets.fitted(of_model(impl_->sheets.vertices(), all)), positions);
}

const Positions& LatticeArap::positions() const { return impl_->shown; }

std::vector<int> LatticeArap::segments_outside(const std::vector<Segment>& segments) const {
  std::vector<int> result;
  for (size_t s = 0; s < segments.size(); ++s)
    if (segment_core(*impl_->lattice, impl_->space.to_model(segments[s])).empty())
      result.push_back(static_cast<int>(s));
  return result;
}

int LatticeArap::n_vertices() const { return impl_->space.n_input_vertices(); }
int LatticeArap::n_parts() const { return impl_->mesh.n_parts(); }
int LatticeArap::n_parts_joined(const PolygonMesh& mesh, int threads) {
  if (mesh.n_parts() < 2) return mesh.n_parts();
  ModelSpace space(mesh);
  return make_model(mesh, space, true, threads).n_parts();
}
const std::vector<int>& LatticeArap::part_of_vertex() const { return impl_->part_of_vertex; }
const std::vector<int>& LatticeArap::loose_vertices() const { return impl_->loose_vertices; }
int LatticeArap::n_parts_at_rest() const {
  return impl_->exact ? static_cast<int>(impl_->exact->parts_at_rest().size()) : 0;
}
int LatticeArap::n_factorizations() const {
  return impl_->engine.n_factorizations() + impl_->sheets.n_factorizations();
}
int LatticeArap::n_control_points() const { return impl_->lattice->n_control_points(); }
bool LatticeArap::has_inside() const { return impl_->lattice->pieces().has_inside() || !impl_->sheets.empty(); }
const std::vector<int>& LatticeArap::sheets() const { return impl_->sheets.parts(); }
double LatticeArap::cube_size() const { return impl_->lattice->cube_size() * impl_->space.size(); }
Positions LatticeArap::cube_corners() const {
  return impl_->space.points_to_input(impl_->lattice->corners(impl_->engine.positions()));
}
int LatticeArap::threads() const { return impl_->model.workers.threads(); }

}  // namespace arap
