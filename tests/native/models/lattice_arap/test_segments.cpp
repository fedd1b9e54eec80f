// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "arap/error.h"
#include "arap/lattice_arap.h"
#include "arap/surface_arap.h"
#include "lattice/lattice.h"
#include "lattice/segment_core.h"
#include "models/lattice_arap/rods.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::ConstraintSet;
using arap::LatticeArap;
using arap::LatticeOptions;
using arap::Segment;
using arap::SolveResult;

/// Cubes of a quarter of its width.
LatticeOptions for_rod(const MeshData& mesh, double keep_volume = 0) {
  LatticeOptions options;
  options.cube_size = .25 / mesh.diagonal();
  options.keep_volume = keep_volume;
  return options;
}

/// Two bones in a rod, from end to end.
const std::vector<Segment> kArm{{{0, 0, -2.9}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 2.9}}};

Positions targets_of(const std::vector<Segment>& segments, const std::vector<RigidMotion>& motions) {
  Positions targets(Segment::kTargets * segments.size(), 3);
  for (size_t s = 0; s < segments.size(); ++s) {
    const Positions rest = segments[s].rest_targets();
    for (int k = 0; k < Segment::kTargets; ++k)
      targets.row(Segment::kTargets * static_cast<int>(s) + k) = motions[s].apply(Vector3(rest.row(k))).transpose();
  }
  return targets;
}

const RigidMotion kStays{Matrix3::Identity(), Vector3::Zero()};

ConstraintSet set_of(const std::vector<Segment>& segments) {
  ConstraintSet set;
  set.segments = segments;
  return set;
}

/// The arm with its upper bone turned by `angle` about `axis`, in steps.
Positions pose_arm(const MeshData& mesh, const Vector3& axis, double angle, const LatticeOptions& options) {
  LatticeArap solver(mesh.mesh(), options);
  solver.set_constraints(set_of(kArm));
  constexpr int kSteps = 6;
  for (int step = 1; step < kSteps; ++step)
    solver.solve(targets_of(kArm, {kStays, {rotation_about(axis, angle * step / kSteps), Vector3::Zero()}}));
  return solver.solve(targets_of(kArm, {kStays, {rotation_about(axis, angle), Vector3::Zero()}}), to_accuracy(1e-6))
      .positions;
}

TEST(Segments, RestAndMoveRigidly) {
  const MeshData mesh = rod(12, 36);
  LatticeArap solver(mesh.mesh(), for_rod(mesh));
  solver.set_constraints(set_of(kArm));
  const Positions rest = solver.solve(targets_of(kArm, {kStays, kStays}), to_accuracy(1e-7)).positions;
  EXPECT_LT(furthest(rest, mesh.positions()), 1e-6 * mesh.diagonal());
  const RigidMotion motion = Random(3).rigid_motion(2, 5);
  const Positions moved = solver.solve(targets_of(kArm, {motion, motion}), to_accuracy(1e-7)).positions;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    EXPECT_LT((moved.row(v).transpose() - motion.apply(mesh.vertices[v])).norm(), 1e-5 * mesh.diagonal());
}

/// Linear skinning with smooth weights has .50 of the section at an elbow of 120 degrees, and .00 at a twist of 180.
TEST(Segments, AnElbowAndATwistKeepTheirSection) {
  const MeshData mesh = rod();
  const LatticeOptions options = for_rod(mesh, 1);
  const Positions elbow = pose_arm(mesh, Vector3(1, 0, 0), 2.0944, options);
  EXPECT_GT(thinnest(mesh, elbow), .9);
  EXPECT_GT(volume(mesh, elbow) / volume(mesh, mesh.positions()), .95);
  const Positions twisted = pose_arm(mesh, Vector3(0, 0, 1), 3.14159265, options);
  EXPECT_GT(thinnest(mesh, twisted), .9);
  EXPECT_GT(volume(mesh, twisted) / volume(mesh, mesh.positions()), .97);
}

TEST(Segments, WhatIsAroundABoneGoesWithIt) {
  const MeshData mesh = rod(12, 36);
  const RigidMotion bend{rotation_about(Vector3(1, 0, 0), 1.2), Vector3::Zero()};
  const Positions posed = pose_arm(mesh, Vector3(1, 0, 0), 1.2, for_rod(mesh));
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const double z = mesh.vertices[v][2];
    if (std::abs(z) < 1.2) continue;  // where the elbow is, and a little farther
    const Vector3 expected = z > 0 ? bend.apply(mesh.vertices[v]) : mesh.vertices[v];
    EXPECT_LT((posed.row(v).transpose() - expected).norm(), .02) << z;
  }
}

TEST(Segments, HardVerticesAreAtTheirTargetsBesideBones) {
  const MeshData mesh = rod(12, 36);
  Task task = hold(mesh, extreme_vertices(mesh.positions(), 2, .1));
  const std::vector<Segment> upper{kArm[1]};
  task.constraints.segments = upper;
  const RigidMotion bend{rotation_about(Vector3(1, 0, 0), .8), Vector3::Zero()};
  Positions targets(task.constraints.n_targets(), 3);
  targets << task.targets, targets_of(upper, {bend});
  LatticeArap solver(mesh.mesh(), for_rod(mesh));
  solver.set_constraints(task.constraints);
  const Positions posed = solver.solve(targets).positions;
  for (const int v : task.constraints.vertices) EXPECT_LT((posed.row(v) - mesh.positions().row(v)).norm(), 1e-12);
  const int tip = extreme_vertices(mesh.positions(), 2, -1e-9).front();
  EXPECT_LT((posed.row(tip).transpose() - bend.apply(mesh.vertices[tip])).norm(), .1);
}

/// Two balls that overlap: only the one that the bone passes through moves.
TEST(Segments, HoldThePartsThatTheyPassThrough) {
  const MeshData ball = icosphere(2);
  const MeshData mesh = join(ball, transformed(ball, [](const Vector3& x) { return Vector3(x + Vector3(1.5, 0, 0)); }));
  const std::vector<Segment> bone{{{-.7, 0, -.5}, {-.7, 0, .5}}};
  LatticeArap solver(mesh.mesh(), coarse());
  solver.set_constraints(set_of(bone));
  const SolveResult result = solver.solve(targets_of(bone, {{Matrix3::Identity(), Vector3(0, 0, 1)}}));
  EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
  EXPECT_NEAR((result.positions.row(0) - mesh.positions().row(0))[2], 1, 1e-3);
}

/// Two fingers in the same cubes: the bone of one is not in the other.
TEST(SegmentCore, IsInOneFinger) {
  constexpr double kGap = .05;
  const MeshData mesh = hand(kGap);
  const arap::Lattice lattice(mesh.mesh(), .2);
  const std::vector<int> core = segment_core(lattice, {{-.275, 0, -.9}, {-.275, 0, .9}});
  EXPECT_FALSE(core.empty());
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.vertices[v][0] > 0) {
      EXPECT_FALSE(std::binary_search(core.begin(), core.end(), lattice.piece_of_vertex()[v]));
    }
}

TEST(SegmentCore, EndsBeforeItsJoints) {
  const MeshData mesh = rod(12, 36);
  const arap::Lattice lattice(mesh.mesh(), .25);
  double lowest = 3;
  double highest = -3;
  for (const int piece : segment_core(lattice, kArm[1]))
    for (const int c : lattice.control_points(piece)) {
      lowest = std::min(lowest, lattice.rest()(c, 2));
      highest = std::max(highest, lattice.rest()(c, 2));
    }
  // Control points are up to a cube away from the cube that has them.
  EXPECT_NEAR(lowest, .6 - .25, .25);
  EXPECT_GT(highest, 2.5);
  // A short bone keeps a core.
  EXPECT_FALSE(segment_core(lattice, {{0, 0, -.2}, {0, 0, .2}}).empty());
}

TEST(SegmentErrors, SayWhatIsWrong) {
  const MeshData mesh = rod(12, 36);
  LatticeArap solver(mesh.mesh(), for_rod(mesh));
  const Segment inside = kArm[0];
  const Segment outside{{1, 0, 0}, {1, 0, 1}};
  const Segment far_away{{1e6, 0, 0}, {1e9, 0, 1}};
  EXPECT_EQ(solver.segments_outside({outside, inside, far_away}), (std::vector<int>{0, 2}));
  expect_error<arap::InvalidInput>(
      [&] {
        solver.set_constraints(set_of({inside, outside}));
      },
      {"segment 1", "inside of the mesh", "leave it out"});
  const double nan = std::nan("");
  for (const Segment& bad : {Segment{{nan, 0, 0}, {0, 0, 1}}, Segment{{0, 0, 0}, {0, 0, 1e200}}})
    expect_error<arap::InvalidInput>([&] { solver.set_constraints(set_of({inside, bad})); }, {"segment 1", "finite"});
  expect_error<arap::InvalidInput>(
      [&] {
        solver.set_constraints(set_of({{{1, 2, 3}, {1, 2, 3}}}));
      },
      {"segment 0", "no length"});
  solver.set_constraints(set_of({inside}));
  Positions targets = targets_of({inside}, {kStays});
  targets(3, 1) = nan;
  expect_error<arap::InvalidInput>([&] { static_cast<void>(solver.solve(targets)); },
                                   {"targets", "row 3", "segment 0"});
  arap::SurfaceArap surface(mesh.mesh());
  expect_error<arap::InvalidInput>([&] { surface.set_constraints(set_of({inside})); }, {"inside", "LatticeArap"});
}

}  // namespace
}  // namespace arap_test
