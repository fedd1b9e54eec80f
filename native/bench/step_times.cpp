// SPDX-License-Identifier: GPL-3.0-or-later
// The only benchmark that uses internals of the library: the public interface has no parts of an iteration.
#include "timings.h"

#include <algorithm>
#include <vector>

#include "models/surface_arap/surface_model.h"
#include "optimize/local_global.h"
#include "process.h"

namespace arap::bench {

namespace {

constexpr int kWarmUp = 3;
constexpr int kSamples = 15;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <class Act>
double timed_ms(const Act& act) {
  const Stopwatch watch;
  act();
  return watch.ms();
}

}  // namespace

StepTimes time_steps(const TaskFile& task, const Options& options) {
  // Of size 1, as SurfaceArap has it.
  const double size = task.mesh().diagonal();
  SurfaceModel surface;
  const std::vector<int> model_vertex = prepare_surface(
      surface, PolygonMesh(task.positions / size, task.corner_vertices, task.face_sizes), options, {}, {}, {});
  const PreparedModel& model = surface.prepared;
  ConstraintSet set;
  for (const int v : task.constrained) set.vertices.push_back(model_vertex[v]);
  set.strengths.assign(set.vertices.size(), 1.0);
  const PreparedConstraints constraints(model, {set, {}}, {});
  LocalGlobal steps(model, constraints);
  steps.set_targets(task.targets / size, Precision::kSingle);

  Pose pose{model.rest, Rotations(static_cast<size_t>(model.energy.n_cells()), Eigen::Quaterniond::Identity()), {}};
  steps.impose_constraints(pose);
  steps.start(pose);
  Positions residual;
  Positions correction;
  std::vector<double> local;
  std::vector<double> global;
  std::vector<double> solve;
  for (int k = -kWarmUp; k < kSamples; ++k) {
    const double fit_ms = timed_ms([&] { static_cast<void>(steps.fit(pose)); });
    const double residual_ms = timed_ms([&] { model.passes(Precision::kSingle).find_residual(residual); });
    const double solve_ms = timed_ms([&] { steps.find_correction(pose, correction); });
    const double step_ms = timed_ms([&] { pose.positions += correction; });
    if (k < 0) continue;
    local.push_back(fit_ms - residual_ms);  // a fit ends with the residual for the next global step
    global.push_back(residual_ms + solve_ms + step_ms);
    solve.push_back(solve_ms);
  }
  return {median(local), median(global), median(solve),
          static_cast<std::int64_t>(constraints.system().factor().bytes())};
}

}  // namespace arap::bench
