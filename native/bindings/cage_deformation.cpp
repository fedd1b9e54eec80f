// SPDX-License-Identifier: GPL-3.0-or-later
#include "cage_deformation.h"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arap/cage.h"
#include "arrays.h"
#include "data.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"
#include "progress_call.h"
#include "signature.h"

namespace arap_native {

namespace {

using Native = arap::CageDeformation;
using Object = const py::object&;

/// What weights were computed from, and the weights.
struct CageBind {
  arap::Positions points;
  arap::PolygonMesh cage;
  arap::CageOptions options;
  Native native;
};

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
  [[nodiscard]] std::shared_ptr<const CageBind> bind(const arap::Progress& progress) {
    arap::PolygonMesh mesh = mesh_of(std::move(cage));
    Native native(mesh, points, options, progress);
    return std::make_shared<const CageBind>(CageBind{std::move(points), std::move(mesh), options, std::move(native)});
  }
};

/// For Python. Nothing changes after the bind, so several threads may use it at once.
class BoundCage {
 public:
  explicit BoundCage(std::shared_ptr<const CageBind> made) : bind_(std::move(made)) {}

  [[nodiscard]] const Native& native() const { return bind_->native; }

  /// What it was made of.
  [[nodiscard]] py::dict arguments() const {
    py::dict arguments = arguments_of(bind_->cage);
    arguments["points"] = to_array(bind_->points);
    arguments["options"] = bind_->options;
    return arguments;
  }

  [[nodiscard]] py::object deform(Object cage_positions, Object out) const {
    const arap::Positions moved =
        positions_from(cage_positions, "cage_positions", native().n_vertices(), "one row per vertex of the cage");
    const std::span<float> numbers = out_from(out, native().n_points(), "one row per point");
    if (out.is_none()) return to_array(posed(moved));
    {
      const WithoutGil no_gil;
      native().deform(moved, numbers);
    }
    return out;
  }

  [[nodiscard]] py::array fit(Object positions, double smoothness, Object progress) const {
    const arap::Positions points = positions_from(positions, "positions", native().n_points(), "one row per point");
    ProgressCall call(progress);
    arap::Positions result;
    {
      const WithoutGil no_gil;
      result = native().fit(points, smoothness, call.function());
    }
    return to_array(std::move(result));
  }

  [[nodiscard]] py::tuple weights(int point) const {
    const arap::CageWeights weights = native().weights(point);
    const auto array = [](const Eigen::VectorXd& values) {
      return to_array(std::vector<double>(values.begin(), values.end()));
    };
    return py::make_tuple(array(weights.vertices), array(weights.triangles));
  }

  [[nodiscard]] std::string repr() const {
    const int threads = native().threads();
    return py::str("<CageDeformation: {} points, {} vertices of the cage, {} {}>")
        .format(native().n_points(), native().n_vertices(), threads, threads == 1 ? "thread" : "threads");
  }

 private:
  [[nodiscard]] arap::Positions posed(const arap::Positions& moved) const {
    const WithoutGil no_gil;
    return native().deform(moved);
  }

  std::shared_ptr<const CageBind> bind_;
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
  using Options = arap::CageOptions;
  def(m, docstrings::make_cage, [](Object rest_positions, Object faces, Object face_sizes, int cells, Object progress) {
    MeshArrays mesh = mesh_from(rest_positions, faces, face_sizes);
    ProgressCall call(progress);
    return arrays_of(made_cage(std::move(mesh), cells, call.function()));
  });
  def(m, docstrings::begin_make_cage, [jobs](Object rest_positions, Object faces, Object face_sizes, int cells) {
    return begin_job(
        *jobs,
        [mesh = mesh_from(rest_positions, faces, face_sizes), cells](const arap::Progress& progress) mutable {
          return arap::make_cage(mesh_of(std::move(mesh)), cells, progress);
        },
        [](const arap::PolygonMesh& cage) -> py::object { return arrays_of(cage); });
  });
  py::class_<BoundCage> type(m, "CageDeformation", docstrings::CageDeformation);
  def_init(type, docstrings::CageDeformation_init,
           [](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options,
              Object progress) {
             CageInput input(points, rest_positions, faces, face_sizes, options);
             ProgressCall call(progress);
             const WithoutGil no_gil;
             return std::make_unique<BoundCage>(input.bind(call.function()));
           });
  def_static(type, docstrings::CageDeformation_begin_bind,
             [jobs](Object points, Object rest_positions, Object faces, Object face_sizes, const Options* options) {
               return begin_job(
                   *jobs,
                   [input = CageInput(points, rest_positions, faces, face_sizes, options)](
                       const arap::Progress& progress) mutable { return input.bind(progress); },
                   [](std::shared_ptr<const CageBind> made) {
                     return py::cast(std::make_unique<BoundCage>(std::move(made)));
                   });
             });
  def(type, docstrings::CageDeformation_deform,
      [](const BoundCage& cage, Object cage_positions, Object out) { return cage.deform(cage_positions, out); });
  def(type, docstrings::CageDeformation_fit,
      [](const BoundCage& cage, Object positions, double smoothness, Object progress) {
        return cage.fit(positions, smoothness, progress);
      });
  def(type, docstrings::CageDeformation_weights, [](const BoundCage& cage, int point) { return cage.weights(point); });
  def(type, "__repr__(self)", [](const BoundCage& cage) { return cage.repr(); });
  def(type, "__reduce__(self)",
      [](Object self) { return rebuilt_by(self, converted<const BoundCage&>(self, "self").arguments()); });
  def_property(
      type, "n_points", [](const BoundCage& cage) { return cage.native().n_points(); },
      docstrings::CageDeformation_n_points);
  def_property(
      type, "n_vertices", [](const BoundCage& cage) { return cage.native().n_vertices(); },
      docstrings::CageDeformation_n_vertices);
  def_property(
      type, "n_triangles", [](const BoundCage& cage) { return cage.native().n_triangles(); },
      docstrings::CageDeformation_n_triangles);
  def_property(
      type, "threads", [](const BoundCage& cage) { return cage.native().threads(); },
      docstrings::CageDeformation_threads);
}

}  // namespace arap_native
