// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap_deformation.h"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arap/wrap_deformation.h"
#include "arrays.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"
#include "progress_call.h"

namespace arap_native {

namespace {

using Native = arap::WrapDeformation;
using Surface = arap::WrapSurface;
using Object = const py::object&;

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

  /// Needs no GIL.
  template <class AnySurface>
  [[nodiscard]] std::shared_ptr<const Native> bind(const AnySurface& surface, const arap::Progress& progress) const {
    return std::make_shared<const Native>(surface, points, options, pieces, progress);
  }
};

/// For Python. Nothing changes after the bind, so several threads may use it at once.
class BoundWrap {
 public:
  static std::unique_ptr<BoundWrap> of(std::shared_ptr<const Native> native) {
    // Not make_unique: it would use the class's own new, which refuses.
    return std::unique_ptr<BoundWrap>(::new BoundWrap(std::move(native)));  // NOLINT(modernize-make-unique)
  }

  [[nodiscard]] const Native& native() const { return *native_; }

  [[nodiscard]] py::object deform(Object surface_positions, Object out) const {
    const std::span<float> numbers = out_from(out, native_->n_points(), "one row per point");
    const auto singles = singles_of(surface_positions, native_->n_vertices());
    if (singles && !out.is_none()) {
      const WithoutGil no_gil;
      native_->deform(*singles, numbers);
      return out;
    }
    const arap::Positions moved = positions_from(surface_positions, "surface_positions", native_->n_vertices(),
                                                 "one row per vertex of the surface");
    if (out.is_none()) return to_array(posed(moved));
    {
      const WithoutGil no_gil;
      native_->deform(moved, numbers);
    }
    return out;
  }

  [[nodiscard]] std::string repr() const {
    const int threads = native_->threads();
    return py::str("<WrapDeformation: {} points, {} vertices of the surface, {} {}>")
        .format(native_->n_points(), native_->n_vertices(), threads, threads == 1 ? "thread" : "threads");
  }

  /// As that of BoundModel.
  static void* operator new(size_t) {
    throw py::type_error("this WrapDeformation has no surface, because only __new__ was called: call its class");
  }
  static void operator delete(void* bound) { ::operator delete(bound); }

 private:
  explicit BoundWrap(std::shared_ptr<const Native> native) : native_(std::move(native)) {}

  [[nodiscard]] arap::Positions posed(const arap::Positions& moved) const {
    const WithoutGil no_gil;
    return native_->deform(moved);
  }

  std::shared_ptr<const Native> native_;
};

/// For Python, as BoundWrap.
class PreparedSurface {
 public:
  static std::unique_ptr<PreparedSurface> of(std::shared_ptr<const Surface> native) {
    return std::unique_ptr<PreparedSurface>(::new PreparedSurface(std::move(native)));  // NOLINT(modernize-make-unique)
  }

  /// A bind holds it, whatever becomes of this object.
  [[nodiscard]] const std::shared_ptr<const Surface>& native() const { return native_; }

  [[nodiscard]] std::string repr() const { return py::str("<WrapSurface: {} vertices>").format(native_->n_vertices()); }

  /// As that of BoundModel.
  static void* operator new(size_t) {
    throw py::type_error("this WrapSurface has no vertices, because only __new__ was called: call its class");
  }
  static void operator delete(void* prepared) { ::operator delete(prepared); }

 private:
  explicit PreparedSurface(std::shared_ptr<const Surface> native) : native_(std::move(native)) {}

  std::shared_ptr<const Surface> native_;
};

void bind_wrap_surface(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  const py::object none = py::none();
  using Options = arap::WrapOptions;
  py::class_<PreparedSurface>(m, "WrapSurface", docstrings::WrapSurface)
      .def(py::init([](Object rest_positions, Object faces, Object face_sizes, int threads, py::object progress) {
             MeshArrays mesh = mesh_from(rest_positions, faces, face_sizes);
             ProgressCall call(std::move(progress));
             const WithoutGil no_gil;
             return PreparedSurface::of(
                 std::make_shared<const Surface>(mesh_of(std::move(mesh)), threads, call.function()));
           }),
           docstrings::WrapSurface_init, py::arg("rest_positions"), py::arg("faces"), py::arg("face_sizes") = none,
           py::kw_only(), py::arg("threads") = 0, py::arg("progress") = none)
      .def_static(
          "begin_prepare",
          [jobs](Object rest_positions, Object faces, Object face_sizes, int threads) {
            return begin_job(
                *jobs,
                [mesh = mesh_from(rest_positions, faces, face_sizes), threads](const arap::Progress& progress) mutable {
                  return std::make_shared<const Surface>(mesh_of(std::move(mesh)), threads, progress);
                },
                [](std::shared_ptr<const Surface> native) { return py::cast(PreparedSurface::of(std::move(native))); });
          },
          docstrings::WrapSurface_begin_prepare, py::arg("rest_positions"), py::arg("faces"),
          py::arg("face_sizes") = none, py::kw_only(), py::arg("threads") = 0)
      .def(
          "bind",
          [](const PreparedSurface& surface, Object points, const Options* options, Object piece_of_point,
             py::object progress) {
            const PointsInput input(points, options, piece_of_point);
            const Surface& native = *surface.native();
            ProgressCall call(std::move(progress));
            const WithoutGil no_gil;
            return BoundWrap::of(input.bind(native, call.function()));
          },
          docstrings::WrapSurface_bind, py::arg("points"), py::arg("options") = none, py::kw_only(),
          py::arg("piece_of_point") = none, py::arg("progress") = none)
      .def(
          "begin_bind",
          [jobs](const PreparedSurface& surface, Object points, const Options* options, Object piece_of_point) {
            return begin_job(
                *jobs,
                [native = surface.native(), input = PointsInput(points, options, piece_of_point)](
                    const arap::Progress& progress) { return input.bind(*native, progress); },
                [](std::shared_ptr<const Native> native) { return py::cast(BoundWrap::of(std::move(native))); });
          },
          docstrings::WrapSurface_begin_bind, py::arg("points"), py::arg("options") = none, py::kw_only(),
          py::arg("piece_of_point") = none)
      .def_property_readonly(
          "n_vertices", [](const PreparedSurface& surface) { return surface.native()->n_vertices(); },
          docstrings::WrapSurface_n_vertices)
      .def("__repr__", &PreparedSurface::repr);
}

}  // namespace

void bind_wrap_deformation(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  bind_wrap_surface(m, jobs);
  const py::object none = py::none();
  using Options = arap::WrapOptions;
  py::class_<BoundWrap>(m, "WrapDeformation", docstrings::WrapDeformation)
      .def(py::init([](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options,
                       Object piece_of_point, py::object progress) {
             const PointsInput input(points, options, piece_of_point);
             MeshArrays surface = mesh_from(rest_positions, faces, face_sizes);
             ProgressCall call(std::move(progress));
             const WithoutGil no_gil;
             return BoundWrap::of(input.bind(mesh_of(std::move(surface)), call.function()));
           }),
           docstrings::WrapDeformation_init, py::arg("points"), py::arg("rest_positions"), py::arg("faces"),
           py::arg("face_sizes") = none, py::arg("options") = none, py::kw_only(), py::arg("piece_of_point") = none,
           py::arg("progress") = none)
      .def_static(
          "begin_bind",
          [jobs](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options,
                 Object piece_of_point) {
            return begin_job(
                *jobs,
                [input = PointsInput(points, options, piece_of_point),
                 surface = mesh_from(rest_positions, faces, face_sizes)](const arap::Progress& progress) mutable {
                  return input.bind(mesh_of(std::move(surface)), progress);
                },
                [](std::shared_ptr<const Native> native) { return py::cast(BoundWrap::of(std::move(native))); });
          },
          docstrings::WrapDeformation_begin_bind, py::arg("points"), py::arg("rest_positions"), py::arg("faces"),
          py::arg("face_sizes") = none, py::arg("options") = none, py::kw_only(), py::arg("piece_of_point") = none)
      .def("deform", &BoundWrap::deform, docstrings::WrapDeformation_deform, py::arg("surface_positions"),
           py::kw_only(), py::arg("out") = none)
      .def_property_readonly(
          "n_points", [](const BoundWrap& wrap) { return wrap.native().n_points(); },
          docstrings::WrapDeformation_n_points)
      .def_property_readonly(
          "n_vertices", [](const BoundWrap& wrap) { return wrap.native().n_vertices(); },
          docstrings::WrapDeformation_n_vertices)
      .def_property_readonly(
          "n_pieces", [](const BoundWrap& wrap) { return wrap.native().n_pieces(); },
          docstrings::WrapDeformation_n_pieces)
      .def_property_readonly(
          "threads", [](const BoundWrap& wrap) { return wrap.native().threads(); }, docstrings::WrapDeformation_threads)
      .def("__repr__", &BoundWrap::repr);
}

}  // namespace arap_native
