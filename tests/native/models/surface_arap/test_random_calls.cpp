// SPDX-License-Identifier: GPL-3.0-or-later
// Random calls on bad meshes in three threads, each with objects of its own. ARAP_FUZZ_SECONDS=300 goes on for as long,
// for the sanitizers above all; tests/attack/fuzz_module.py does more, and from Python.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::SurfaceArap;

/// One mesh and some calls on it, the same for the same seed.
class RandomCalls {
 public:
  explicit RandomCalls(std::uint64_t seed) : random_(seed), mesh_(bad_mesh()) {}

  /// What is wrong, or nothing. Refusals in words are right.
  std::string run() {
    try {
      SurfaceArap solver(mesh_.mesh(), options(), properties());
      set_constraints(solver);
      for (int n_calls = below(6); n_calls >= 0; --n_calls) {
        guarded([&] { call(solver); });
        if (!solver.positions().allFinite()) return "positions are not finite";
      }
    } catch (const arap::InvalidInput&) {
    } catch (const arap::SolverError&) {
    } catch (const arap::Cancelled&) {
    } catch (const std::exception& error) {
      return error.what();
    }
    return wrong_;
  }

 private:
  int below(int n) { return std::min(n - 1, static_cast<int>(random_.uniform(0, n))); }
  bool chance(double share) { return random_.uniform(0, 1) < share; }
  double any_scale(double decades) { return std::pow(10, random_.uniform(-decades, decades)); }
  std::vector<int> some_vertices(int count) {
    std::vector<int> vertices;
    for (int k = 0; k < count; ++k) vertices.push_back(below(mesh_.n_vertices()));
    return vertices;
  }

  MeshData bad_mesh() {
    std::vector<MeshData> small = all_small_meshes();
    // One in four is large enough for single precision and for pieces of loops.
    MeshData mesh = chance(.25) ? bumpy_sphere(4) : small[static_cast<size_t>(below(static_cast<int>(small.size())))];
    const int n = mesh.n_vertices();
    for (int k = below(4); k > 0; --k) mesh.vertices[below(n)] *= any_scale(12);
    for (int k = below(4); k > 0; --k) mesh.vertices[below(n)] = mesh.vertices[below(n)];
    for (int k = below(4); k > 0; --k) mesh.faces.push_back({below(n), below(n), below(n)});
    if (chance(.3)) mesh.add_vertex(random_.vector(any_scale(20)));
    const double scale = any_scale(chance(.2) ? 30 : 2);
    for (Vector3& p : mesh.vertices) p *= scale;
    return mesh;
  }

  arap::Options options() {
    const std::vector<Model> models = all_models();
    arap::Options options = models[static_cast<size_t>(below(static_cast<int>(models.size())))].options();
    options.threads = 1 + below(3);
    options.join_seams = chance(.3);
    return options;
  }

  arap::VertexProperties properties() {
    arap::VertexProperties result;
    for (int v = 0, n = chance(.3) ? mesh_.n_vertices() : 0; v < n; ++v) result.stiffness.push_back(any_scale(3));
    for (int v = 0, n = chance(.3) ? mesh_.n_vertices() : 0; v < n; ++v) result.rigid_regions.push_back(below(8) - 6);
    return result;
  }

  void set_constraints(SurfaceArap& solver) {
    arap::ConstraintSet set;
    set.vertices = some_vertices(below(6));
    std::sort(set.vertices.begin(), set.vertices.end());
    set.vertices.erase(std::unique(set.vertices.begin(), set.vertices.end()), set.vertices.end());
    for (size_t k = 0; k < set.vertices.size(); ++k) set.strengths.push_back(chance(.5) ? 1 : random_.uniform(1e-9, 1));
    if (chance(.4)) guarded([&] { set.patches.add(solver.patch_around(some_vertices(2), random_.uniform(0, .5))); });
    solver.set_constraints(set, progress());
    set_ = set;
  }

  void call(SurfaceArap& solver) {
    const Positions before = solver.positions();
    const std::vector<std::function<void()>> calls{
        [&] { set_constraints(solver); }, [&] { solver.reset(); },
        [&] { solver.set_positions(before + random_.noise(static_cast<int>(before.rows()), any_scale(20))); },
        [&] {
          if (!std::isfinite(solver.energy(before))) wrong_ = "an energy is not finite";
        },
        [&] {
          if (!solver.energy_gradient(before).allFinite()) wrong_ = "a gradient is not finite";
        }};
    const auto chosen = static_cast<size_t>(below(2 * static_cast<int>(calls.size())));
    if (chosen < calls.size())
      calls[chosen]();
    else
      solve(solver, before);
  }

  void solve(SurfaceArap& solver, const Positions& before) {
    Positions targets = values_of(set_, before);
    targets += random_.noise(static_cast<int>(targets.rows()), chance(.8) ? mesh_.diagonal() : any_scale(30));
    const arap::SolveResult result = solver.solve(targets, iterations(1 + below(20)), {}, progress());
    if (!result.positions.allFinite() || !std::isfinite(result.energy_after)) wrong_ = "a result is not finite";
    if (result.stop_reason == arap::StopReason::kCancelled && solver.positions() != before)
      wrong_ = "a cancelled solve has moved the mesh";
  }

  arap::Progress progress() {
    if (!chance(.2)) return {};
    return [left = below(10)](double) mutable { return left-- > 0; };
  }

  template <class Act>
  static void guarded(const Act& act) {
    try {
      act();
    } catch (const arap::InvalidInput&) {
    } catch (const arap::SolverError&) {
    } catch (const arap::Cancelled&) {
    }
  }

  Random random_;
  MeshData mesh_;
  arap::ConstraintSet set_;
  std::string wrong_;
};

TEST(RandomCalls, FindNothing) {
  const char* seconds = std::getenv("ARAP_FUZZ_SECONDS");  // NOLINT(concurrency-mt-unsafe): no thread changes it
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds ? std::atoi(seconds) : 0);
  constexpr std::uint64_t kFewest = 30;
  std::atomic<std::uint64_t> next = 0;
  const auto work = [&] {
    for (std::uint64_t seed = next++; seed < kFewest || std::chrono::steady_clock::now() < end; seed = next++) {
      const std::string wrong = RandomCalls(seed).run();
      EXPECT_EQ(wrong, "") << "seed " << seed;
    }
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < 3; ++k) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  RecordProperty("meshes", std::to_string(next));
}

}  // namespace
}  // namespace arap_test
