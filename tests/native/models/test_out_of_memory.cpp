// SPDX-License-Identifier: GPL-3.0-or-later
// Every single allocation of every act may fail: then the act ends with bad_alloc and nothing has changed. This is a
// program of its own, as it replaces the allocator.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <string>

#include "arap/cage.h"
#include "arap/cage_transfer.h"
#include "arap/lattice_tets.h"
#include "arap/surface_arap.h"
#include "arap/wrap_deformation.h"
#include "support/any_model.h"
#include "support/helpers.h"

namespace {

std::atomic<long> left = 0;  ///< allocations until one fails
std::atomic<bool> has_failed = false;

bool fails() {
  if (left.load(std::memory_order_relaxed) <= 0 || left.fetch_sub(1) != 1) return false;
  has_failed = true;
  return true;
}

}  // namespace

// The linker puts these in the place of the functions of the C library, which Eigen calls.
extern "C" {
void* __real_malloc(size_t size);                // NOLINT(bugprone-reserved-identifier)
void* __real_calloc(size_t count, size_t size);  // NOLINT(bugprone-reserved-identifier)
void* __real_realloc(void* old, size_t size);    // NOLINT(bugprone-reserved-identifier)
void* __wrap_malloc(size_t size) {               // NOLINT(bugprone-reserved-identifier)
  return fails() ? nullptr : __real_malloc(size);
}
void* __wrap_calloc(size_t count, size_t size) {  // NOLINT(bugprone-reserved-identifier)
  return fails() ? nullptr : __real_calloc(count, size);
}
void* __wrap_realloc(void* old, size_t size) {  // NOLINT(bugprone-reserved-identifier)
  return fails() ? nullptr : __real_realloc(old, size);
}
}

// Not inlined, or the compiler would see free() for what it takes from new.
[[gnu::noinline]] void* operator new(size_t size) {
  void* const memory = fails() ? nullptr : __real_malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void* operator new(size_t size, std::align_val_t alignment) {
  const auto step = static_cast<size_t>(alignment);
  void* const memory = fails() ? nullptr : std::aligned_alloc(step, (size + step - 1) / step * step);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t /*size*/) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t /*alignment*/) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t /*size*/, std::align_val_t /*alignment*/) noexcept {
  std::free(memory);
}

namespace arap_test {
namespace {

enum class End { kDone, kRefused, kAllDone };

/// Acts with the k-th allocation failing.
template <class Act>
End act_without(long k, const Act& act) {
  End end = End::kRefused;
  has_failed = false;
  left = k;
  try {
    act();
    end = has_failed ? End::kDone : End::kAllDone;
  } catch (const std::bad_alloc&) {
    left = 0;
  } catch (const std::exception& error) {
    left = 0;
    ADD_FAILURE() << "another kind of exception: " << error.what();
  }
  left = 0;
  return end;
}

/// Fails the allocations of an act, one a run, and calls check() wherever it was refused, and again() where it was
/// done. One thread allocates as two do: all with one thread, and every seventh with two, where runs are slow.
template <class Act, class Check, class Again>
void fail_each(const char* what, int threads, const Act& act, const Check& check, const Again& again) {
  for (long k = 1;; k += threads == 1 ? 1 : 7) {
    SCOPED_TRACE(std::string(what) + ": allocation " + std::to_string(k));
    const End end = act_without(k, act);
    if (end == End::kRefused) check();
    if (end == End::kDone) again();
    if (end == End::kAllDone) {
      EXPECT_GT(k, 1);
      return;
    }
    if (testing::Test::HasFailure()) return;
  }
}

struct Case {
  KindOfModel kind;
  int threads;
};

std::vector<Case> cases() {
  std::vector<Case> result;
  for (const KindOfModel& kind : kinds_of_models())
    for (const int threads : {1, 2}) result.push_back({kind, threads});
  return result;
}

class WithoutMemory : public testing::TestWithParam<Case> {
 protected:
  [[nodiscard]] const KindOfModel& kind() const { return GetParam().kind; }
  [[nodiscard]] std::unique_ptr<AnyModel> bind() const { return kind().bind(GetParam().threads); }

  const Task here_ = pull_on(kind(), {rotation_about({.3, 1, .2}, .2), {.05, .1, -.05}});
  const Task there_ = pull_on(kind(), {rotation_about({.3, 1, .2}, -.3), {0, .1, .1}}, .5);
};

TEST_P(WithoutMemory, ABindFailsWithNothingElse) {
  fail_each(
      "bind", GetParam().threads, [&] { static_cast<void>(bind()); }, [] {}, [] {});
}

TEST_P(WithoutMemory, EveryOtherActLeavesEverythingAsItWas) {
  const std::unique_ptr<AnyModel> model = bind();
  const arap::SolveOptions few = iterations(2, arap::InitialGuess::kRest);
  const arap::SolveOptions on = iterations(2);
  model->set_constraints(here_.constraints);
  const Positions expected = model->solve(here_.targets, few).positions;
  const auto check = [&] {
    EXPECT_LE(max_distance(model->positions(), expected), 1e-14);
    EXPECT_LE(max_distance(model->solve(here_.targets, few).positions, expected), 1e-14);
  };
  const auto again = [&] {
    model->set_constraints(here_.constraints);
    model->solve(here_.targets, few);
  };
  fail_each(
      "set_constraints", GetParam().threads, [&] { model->set_constraints(there_.constraints); }, check, again);
  again();
  fail_each(
      "set_positions", GetParam().threads, [&] { model->set_positions(kind().rest); }, check, again);
  again();
  fail_each(
      "solve", GetParam().threads, [&] { model->solve(1.01 * here_.targets, on); }, check, again);
}

INSTANTIATE_TEST_SUITE_P(Models, WithoutMemory, testing::ValuesIn(cases()),
                         [](const testing::TestParamInfo<Case>& tested) {
                           return tested.param.kind.name + "With" + std::to_string(tested.param.threads) + "Threads";
                         });

TEST(WithoutMemory, ConstraintsThatCutASurfaceAreThereOrTheFormerOnes) {
  const MeshData bar = box({6, 2, 2}, {3, 1, 1}, Faces::kQuads);
  // A ring around x is held, the end moves.
  const auto cut_at = [&](double x) {
    Task task;
    for (int v = 0; v < bar.n_vertices(); ++v)
      if (std::abs(bar.vertices[v][0] - x) < .1)
        task.add(v, bar.vertices[v]);
      else if (bar.vertices[v][0] > 1.4)
        task.add(v, bar.vertices[v] + Vector3(.1, .2, 0));
    return task;
  };
  const Task here = cut_at(0);
  const Task there = cut_at(-.5);
  arap::Options options;
  options.rigidity_radius = .15;
  options.threads = 1;
  arap::SurfaceArap model(bar.mesh(), options);
  const arap::SolveOptions few = iterations(2, arap::InitialGuess::kRest);
  model.set_constraints(here.constraints);
  const Positions expected = model.solve(here.targets, few).positions;
  fail_each(
      "set_constraints", 1, [&] { model.set_constraints(there.constraints); },
      [&] {
        EXPECT_EQ(model.positions(), expected);
        EXPECT_EQ(model.solve(here.targets, few).positions, expected);
      },
      [&] {
        model.set_constraints(here.constraints);
        model.solve(here.targets, few);
      });
}

/// What moves points with a mesh has no state but the bind.
template <class Bind>
void expect_all_or_nothing(int threads, const Bind& bind, const Positions& moved) {
  fail_each(
      "bind", threads, [&] { static_cast<void>(bind()); }, [] {}, [] {});
  const auto bound = bind();
  const Positions expected = bound.deform(moved);
  const auto check = [&] { EXPECT_EQ(bound.deform(moved), expected); };
  fail_each(
      "deform", threads, [&] { static_cast<void>(bound.deform(moved)); }, check, [] {});
}

TEST(WithoutMemory, CageDeformationsAreWholeOrNot) {
  const arap::PolygonMesh bar = box({6, 2, 2}, {3, 1, 1}, Faces::kQuads).mesh();
  const arap::PolygonMesh cage = arap::make_cage(bar, 3);
  for (const int threads : {1, 2})
    for (const auto coordinates : {arap::CageCoordinates::kMeanValue, arap::CageCoordinates::kGreen}) {
      arap::CageOptions options;
      options.coordinates = coordinates;
      options.threads = threads;
      expect_all_or_nothing(
          threads, [&] { return arap::CageDeformation(cage, bar.positions(), options); }, 1.1 * cage.positions());
    }
}

TEST(WithoutMemory, ACageIsFittedOrAsItWas) {
  const arap::PolygonMesh bar = box({6, 2, 2}, {3, 1, 1}, Faces::kQuads).mesh();
  const arap::PolygonMesh cage = arap::make_cage(bar, 2);
  const Positions moved = 1.1 * bar.positions() + Random(1).noise(bar.n_vertices(), .01);
  const auto fresh = [&] { return arap::CageDeformation(cage, bar.positions()); };
  const Positions expected = fresh().fit(moved, 1e-4);
  auto bound = fresh();
  const auto check = [&] { EXPECT_EQ(bound.fit(moved, 1e-4), expected); };
  fail_each(
      "the first fit", 1, [&] { static_cast<void>(bound.fit(moved, 1e-3)); },
      [&] {
        check();
        bound = fresh();
      },
      [] {});
  fail_each(
      "another fit", 1, [&] { static_cast<void>(bound.fit(moved, 1e-3)); }, check, [] {});
}

TEST(WithoutMemory, WrapDeformationsAreWholeOrNot) {
  const arap::PolygonMesh bar = box({6, 2, 2}, {3, 1, 1}, Faces::kQuads).mesh();
  const Positions points = 1.05 * bar.positions();
  for (const int threads : {1, 2}) {
    arap::WrapOptions options;
    options.threads = threads;
    expect_all_or_nothing(
        threads, [&] { return arap::WrapDeformation(bar, points, options); }, 1.1 * bar.positions());
  }
}

TEST(WithoutMemory, WhatIsMadeOfAMeshFailsWithNothingElse) {
  const arap::PolygonMesh bar = box({4, 2, 2}, {3, 1, 1}, Faces::kQuads).mesh();
  const arap::PolygonMesh cage = arap::make_cage(bar, 2);
  arap::CageOptions harmonic;
  harmonic.coordinates = arap::CageCoordinates::kHarmonic;
  harmonic.grid_spacing = .1;
  harmonic.threads = 1;
  const auto fails_cleanly = [](const char* what, const auto& make) {
    fail_each(
        what, 1, [&] { static_cast<void>(make()); }, [] {}, [] {});
  };
  fails_cleanly("places", [&] { return bar.same_places(1); });
  fails_cleanly("cage", [&] { return arap::make_cage(bar, 2); });
  fails_cleanly("tetrahedra", [&] { return arap::LatticeTets::around(bar, .3); });
  fails_cleanly("transfer", [&] { return arap::transfer_cage(cage, 1.1 * cage.positions(), cage); });
  fails_cleanly("harmonic weights", [&] { return arap::CageDeformation(cage, bar.positions(), harmonic); });
}

}  // namespace
}  // namespace arap_test
