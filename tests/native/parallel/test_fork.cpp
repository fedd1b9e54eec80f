// SPDX-License-Identifier: GPL-3.0-or-later
// The child of a fork has its parent's objects, but none of the threads that they worked with.
#include <gtest/gtest.h>

#if defined(__unix__)
#include <sys/wait.h>
#include <unistd.h>

#include "support/helpers.h"

namespace arap_test {
namespace {

TEST(Fork, AChildBindsAndSolvesAsItsParentDoes) {
  constexpr unsigned kSeconds = 60;
  constexpr double kRounding = 1e-6;  // the factor is in single precision, its top in parts a thread
  const MeshData mesh = bumpy_sphere(4);
  const Task task = bend_task(mesh, default_bend(mesh));
  const Task other = hold(mesh, extreme_vertices(mesh.positions(), 0, .1));
  const arap::Options options{.threads = 2};
  arap::SurfaceArap solver(mesh.mesh(), options);
  solver.set_constraints(task.constraints);
  const Positions expected = solver.solve(task.targets, iterations(3)).positions;
  solver.set_constraints(other.constraints);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(kSeconds);  // ends a child that waits for threads which it has not got
    solver.reset();
    solver.set_constraints(task.constraints);
    const bool is_right = max_distance(solver.solve(task.targets, iterations(3)).positions, expected) < kRounding &&
                          max_distance(solve_once(mesh, task, iterations(3), options).positions, expected) < kRounding;
    _exit(is_right ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace arap_test
#endif
