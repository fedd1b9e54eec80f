// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/any_model.h"

#include <algorithm>
#include <utility>

#include "arap/cage.h"
#include "arap/cage_arap.h"
#include "arap/embedded_deformation.h"
#include "arap/lattice_arap.h"
#include "arap/poisson_editing.h"
#include "arap/surface_arap.h"
#include "arap/tet_arap.h"
#include "support/tet_arap.h"

namespace arap_test {

namespace {

template <class Native>
class Bound final : public AnyModel {
 public:
  explicit Bound(Native native) : native_(std::move(native)) {}

  void set_constraints(const arap::ConstraintSet& constraints) override { native_.set_constraints(constraints); }
  arap::SolveResult solve(const Positions& targets, const arap::SolveOptions& options) override {
    return native_.solve(targets, options);
  }
  void set_positions(const Positions& positions) override { native_.set_positions(positions); }
  [[nodiscard]] Positions positions() const override { return native_.positions(); }

 private:
  Native native_;
};

template <class Options>
Options with_threads(int threads) {
  Options options;
  options.threads = threads;
  return options;
}

template <class Native, class Options, class Mesh>
KindOfModel kind_of(const char* name, const Mesh& mesh, const Options& given, bool has_inside = false) {
  return {name, mesh.positions(), has_inside, [mesh, given](int threads) -> std::unique_ptr<AnyModel> {
            Options options = given;
            options.threads = threads;
            return std::make_unique<Bound<Native>>(Native(mesh, options));
          }};
}

}  // namespace

std::vector<KindOfModel> kinds_of_models() {
  const arap::PolygonMesh bar = box({6, 2, 2}, {3, 1, 1}, Faces::kQuads).mesh();
  const MeshData sheet = transformed(grid(2, Faces::kQuads), [](const Vector3& p) -> Vector3 {
    return {3 * p[0], p[1], 2 + .2 * p[0] * p[1]};
  });
  const arap::PolygonMesh with_sheet = join(box({6, 2, 2}, {3, 1, 1}, Faces::kQuads), sheet).mesh();
  arap::LatticeOptions cubes;
  cubes.cube_size = .3;
  arap::Options spokes;
  spokes.energy = arap::Energy::kSpokes;
  arap::Options nodes;
  nodes.rigidity_radius = .15;
  arap::EmbeddedOptions graph;
  graph.node_distance = .3;
  arap::PoissonOptions geodesic;
  geodesic.propagation = arap::Propagation::kGeodesic;
  std::vector<KindOfModel> kinds = {
      kind_of<arap::SurfaceArap>("SurfaceArapOfNodes", bar, nodes),
      kind_of<arap::SurfaceArap>("SurfaceArapOfSpokes", bar, spokes),
      kind_of<arap::LatticeArap>("LatticeArap", bar, cubes, true),
      kind_of<arap::LatticeArap>("LatticeArapWithASheet", with_sheet, cubes, true),
      kind_of<arap::TetArap>("TetArap", tet_blocks(5, 2, 2), arap::TetOptions()),
      kind_of<arap::EmbeddedDeformation>("EmbeddedDeformation", bar, graph),
      kind_of<arap::PoissonEditing>("PoissonEditing", bar, arap::PoissonOptions()),
      kind_of<arap::PoissonEditing>("PoissonEditingGeodesic", bar, geodesic),
  };
  const arap::PolygonMesh short_bar = box({4, 2, 2}, {3, 1, 1}, Faces::kQuads).mesh();
  kinds.push_back({"CageArap", short_bar.positions(), false,
                   [short_bar, cage = arap::make_cage(short_bar, 2)](int threads) -> std::unique_ptr<AnyModel> {
                     return std::make_unique<Bound<arap::CageArap>>(
                         arap::CageArap(short_bar, cage, with_threads<arap::CageArapOptions>(threads)));
                   }});
  return kinds;
}

Task pull_on(const KindOfModel& kind, const RigidMotion& motion, double strength) {
  Task task;
  const auto place = [&](int v) { return Vector3(kind.rest.row(v).transpose()); };
  for (const int v : extreme_vertices(kind.rest, 0, .1, 4)) task.add(v, place(v));
  const std::vector<int> far_end = extreme_vertices(kind.rest, 0, -.1, 4);
  for (const int v : far_end) task.add(v, motion.apply(place(v)), strength);
  const std::vector<int> top = extreme_vertices(kind.rest, 2, -.1, 3);
  std::vector<int> patch;
  for (const int v : top)
    if (std::ranges::find(task.constraints.vertices, v) == task.constraints.vertices.end()) patch.push_back(v);
  const std::vector<double> weights(patch.size(), 1.0);
  task.add_patch(patch, weights, average(kind.rest, patch, weights) + Vector3(0, .02, .05));
  if (kind.has_inside) {
    const arap::Segment bone{{-.6, 0, 0}, {.6, .05, 0}};
    task.constraints.segments.push_back(bone);
    const Eigen::Index n = task.targets.rows();
    task.targets.conservativeResize(n + arap::Segment::kTargets, 3);
    task.targets.bottomRows(arap::Segment::kTargets) = motion.apply(bone.rest_targets());
  }
  return task;
}

}  // namespace arap_test
