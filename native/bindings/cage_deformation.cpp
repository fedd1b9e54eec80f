// SPDX-License-Identifier: GPL-3.0-or-later
#include "cage_deformation.h"

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arap/cage.h"
#include "arrays.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"
#include "progress_call.h"

namespace arap_native {

namespace {

using Native = arap::CageDeformation;
using Object = const py::object&;

/// What weights are computed from; copied from arrays.
struct CageInput {
  arap::Positions points;
  MeshArrays cage;
  arap::CageOptions options;

  CageInput(Object given_points, Object rest_positions, Object faces, Object face_sizes, const arap::CageOptions* given)
      : points(positions_from(given_points, "points", "n", "one row per point")),
        cage(prefixed_mesh_from("cage: ", rest_positions, faces, face_sizes)) {
    if (given != nullptr) options = *given;
  }

  /// Once: takes the arrays. Needs no GIL.
  [[nodiscard]] std::shared_ptr<const Native> bind(const arap::Progress& progress) {
    return std::make_shared<const Native>(mesh_of(std::move(cage)), points, options, progress);
  }
};

/// For Python. Nothing changes after the bind, so several threads may use it at once.
class BoundCage {
 public:
  static std::unique_ptr<BoundCage> of(std::shared_ptr<const Native> native) {
    // Not make_unique: it would use the class's own new, which refuses.
    return std::unique_ptr<BoundCage>(::new BoundCage(std::move(native)));  // NOLINT(modernize-make-unique)
  }

  [[nodiscard]] const Native& native() const { return *native_; }

  [[nodiscard]] py::object deform(Object cage_positions, Object out) const {
    const arap::Positions moved =
        positions_from(cage_positions, "cage_positions", native_->n_vertices(), "one row per vertex of the cage");
    const std::span<float> numbers = out_from(out, native_->n_points(), "one row per point");
    if (out.is_none()) return to_array(posed(moved));
    {
      const WithoutGil no_gil;
      native_->deform(moved, numbers);
    }
    return out;
  }

  [[nodiscard]] py::array fit(Object positions, double smoothness) const {
    const arap::Positions points = positions_from(positions, "positions", native_->n_points(), "one row per point");
    arap::Positions result;
    {
      const WithoutGil no_gil;
      result = native_->fit(points, smoothness);
    }
    return to_array(std::move(result));
  }

  [[nodiscard]] py::tuple weights(int point) const {
    const arap::CageWeights weights = native_->weights(point);
    const auto array = [](const Eigen::VectorXd& values) {
      return to_array(std::vector<double>(values.begin(), values.end()));
    };
    return py::make_tuple(array(weights.vertices), array(weights.triangles));
  }

  [[nodiscard]] std::string repr() const {
    const int threads = native_->threads();
    return py::str("<CageDeformation: {} points, {} vertices of the cage, {} {}>")
        .format(native_->n_points(), native_->n_vertices(), threads, threads == 1 ? "thread" : "threads");
  }

  /// As that of BoundModel.
  static void* operator new(size_t) {
    throw py::type_error("this CageDeformation has no cage, because only __new__ was called: call its class");
  }
  static void operator delete(void* bound) { ::operator delete(bound); }

 private:
  explicit BoundCage(std::shared_ptr<const Native> native) : native_(std::move(native)) {}

  [[nodiscard]] arap::Positions posed(const arap::Positions& moved) const {
    const WithoutGil no_gil;
    return native_->deform(moved);
  }

  std::shared_ptr<const Native> native_;
};

arap::PolygonMesh made_cage(MeshArrays mesh, int cells, const arap::Progress& progress) {
  const WithoutGil no_gil;
  return arap::make_cage(mesh_of(std::move(mesh)), cells, progress);
}

/// Positions, and (f, 4) faces.
py::tuple arrays_of(const arap::PolygonMesh& cage) {
  std::vector<int> corners;
  for (int f = 0; f < cage.n_faces(); ++f) corners.insert(corners.end(), cage.face(f).begin(), cage.face(f).end());
  return py::make_tuple(to_array(cage.positions()), to_array(std::move(corners)).attr("reshape")(cage.n_faces(), 4));
}

}  // namespace

void bind_cage_deformation(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  m.def(
      "make_cage",
      [](Object rest_positions, Object faces, Object face_sizes, int cells, py::object progress) {
        MeshArrays mesh = mesh_from(rest_positions, faces, face_sizes);
        ProgressCall call(std::move(progress));
        return arrays_of(made_cage(std::move(mesh), cells, call.function()));
      },
      docstrings::make_cage, py::arg("rest_positions"), py::arg("faces"), py::arg("face_sizes") = py::none(),
      py::arg("cells") = 10, py::kw_only(), py::arg("progress") = py::none());
  m.def(
      "begin_make_cage",
      [jobs](Object rest_positions, Object faces, Object face_sizes, int cells) {
        return begin_job(
            *jobs,
            [mesh = mesh_from(rest_positions, faces, face_sizes), cells](const arap::Progress& progress) mutable {
              return arap::make_cage(mesh_of(std::move(mesh)), cells, progress);
            },
            [](const arap::PolygonMesh& cage) -> py::object { return arrays_of(cage); });
      },
      docstrings::begin_make_cage, py::arg("rest_positions"), py::arg("faces"), py::arg("face_sizes") = py::none(),
      py::arg("cells") = 10);
  const py::object none = py::none();
  using Options = arap::CageOptions;
  py::class_<BoundCage>(m, "CageDeformation", docstrings::CageDeformation)
      .def(py::init([](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options,
                       py::object progress) {
             CageInput input(points, rest_positions, faces, face_sizes, options);
             ProgressCall call(std::move(progress));
             const WithoutGil no_gil;
             return BoundCage::of(input.bind(call.function()));
           }),
           docstrings::CageDeformation_init, py::arg("points"), py::arg("rest_positions"), py::arg("faces"),
           py::arg("face_sizes") = none, py::arg("options") = none, py::kw_only(), py::arg("progress") = none)
      .def_static(
          "begin_bind",
          [jobs](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options) {
            return begin_job(
                *jobs,
                [input = CageInput(points, rest_positions, faces, face_sizes, options)](
                    const arap::Progress& progress) mutable { return input.bind(progress); },
                [](std::shared_ptr<const Native> native) { return py::cast(BoundCage::of(std::move(native))); });
          },
          docstrings::CageDeformation_begin_bind, py::arg("points"), py::arg("rest_positions"), py::arg("faces"),
          py::arg("face_sizes") = none, py::arg("options") = none)
      .def("deform", &BoundCage::deform, docstrings::CageDeformation_deform, py::arg("cage_positions"), py::kw_only(),
           py::arg("out") = none)
      .def("fit", &BoundCage::fit, docstrings::CageDeformation_fit, py::arg("positions"), py::arg("smoothness") = 1e-6)
      .def("weights", &BoundCage::weights, docstrings::CageDeformation_weights, py::arg("point"))
      .def_property_readonly(
          "n_points", [](const BoundCage& cage) { return cage.native().n_points(); },
          docstrings::CageDeformation_n_points)
      .def_property_readonly(
          "n_vertices", [](const BoundCage& cage) { return cage.native().n_vertices(); },
          docstrings::CageDeformation_n_vertices)
      .def_property_readonly(
          "n_triangles", [](const BoundCage& cage) { return cage.native().n_triangles(); },
          docstrings::CageDeformation_n_triangles)
      .def_property_readonly(
          "threads", [](const BoundCage& cage) { return cage.native().threads(); }, docstrings::CageDeformation_threads)
      .def("__repr__", &BoundCage::repr);
}

}  // namespace arap_native
