// SPDX-License-Identifier: GPL-3.0-or-later
// Measures the library on one task file. Reads commands from standard input, one per line, and answers each with one
// line of JSON. measure/runs/native.py is its client. Times are in milliseconds.
//
//   arap_worker TASK ENERGY THREADS [SOLVER]
//       ENERGY as in Python's Options; THREADS as Options::threads; SOLVER: block_ldlt, the library's own, or a
//       reference
//
//   bind             {"ms", "threads"}   constructs a new model
//   constraints      {"ms"}              factorizes for a set that differs from the last one
//   solve K          {"ms", "energy"}    K iterations from rest
//   plain K          {"ms", "energy"}    K iterations of local/global without acceleration from rest
//   steps            {"local_ms", "global_ms", "solve_ms", "factor_bytes"}
//   bandwidth BYTES  {"gb_per_s"}
//   memory           {"peak_mb"}
#include <cstdint>
#include <exception>
#include <iostream>
#include <map>
#include <optional>
#include <sstream>
#include <string>

#include "arap/surface_arap.h"
#include "process.h"
#include "references/eigen_solvers.h"
#include "task_file.h"
#include "timings.h"

namespace arap::bench {
namespace {

template <class T>
T chosen(const std::string& argument, const std::string& name, const std::map<std::string, T>& values) {
  if (const auto found = values.find(name); found != values.end()) return found->second;
  std::string names;
  for (const auto& [each, value] : values) names += (names.empty() ? "" : ", ") + each;
  throw InvalidInput(argument + " is " + name + ", must be one of " + names);
}

class Worker {
 public:
  Worker(const std::string& path, const std::string& energy, int threads, const std::string& solver) : task_(path) {
    options_.energy = chosen<Energy>("ENERGY", energy,
                                     {{"rotation_nodes", Energy::kRotationNodes},
                                      {"spokes_and_rims", Energy::kSpokesAndRims},
                                      {"spokes", Energy::kSpokes}});
    options_.threads = threads;
    options_.solver_factory =
        chosen<const SolverFactory*>("SOLVER", solver,
                                     {{"block_ldlt", nullptr},
                                      {"simplicial_ldlt", &reference_solver(ReferenceSolver::kSimplicialLdlt)},
                                      {"sparse_lu", &reference_solver(ReferenceSolver::kSparseLu)},
                                      {"sparse_qr", &reference_solver(ReferenceSolver::kSparseQr)},
                                      {"bicgstab", &reference_solver(ReferenceSolver::kBiCgStab)}});
    // Two sets alternate: setting the same one again costs nothing.
    sets_[0].vertices = task_.constrained;
    sets_[0].strengths.assign(task_.constrained.size(), 1.0);
    sets_[1] = sets_[0];
    sets_[1].vertices.pop_back();
    sets_[1].strengths.pop_back();
  }

  /// The answer to a command; throws std::runtime_error for an unknown one.
  std::string answer(const std::string& command) {
    std::istringstream words(command);
    std::string name;
    std::int64_t number = 0;
    words >> name >> number;
    std::ostringstream out;
    out.precision(17);
    out << '{';
    if (name == "bind") {
      model_.reset();
      const PolygonMesh mesh = task_.mesh();
      const Stopwatch watch;
      model_.emplace(mesh, options_);
      out << R"("ms": )" << watch.ms() << R"(, "threads": )" << model_->threads();
    } else if (name == "constraints") {
      current_ = 1 - current_;
      out << R"("ms": )" << set_constraints();
    } else if (name == "solve") {
      solve(static_cast<int>(number), Acceleration::kConjugateGradients, out);
    } else if (name == "plain") {
      solve(static_cast<int>(number), Acceleration::kNone, out);
    } else if (name == "steps") {
      model_.reset();
      const StepTimes t = time_steps(task_, options_);
      out << R"("local_ms": )" << t.local_ms << R"(, "global_ms": )" << t.global_ms << R"(, "solve_ms": )" << t.solve_ms
          << R"(, "factor_bytes": )" << t.factor_bytes;
    } else if (name == "bandwidth") {
      out << R"("gb_per_s": )" << read_bandwidth_gb_per_s(number, options_.threads);
    } else if (name == "memory") {
      out << R"("peak_mb": )" << peak_memory_mb();
    } else {
      throw std::runtime_error("no command " + name);
    }
    out << '}';
    return out.str();
  }

 private:
  SurfaceArap& model() {
    if (!model_) throw std::runtime_error("bind first");
    return *model_;
  }

  double set_constraints() {
    const Stopwatch watch;
    model().set_constraints(sets_[current_]);
    return watch.ms();
  }

  void solve(int n_iterations, Acceleration acceleration, std::ostringstream& out) {
    current_ = 0;
    set_constraints();
    SolveOptions options;
    options.max_iterations = n_iterations;
    options.acceleration = acceleration;
    // The finest accuracy that starts in single precision.
    options.accuracy = 1e-7;
    // The default guess after a reset, as in the first move of a drag.
    model().reset();
    const Stopwatch watch;
    const SolveResult result = model().solve(task_.targets, options);
    out << R"("ms": )" << watch.ms() << R"(, "energy": )" << result.energy_after;
  }

  TaskFile task_;
  Options options_;
  ConstraintSet sets_[2];
  int current_ = 1;
  std::optional<SurfaceArap> model_;
};

}  // namespace
}  // namespace arap::bench

int main(int argc, char** argv) {
  try {
    if (argc != 4 && argc != 5) throw std::runtime_error("usage: arap_worker TASK ENERGY THREADS [SOLVER]");
    arap::bench::Worker worker(argv[1], argv[2], std::stoi(argv[3]), argc == 5 ? argv[4] : "block_ldlt");
    for (std::string command; std::getline(std::cin, command);) std::cout << worker.answer(command) << std::endl;
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
