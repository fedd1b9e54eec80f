// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap_deformation.h"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arap/wrap_deformation.h"
#include "arrays.h"
#include "data.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"
#include "progress_call.h"
#include "signature.h"

namespace arap_native {

namespace {

using Native = arap::WrapDeformation;
using Surface = arap::WrapSurface;
using Object = const py::object&;

/// A surface, and what it was prepared of.
struct Prepared {
  std::shared_ptr<const arap::PolygonMesh> mesh;
  int threads;
  Surface native;

  Prepared(MeshArrays arrays, int requested_threads, const arap::Progress& progress)
      : mesh(std::make_shared<const arap::PolygonMesh>(mesh_of(std::move(arrays)))),
        threads(requested_threads),
        native(*mesh, threads, progress) {}
};

/// Points, the mesh that they were bound to, and how they hang on it.
struct WrapBind {
  std::shared_ptr<const arap::PolygonMesh> mesh;
  arap::Positions points;
  arap::WrapOptions options;
  std::vector<int> pieces;
  Native native;
};

/// What is bound to a surface; copied from arrays.
struct PointsInput {
  arap::Positions points;
  arap::WrapOptions options;
  std::vector<int> pieces;

  PointsInput(Object given_points, const arap::WrapOptions* given, Object piece_of_point)
      : points(positions_from(given_points, "points", "n", "one row per point")) {
    if (given != nullptr) options = *given;
    if (!piece_of_point.is_none())
      pieces = vector_from<int>(piece_of_point, "piece_of_point", points.rows(), "one number per point");
  }

  /// Once: takes the arrays, as what follows. Needs no GIL.
  [[nodiscard]] std::shared_ptr<const WrapBind> bind(const Prepared& surface, const arap::Progress& progress) {
    return made(surface.mesh, Native(surface.native, points, options, pieces, progress));
  }
  [[nodiscard]] std::shared_ptr<const WrapBind> bind(MeshArrays surface, const arap::Progress& progress) {
    const auto mesh = std::make_shared<const arap::PolygonMesh>(mesh_of(std::move(surface)));
    return made(mesh, Native(*mesh, points, options, pieces, progress));
  }

 private:
  [[nodiscard]] std::shared_ptr<const WrapBind> made(std::shared_ptr<const arap::PolygonMesh> mesh, Native native) {
    return std::make_shared<const WrapBind>(
        WrapBind{std::move(mesh), std::move(points), options, std::move(pieces), std::move(native)});
  }
};

/// For Python. Nothing changes after the bind, so several threads may use it at once.
class BoundWrap {
 public:
  explicit BoundWrap(std::shared_ptr<const WrapBind> made) : bind_(std::move(made)) {}

  [[nodiscard]] const Native& native() const { return bind_->native; }

  /// What it was made of.
  [[nodiscard]] py::dict arguments() const {
    py::dict arguments = arguments_of(*bind_->mesh);
    arguments["points"] = to_array(bind_->points);
    arguments["options"] = bind_->options;
    if (!bind_->pieces.empty()) arguments["piece_of_point"] = to_array(bind_->pieces);
    return arguments;
  }

  [[nodiscard]] py::object deform(Object surface_positions, Object out) const {
    const std::span<float> numbers = out_from(out, native().n_points(), "one row per point");
    const auto singles = singles_of(surface_positions, native().n_vertices());
    if (singles && !out.is_none()) {
      const WithoutGil no_gil;
      native().deform(*singles, numbers);
      return out;
    }
    const arap::Positions moved = positions_from(surface_positions, "surface_positions", native().n_vertices(),
                                                 "one row per vertex of the surface");
    if (out.is_none()) return to_array(posed(moved));
    {
      const WithoutGil no_gil;
      native().deform(moved, numbers);
    }
    return out;
  }

  [[nodiscard]] std::string repr() const {
    const int threads = native().threads();
    return py::str("<WrapDeformation: {} points, {} vertices of the surface, {} {}>")
        .format(native().n_points(), native().n_vertices(), threads, threads == 1 ? "thread" : "threads");
  }

 private:
  [[nodiscard]] arap::Positions posed(const arap::Positions& moved) const {
    const WithoutGil no_gil;
    return native().deform(moved);
  }

  std::shared_ptr<const WrapBind> bind_;
};

/// For Python, as BoundWrap.
class PreparedSurface {
 public:
  explicit PreparedSurface(std::shared_ptr<const Prepared> prepared) : prepared_(std::move(prepared)) {}

  /// A bind holds it, whatever becomes of this object.
  [[nodiscard]] const std::shared_ptr<const Prepared>& prepared() const { return prepared_; }
  [[nodiscard]] int n_vertices() const { return prepared_->native.n_vertices(); }

  /// What it was made of.
  [[nodiscard]] py::dict arguments() const {
    py::dict arguments = arguments_of(*prepared_->mesh);
    arguments["threads"] = prepared_->threads;
    return arguments;
  }

  [[nodiscard]] std::string repr() const { return py::str("<WrapSurface: {} vertices>").format(n_vertices()); }

 private:
  std::shared_ptr<const Prepared> prepared_;
};

void bind_wrap_surface(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  using Options = arap::WrapOptions;
  py::class_<PreparedSurface> type(m, "WrapSurface", docstrings::WrapSurface);
  def_init(type, docstrings::WrapSurface_init,
           [](Object rest_positions, Object faces, Object face_sizes, int threads, Object progress) {
             MeshArrays mesh = mesh_from(rest_positions, faces, face_sizes);
             ProgressCall call(progress);
             const WithoutGil no_gil;
             return std::make_unique<PreparedSurface>(
                 std::make_shared<const Prepared>(std::move(mesh), threads, call.function()));
           });
  def_static(
      type, docstrings::WrapSurface_begin_prepare,
      [jobs](Object rest_positions, Object faces, Object face_sizes, int threads) {
        return begin_job(
            *jobs,
            [mesh = mesh_from(rest_positions, faces, face_sizes), threads](const arap::Progress& progress) mutable {
              return std::make_shared<const Prepared>(std::move(mesh), threads, progress);
            },
            [](std::shared_ptr<const Prepared> prepared) {
              return py::cast(std::make_unique<PreparedSurface>(std::move(prepared)));
            });
      });
  def(type, docstrings::WrapSurface_bind,
      [](const PreparedSurface& surface, Object points, const Options* options, Object piece_of_point,
         Object progress) {
        PointsInput input(points, options, piece_of_point);
        const auto& prepared = surface.prepared();
        ProgressCall call(progress);
        const WithoutGil no_gil;
        return std::make_unique<BoundWrap>(input.bind(*prepared, call.function()));
      });
  def(type, docstrings::WrapSurface_begin_bind,
      [jobs](const PreparedSurface& surface, Object points, const Options* options, Object piece_of_point) {
        return begin_job(
            *jobs,
            [prepared = surface.prepared(), input = PointsInput(points, options, piece_of_point)](
                const arap::Progress& progress) mutable { return input.bind(*prepared, progress); },
            [](std::shared_ptr<const WrapBind> made) {
              return py::cast(std::make_unique<BoundWrap>(std::move(made)));
            });
      });
  def(type, "__repr__(self)", [](const PreparedSurface& surface) { return surface.repr(); });
  def(type, "__reduce__(self)",
      [](Object self) { return rebuilt_by(self, converted<const PreparedSurface&>(self, "self").arguments()); });
  def_property(
      type, "n_vertices", [](const PreparedSurface& surface) { return surface.n_vertices(); },
      docstrings::WrapSurface_n_vertices);
}

}  // namespace

void bind_wrap_deformation(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  bind_wrap_surface(m, jobs);
  using Options = arap::WrapOptions;
  py::class_<BoundWrap> type(m, "WrapDeformation", docstrings::WrapDeformation);
  def_init(type, docstrings::WrapDeformation_init,
           [](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options,
              Object piece_of_point, Object progress) {
             PointsInput input(points, options, piece_of_point);
             MeshArrays surface = mesh_from(rest_positions, faces, face_sizes);
             ProgressCall call(progress);
             const WithoutGil no_gil;
             return std::make_unique<BoundWrap>(input.bind(std::move(surface), call.function()));
           });
  def_static(type, docstrings::WrapDeformation_begin_bind,
             [jobs](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options,
                    Object piece_of_point) {
               return begin_job(
                   *jobs,
                   [input = PointsInput(points, options, piece_of_point),
                    surface = mesh_from(rest_positions, faces, face_sizes)](const arap::Progress& progress) mutable {
                     return input.bind(std::move(surface), progress);
                   },
                   [](std::shared_ptr<const WrapBind> made) {
                     return py::cast(std::make_unique<BoundWrap>(std::move(made)));
                   });
             });
  def(type, docstrings::WrapDeformation_deform,
      [](const BoundWrap& wrap, Object surface_positions, Object out) { return wrap.deform(surface_positions, out); });
  def(type, "__repr__(self)", [](const BoundWrap& wrap) { return wrap.repr(); });
  def(type, "__reduce__(self)",
      [](Object self) { return rebuilt_by(self, converted<const BoundWrap&>(self, "self").arguments()); });
  def_property(
      type, "n_points", [](const BoundWrap& wrap) { return wrap.native().n_points(); },
      docstrings::WrapDeformation_n_points);
  def_property(
      type, "n_vertices", [](const BoundWrap& wrap) { return wrap.native().n_vertices(); },
      docstrings::WrapDeformation_n_vertices);
  def_property(
      type, "n_pieces", [](const BoundWrap& wrap) { return wrap.native().n_pieces(); },
      docstrings::WrapDeformation_n_pieces);
  def_property(
      type, "threads", [](const BoundWrap& wrap) { return wrap.native().threads(); },
      docstrings::WrapDeformation_threads);
}

}  // namespace arap_native
