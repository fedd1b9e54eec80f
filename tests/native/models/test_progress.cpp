// SPDX-License-Identifier: GPL-3.0-or-later
// What all long calls have in common: they tell how far they are, up to 1, and may be stopped, also there.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arap/cage.h"
#include "arap/cage_arap.h"
#include "arap/cage_transfer.h"
#include "arap/embedded_deformation.h"
#include "arap/lattice_arap.h"
#include "arap/lattice_tets.h"
#include "arap/poisson_editing.h"
#include "arap/tet_arap.h"
#include "arap/wrap_deformation.h"
#include "support/helpers.h"
#include "support/tet_arap.h"

namespace arap_test {
namespace {

using arap::Progress;

static_assert(!std::is_base_of_v<arap::SolverError, arap::Cancelled>, "what handles failures does not handle this");

/// A long call, and what it is.
struct Call {
  std::string name;
  std::function<void(const Progress&)> act;
};

/// The fractions that a call tells.
/// @param stop_at  from this one on it is stopped; which there are hangs on time, but for the last
std::vector<double> told_by(const Call& call, double stop_at = 2) {
  std::vector<double> told;
  call.act([&](double fraction) {
    told.push_back(fraction);
    return fraction < stop_at;
  });
  return told;
}

/// Few cubes.
arap::LatticeOptions coarse() {
  arap::LatticeOptions options;
  options.cube_size = .1;
  return options;
}

/// All that do not change an object, which throw Cancelled.
std::vector<Call> calls_that_throw() {
  static const MeshData mesh = bar(3, Faces::kQuads);
  static const arap::PolygonMesh surface = mesh.mesh();
  static const arap::PolygonMesh cage = arap::make_cage(surface, 4);
  static const TetMesh tets = tet_blocks(3, 1, 1);
  static const Positions points = .5 * mesh.positions();
  return {
      {"SurfaceArap", [](const Progress& p) { arap::SurfaceArap(surface, {}, {}, p); }},
      {"LatticeArap", [](const Progress& p) { arap::LatticeArap(surface, coarse(), {}, p); }},
      {"PoissonEditing", [](const Progress& p) { arap::PoissonEditing(surface, {}, p); }},
      {"EmbeddedDeformation", [](const Progress& p) { arap::EmbeddedDeformation(surface, {}, p); }},
      {"CageArap", [](const Progress& p) { arap::CageArap(surface, cage, {}, p); }},
      {"TetArap", [](const Progress& p) { arap::TetArap(tets, {}, {}, p); }},
      {"CageDeformation", [](const Progress& p) { arap::CageDeformation(cage, points, {}, p); }},
      {"CageDeformation::fit",
       [](const Progress& p) { static_cast<void>(arap::CageDeformation(cage, points).fit(points, 1e-6, p)); }},
      {"WrapSurface", [](const Progress& p) { arap::WrapSurface(surface, 1, p); }},
      {"WrapDeformation", [](const Progress& p) { arap::WrapDeformation(surface, points, {}, {}, p); }},
      {"LatticeTets", [](const Progress& p) { static_cast<void>(arap::LatticeTets::around(surface, .1, p)); }},
      {"make_cage", [](const Progress& p) { static_cast<void>(arap::make_cage(surface, 4, p)); }},
      {"transfer_cage",
       [](const Progress& p) { static_cast<void>(arap::transfer_cage(surface, mesh.positions(), surface, p)); }},
      {"same_places", [](const Progress& p) { static_cast<void>(surface.same_places(1, p)); }},
  };
}

TEST(ProgressOfAll, RisesToOneAndMayStopTheCall) {
  for (const Call& call : calls_that_throw()) {
    const std::vector<double> told = told_by(call);
    ASSERT_FALSE(told.empty()) << call.name;
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end())) << call.name;
    EXPECT_EQ(told.back(), 1) << call.name;
    for (const double stop_at : {0., 1.})
      EXPECT_THROW(told_by(call, stop_at), arap::Cancelled) << call.name << " at " << stop_at;
  }
}

/// Holds both ends of a model of the bar, and bends it.
template <class Model>
void expect_acts_to_rise_to_one(Model model, const Positions& rest, const std::string& name) {
  arap::ConstraintSet set;
  for (const double end : {-.2, .2})
    for (const int v : extreme_vertices(rest, 0, end, 3)) set.vertices.push_back(v);
  Positions targets = values_of(set, rest);
  targets.bottomRows(3).col(1).array() += .3;
  const std::vector<double> of_set = told_by({name, [&](const Progress& p) { model.set_constraints(set, p); }});
  ASSERT_FALSE(of_set.empty()) << name;
  EXPECT_TRUE(std::is_sorted(of_set.begin(), of_set.end())) << name;
  EXPECT_EQ(of_set.back(), 1) << name;
  for (const int n : {1, 20}) {
    const std::vector<double> told =
        told_by({name, [&](const Progress& p) { model.solve(targets, iterations(n), {}, p); }});
    ASSERT_FALSE(told.empty()) << name;
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end())) << name;
    EXPECT_EQ(told.back(), 1) << name;
  }
  // At the last word nothing is done yet.
  model.reset();
  const Positions before = model.positions();
  const Call solve{name, [&](const Progress& p) {
                     model.reset();
                     model.solve(targets, iterations(1), {}, p);
                   }};
  EXPECT_EQ(told_by(solve, 1).back(), 1) << name;
  EXPECT_EQ(model.positions(), before) << name;
}

TEST(ProgressOfAll, RisesToOneInConstraintsAndSolves) {
  const MeshData mesh = bar(3, Faces::kQuads);
  const arap::PolygonMesh surface = mesh.mesh();
  const TetMesh tets = tet_blocks(3, 1, 1);
  expect_acts_to_rise_to_one(arap::SurfaceArap(surface), mesh.positions(), "SurfaceArap");
  expect_acts_to_rise_to_one(arap::LatticeArap(surface, coarse()), mesh.positions(), "LatticeArap");
  expect_acts_to_rise_to_one(arap::PoissonEditing(surface), mesh.positions(), "PoissonEditing");
  expect_acts_to_rise_to_one(arap::EmbeddedDeformation(surface), mesh.positions(), "EmbeddedDeformation");
  expect_acts_to_rise_to_one(arap::CageArap(surface, arap::make_cage(surface, 4)), mesh.positions(), "CageArap");
  expect_acts_to_rise_to_one(arap::TetArap(tets), tets.positions(), "TetArap");
}

/// A cage serves several calls at once, so also one from the progress of another.
TEST(ProgressOfAll, OfAFitMayFit) {
  const MeshData mesh = bar(3, Faces::kQuads);
  const arap::CageDeformation cage(arap::make_cage(mesh.mesh(), 4), mesh.positions());
  Positions inner;
  const Positions outer = cage.fit(mesh.positions(), 1e-6, [&](double) {
    inner = cage.fit(mesh.positions(), 1e-6);
    return true;
  });
  EXPECT_EQ(inner, outer);
}

}  // namespace
}  // namespace arap_test
