// SPDX-License-Identifier: GPL-3.0-or-later
// What a single soft constraint does, however weak: the same for every model.
#include <gtest/gtest.h>

#include <utility>

#include "arap/embedded_deformation.h"
#include "arap/error.h"
#include "arap/lattice_arap.h"
#include "arap/lattice_tets.h"
#include "arap/poisson_editing.h"
#include "arap/surface_arap.h"
#include "arap/tet_arap.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

const Vector3 kMove(1, 2, -1);

/// One vertex, pulled away.
template <class Model>
Task pulled(const Model& model, double strength) {
  Task task;
  task.add(0, Vector3(model.positions().row(0)) + kMove, strength);
  return task;
}

template <class Model>
void expect_pull_or_words(Model model) {
  const Task weak = pulled(model, 1e-6);
  model.set_constraints(weak.constraints);
  const Positions posed = model.solve(weak.targets, to_accuracy(1e-6)).positions;
  EXPECT_LT(max_distance(posed.topRows(1), weak.targets), 1e-4);
  const Task drowned = pulled(model, 1e-20);
  expect_error<arap::InvalidInput>([&] { model.set_constraints(drowned.constraints); },
                                   {"vertex 0", "1e-20", "lost in rounding", "hold that part more strongly"});
  Task beside = drowned;
  beside.add(5, model.positions().row(5));
  model.set_constraints(beside.constraints);
  EXPECT_TRUE(model.solve(beside.targets, to_accuracy(1e-6)).positions.allFinite());
}

TEST(WeakConstraints, AreMetOrRefusedInWords) {
  const MeshData mesh = icosphere(2);
  expect_pull_or_words(arap::SurfaceArap(mesh.mesh()));
  expect_pull_or_words(arap::LatticeArap(mesh.mesh()));
  expect_pull_or_words(arap::PoissonEditing(mesh.mesh()));
  expect_pull_or_words(arap::EmbeddedDeformation(mesh.mesh()));
  expect_pull_or_words(arap::TetArap(arap::LatticeTets::around(mesh.mesh(), .2).mesh));
}

}  // namespace
}  // namespace arap_test
