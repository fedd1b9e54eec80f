// SPDX-License-Identifier: GPL-3.0-or-later
// The Python module arap_native._native: arrays in and out, names for the enums, the GIL. Nothing is computed here.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <exception>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#ifdef __GLIBCXX__
#include <cxxabi.h>
#endif

#include "arap/surface_arap.h"
#include "docstrings.h"
#include "job.h"

namespace py = pybind11;

namespace {

// ---------------------------------------------------------------------------------------------------- arrays in

template <typename T>
constexpr const char* kDtype = nullptr;
template <>
constexpr const char* kDtype<double> = "float64";
template <>
constexpr const char* kDtype<float> = "float32";
template <>
constexpr const char* kDtype<int> = "int32";
static_assert(sizeof(int) == 4 && sizeof(float) == 4 && sizeof(double) == 8);

/// One dimension of an expected shape: a size, or a letter for any size.
class Extent {
 public:
  // Implicit, so that {n, 3} and {"n", 3} read as shapes.
  Extent(py::ssize_t size) : size_(size), text_(std::to_string(size)) {}  // NOLINT(google-explicit-constructor)
  Extent(const char* letter) : text_(letter) {}                           // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool accepts(py::ssize_t given) const { return size_ < 0 || size_ == given; }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  py::ssize_t size_ = -1;
  std::string text_;
};
using Shape = std::initializer_list<Extent>;

std::string shape_text(Shape shape) {
  std::string text;
  for (const Extent& extent : shape) {
    if (!text.empty()) text += ", ";
    text += extent.text();
  }
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

std::string shape_text(const py::array& array) { return py::str(py::tuple(array.attr("shape"))); }

std::string type_name(py::handle object) { return py::str(py::type::handle_of(object).attr("__name__")); }

bool has_shape(const py::array& array, Shape shape) {
  if (array.ndim() != static_cast<py::ssize_t>(shape.size())) return false;
  const py::ssize_t* given = array.shape();
  for (const Extent& extent : shape) {
    if (!extent.accepts(*given++)) return false;
  }
  return true;
}

/// `object` as an array of native Ts in C order. Throws a TypeError or ValueError that says what was expected.
template <typename T>
py::array require_dtype(const py::object& object, const std::string& name) {
  if (!py::isinstance<py::array>(object))
    throw py::type_error(name + " is of type " + type_name(object) + ", expected a numpy array of " + kDtype<T>);
  auto array = py::reinterpret_borrow<py::array>(object);
  const py::dtype dtype = array.dtype();
  const bool is_native = dtype.byteorder() == '=' || dtype.byteorder() == '|';
  if (dtype.kind() != (std::is_floating_point_v<T> ? 'f' : 'i') || dtype.itemsize() != sizeof(T) || !is_native)
    throw py::value_error(name + " has dtype " + std::string(py::str(dtype)) + ", expected " + kDtype<T>);
  return array;
}

/// The same for an array of exactly this shape; `rows` says what a row stands for.
template <typename T>
py::array require_array(const py::object& object, const std::string& name, Shape shape, const char* rows) {
  py::array array = require_dtype<T>(object, name);
  if (!has_shape(array, shape))
    throw py::value_error(name + " has shape " + shape_text(array) + ", expected " + shape_text(shape) + ": " + rows);
  if ((array.flags() & py::array::c_style) == 0)
    throw py::value_error(name + " is not C-contiguous, expected rows one after the other: pass a copy of it");
  return array;
}

/// A copy: the library keeps it, or works on it while other Python threads may write to the array.
template <typename T>
std::vector<T> to_vector(const py::array& array) {
  std::vector<T> values(static_cast<size_t>(array.size()));
  if (!values.empty()) std::memcpy(values.data(), array.data(), values.size() * sizeof(T));
  return values;
}

template <typename T>
std::vector<T> vector_from(const py::object& object, const std::string& name, const Extent& size, const char* rows) {
  return to_vector<T>(require_array<T>(object, name, {size}, rows));
}

arap::Positions positions_from(const py::object& object, const char* name, const Extent& rows, const char* rows_text) {
  const py::array array = require_array<double>(object, name, {rows, 3}, rows_text);
  arap::Positions positions(array.shape(0), 3);
  if (positions.size() > 0) std::memcpy(positions.data(), array.data(), static_cast<size_t>(array.nbytes()));
  return positions;
}

std::vector<arap::Matrix3> rotations_from(const py::object& object, const Extent& rows) {
  if (object.is_none()) return {};
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const std::vector<double> values =
      to_vector<double>(require_array<double>(object, "rotations", {rows, 3, 3}, "one matrix per row of targets"));
  std::vector<arap::Matrix3> rotations(values.size() / 9);
  for (size_t r = 0; r < rotations.size(); ++r) rotations[r] = Eigen::Map<const RowMajor>(&values[9 * r]);
  return rotations;
}

/// What a PolygonMesh is made of; made into one without the GIL.
struct MeshArrays {
  arap::Positions positions;
  std::vector<int> corner_vertices;
  std::vector<int> face_sizes;
};

MeshArrays mesh_from(const py::object& rest_positions, const py::object& corner_vertices,
                     const py::object& face_sizes) {
  MeshArrays mesh{positions_from(rest_positions, "rest_positions", "n", "one row per vertex"), {}, {}};
  const bool is_triangles = require_dtype<int>(corner_vertices, "corner_vertices").ndim() == 2;
  if (is_triangles && !face_sizes.is_none())
    throw py::value_error(
        "corner_vertices has two dimensions and face_sizes is given, expected one of them: (m, 3) "
        "triangles alone, or (c,) corners with face_sizes");
  if (is_triangles) {
    mesh.corner_vertices =
        to_vector<int>(require_array<int>(corner_vertices, "corner_vertices", {"m", 3}, "one row per triangle"));
    mesh.face_sizes.assign(mesh.corner_vertices.size() / 3, 3);
    return mesh;
  }
  mesh.corner_vertices =
      vector_from<int>(corner_vertices, "corner_vertices", "c", "one entry per corner, or (m, 3) for triangles");
  if (face_sizes.is_none())
    throw py::value_error("face_sizes is None, expected (f,) int32: only corner_vertices of shape (m, 3) need none");
  mesh.face_sizes = vector_from<int>(face_sizes, "face_sizes", "f", "one entry per face");
  return mesh;
}

arap::PolygonMesh mesh_of(MeshArrays arrays) {
  return {std::move(arrays.positions), std::move(arrays.corner_vertices), std::move(arrays.face_sizes)};
}

arap::Patches patches_from(const py::object& object) {
  if (object.is_none()) return {};
  if (!py::isinstance<py::tuple>(object) || py::len(object) != 3)
    throw py::type_error("patches is not a tuple of three arrays, expected (offsets, vertices, weights)");
  const auto fields = py::reinterpret_borrow<py::tuple>(object);
  arap::Patches patches;
  patches.offsets =
      vector_from<int>(fields[0], "patch offsets", "n_patches + 1", "where each patch begins, and the end");
  patches.vertices = vector_from<int>(fields[1], "patch vertices", "e", "one entry per vertex of a patch");
  patches.weights = vector_from<double>(fields[2], "patch weights", static_cast<py::ssize_t>(patches.vertices.size()),
                                        "one entry per vertex of a patch");
  return patches;
}

// --------------------------------------------------------------------------------------------------- arrays out

/// The numbers of an array that is written to; none for None. The array must outlive them.
std::span<float> out_from(const py::object& object, py::ssize_t n_vertices) {
  if (object.is_none()) return {};
  py::array array = require_array<float>(object, "out", {n_vertices, 3}, "one row per vertex");
  if (!array.writeable()) throw py::value_error("out is read-only, expected an array that can be written to");
  if ((array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0)
    throw py::value_error(
        "out is not aligned, expected numbers at multiples of their size: pass an array made by numpy");
  return {static_cast<float*>(array.mutable_data()), static_cast<size_t>(array.size())};
}

template <typename T>
py::array to_array(std::vector<T> values) {
  auto owned = std::make_unique<std::vector<T>>(std::move(values));
  const auto size = static_cast<py::ssize_t>(owned->size());
  const T* data = owned->data();
  const py::capsule owner(owned.release(), [](void* p) { delete static_cast<std::vector<T>*>(p); });
  return py::array_t<T>(size, data, owner);
}

py::array to_array(arap::Positions values) {
  auto owned = std::make_unique<arap::Positions>(std::move(values));
  const py::ssize_t rows = owned->rows();
  const double* data = owned->data();
  const py::capsule owner(owned.release(), [](void* p) { delete static_cast<arap::Positions*>(p); });
  return py::array_t<double>({rows, py::ssize_t{3}}, data, owner);
}

// -------------------------------------------------------------------------------------------------------- enums

template <typename Enum>
using Names = std::span<const std::pair<const char*, Enum>>;

constexpr std::pair<const char*, arap::Energy> kEnergies[] = {
    {"rotation_nodes", arap::Energy::kRotationNodes},
    {"spokes_and_rims", arap::Energy::kSpokesAndRims},
    {"spokes", arap::Energy::kSpokes},
};
constexpr std::pair<const char*, arap::EdgeWeights> kWeights[] = {
    {"cotangent", arap::EdgeWeights::kCotangent},
    {"uniform", arap::EdgeWeights::kUniform},
};
constexpr std::pair<const char*, arap::LinearSolverKind> kLinearSolvers[] = {
    {"block_ldlt", arap::LinearSolverKind::kBlockLdlt}, {"simplicial_ldlt", arap::LinearSolverKind::kSimplicialLdlt},
    {"sparse_lu", arap::LinearSolverKind::kSparseLu},   {"sparse_qr", arap::LinearSolverKind::kSparseQr},
    {"bicgstab", arap::LinearSolverKind::kBiCgStab},
};
constexpr std::pair<const char*, arap::InitialGuess> kInitialGuesses[] = {
    {"previous", arap::InitialGuess::kPrevious},
    {"rest", arap::InitialGuess::kRest},
    {"naive_laplacian", arap::InitialGuess::kNaiveLaplacian},
    {"handle_rotations", arap::InitialGuess::kHandleRotations},
};
constexpr std::pair<const char*, arap::Acceleration> kAccelerations[] = {
    {"conjugate_gradients", arap::Acceleration::kConjugateGradients}, {"none", arap::Acceleration::kNone}};
constexpr std::pair<const char*, arap::StopReason> kStopReasons[] = {
    {"converged", arap::StopReason::kConverged},
    {"max_iterations", arap::StopReason::kMaxIterations},
    {"time_limit", arap::StopReason::kTimeLimit},
    {"cancelled", arap::StopReason::kCancelled},
};

template <typename Enum>
const char* name_of(Enum value, Names<Enum> names) {
  for (const auto& [name, named] : names)
    if (named == value) return name;
  throw std::logic_error("a value of an enum has no name");
}

template <typename Enum>
Enum value_of(const std::string& wanted, const char* field, Names<Enum> names) {
  std::string valid;
  for (const auto& [name, value] : names) {
    if (wanted == name) return value;
    valid += std::string(valid.empty() ? "'" : ", '") + name + "'";
  }
  throw py::value_error(std::string(field) + " = '" + wanted + "', must be one of " + valid);
}

// ------------------------------------------------------------------------------------------------------ options

/// Assigns one field; the options stay as they are where the new value is not allowed.
template <typename Options, typename T>
void assign(Options& options, T Options::*field, T value) {
  Options changed = options;
  changed.*field = value;
  changed.validate();
  options = changed;
}

/// Adds a field as an attribute that is validated when it is set.
template <typename Options, typename T>
void def_field(py::class_<Options>& type, const char* name, T Options::*field, const char* doc) {
  type.def_property(
      name, [field](const Options& options) { return options.*field; },
      [field](Options& options, T value) { assign(options, field, value); }, doc);
}

/// Adds an enum as an attribute that is a string.
template <typename Options, typename Enum>
void def_enum(py::class_<Options>& type, const char* name, Enum Options::*field, Names<Enum> names, const char* doc) {
  type.def_property(
      name, [field, names](const Options& options) { return name_of(options.*field, names); },
      [field, name, names](Options& options, const std::string& value) {
        assign(options, field, value_of(value, name, names));
      },
      doc);
}

/// Sets an option. Throws a TypeError that names it if the value is of another type than the default.
void set_option(const py::object& options, const std::string& name, const py::handle& value) {
  const std::string expected = type_name(options.attr(name.c_str()));
  try {
    py::setattr(options, name.c_str(), value);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
    throw py::type_error(
        py::str("{} = {!r} is of type {}, expected {}").format(name, value, type_name(value), expected));
  }
}

/// Adds the constructor, with every attribute as a keyword, and the repr, which is a call of it.
template <typename Options>
void def_construction(py::class_<Options>& type, const char* init_doc, std::vector<const char*> attributes) {
  const std::string name = py::str(type.attr("__name__"));
  type.def(py::init([name, attributes](const py::kwargs& values) {
             const py::object options = py::cast(Options{});
             for (const auto& [key, value] : values) {
               const std::string attribute = py::str(key);
               if (std::find(attributes.begin(), attributes.end(), attribute) == attributes.end())
                 throw py::type_error(py::str("{}() got an unexpected keyword argument {!r}").format(name, key));
               set_option(options, attribute, value);
             }
             return options.cast<Options>();
           }),
           init_doc);
  type.def("__repr__", [name, attributes = std::move(attributes)](py::handle self) {
    std::string text;
    for (const char* attribute : attributes)
      text += (text.empty() ? "" : ", ") + std::string(attribute) + "=" + std::string(py::repr(self.attr(attribute)));
    return name + "(" + text + ")";
  });
}

void bind_options(py::module_& m) {
  using arap::Options;
  py::class_<Options> type(m, "Options", docstrings::Options);
  def_enum<Options, arap::Energy>(type, "energy", &Options::energy, kEnergies, docstrings::Options_energy);
  def_field(type, "rigidity_radius", &Options::rigidity_radius, docstrings::Options_rigidity_radius);
  def_enum<Options, arap::EdgeWeights>(type, "weights", &Options::weights, kWeights, docstrings::Options_weights);
  def_enum<Options, arap::LinearSolverKind>(type, "linear_solver", &Options::linear_solver, kLinearSolvers,
                                            docstrings::Options_linear_solver);
  def_field(type, "threads", &Options::threads, docstrings::Options_threads);
  def_field(type, "join_seams", &Options::join_seams, docstrings::Options_join_seams);
  def_construction(type, docstrings::Options_init,
                   {"energy", "rigidity_radius", "weights", "linear_solver", "threads", "join_seams"});
}

void bind_solve_options(py::module_& m) {
  using arap::SolveOptions;
  py::class_<SolveOptions> type(m, "SolveOptions", docstrings::SolveOptions);
  def_enum<SolveOptions, arap::InitialGuess>(type, "initial_guess", &SolveOptions::initial_guess, kInitialGuesses,
                                             docstrings::SolveOptions_initial_guess);
  def_enum<SolveOptions, arap::Acceleration>(type, "acceleration", &SolveOptions::acceleration, kAccelerations,
                                             docstrings::SolveOptions_acceleration);
  def_field(type, "max_iterations", &SolveOptions::max_iterations, docstrings::SolveOptions_max_iterations);
  def_field(type, "accuracy", &SolveOptions::accuracy, docstrings::SolveOptions_accuracy);
  def_field(type, "time_limit_s", &SolveOptions::time_limit_s, docstrings::SolveOptions_time_limit_s);
  def_construction(type, docstrings::SolveOptions_init,
                   {"initial_guess", "acceleration", "max_iterations", "accuracy", "time_limit_s"});
}

// ------------------------------------------------------------------------------------------------------- result

/// The library's result with its arrays handed over to numpy.
struct SolveResult {
  /// @param out  the array that has the positions, or None
  SolveResult(arap::SolveResult result, const py::object& out)
      : positions(out.is_none() ? to_array(std::move(result.positions)) : py::reinterpret_borrow<py::array>(out)),
        parts_at_rest(to_array(std::move(result.parts_at_rest))),
        loose_vertices(to_array(std::move(result.loose_vertices))),
        energy_before(result.energy_before),
        energy_after(result.energy_after),
        iterations(result.iterations),
        step(result.step),
        stop_reason(result.stop_reason) {}

  py::array positions, parts_at_rest, loose_vertices;
  double energy_before, energy_after;
  int iterations;
  double step;
  arap::StopReason stop_reason;
};

std::string result_repr(const SolveResult& result) {
  return py::str(
             "<SolveResult: {} after {} iterations, energy {:.6g} -> {:.6g}, step {:.2g}, {} parts at rest, {} loose "
             "vertices>")
      .format(name_of<arap::StopReason>(result.stop_reason, kStopReasons), result.iterations, result.energy_before,
              result.energy_after, result.step, result.parts_at_rest.size(), result.loose_vertices.size());
}

void bind_result(py::module_& m) {
  py::class_<SolveResult>(m, "SolveResult", docstrings::SolveResult)
      .def_readonly("positions", &SolveResult::positions, docstrings::SolveResult_positions)
      .def_readonly("energy_before", &SolveResult::energy_before, docstrings::SolveResult_energy_before)
      .def_readonly("energy_after", &SolveResult::energy_after, docstrings::SolveResult_energy_after)
      .def_readonly("iterations", &SolveResult::iterations, docstrings::SolveResult_iterations)
      .def_readonly("step", &SolveResult::step, docstrings::SolveResult_step)
      .def_property_readonly(
          "stop_reason",
          [](const SolveResult& result) { return name_of<arap::StopReason>(result.stop_reason, kStopReasons); },
          docstrings::SolveResult_stop_reason)
      .def_readonly("parts_at_rest", &SolveResult::parts_at_rest, docstrings::SolveResult_parts_at_rest)
      .def_readonly("loose_vertices", &SolveResult::loose_vertices, docstrings::SolveResult_loose_vertices)
      .def("__repr__", &result_repr);
}

// ------------------------------------------------------------------------------------------------ GIL and progress

/// Does what needs the GIL in a thread that may outlive the interpreter (a daemon thread while Python exits). Such a
/// thread has nothing left to do; it sleeps until the process ends, as Python 3.14 has it. Earlier ones unwind its
/// stack where it wants the GIL, which is terminate() where C++ destructors are on the stack: `work` has none, pure C
/// API.
template <typename Work>
std::invoke_result_t<Work> outlive_python(const Work& work) {
  const auto sleep_until_the_end = [] {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  };
  if (Py_IsInitialized() == 0) sleep_until_the_end();
#ifdef __GLIBCXX__
  try {
    return work();
  } catch (const abi::__forced_unwind&) {
    sleep_until_the_end();
    throw;  // never reached; libstdc++ asks for it
  }
#else
  return work();
#endif
}

/// The GIL is released while this lives.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  ~WithoutGil() {
    outlive_python([this] { PyEval_RestoreThread(state_); });
  }
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

 private:
  PyThreadState* state_;
};

/// Calls a Python callback from work that runs without the GIL, and lets Ctrl-C through, also without a callback.
class ProgressCall {
 public:
  explicit ProgressCall(py::object callback) : callback_(std::move(callback)) {
    if (!callback_.is_none() && PyCallable_Check(callback_.ptr()) == 0)
      throw py::type_error("progress is of type " + type_name(callback_) + ", expected a callable or None");
  }

  /// For the library. A reference: copies of a Python object need the GIL.
  arap::Progress function() {
    return [this](double fraction) { return call(fraction); };
  }

 private:
  bool call(double fraction) {
    if (callback_.ptr() == Py_None && !is_signal_check_due()) return true;
    PyGILState_STATE gil{};
    const int answer = outlive_python([&] {
      gil = PyGILState_Ensure();
      return ask(fraction);
    });
    if (answer >= 0) {
      PyGILState_Release(gil);
      return answer != 0;
    }
    const py::error_already_set error;
    PyGILState_Release(gil);
    throw py::error_already_set(error);
  }

  /// Whether to go on: 1 or 0; -1 with a Python error set.
  [[nodiscard]] int ask(double fraction) const {
    if (PyErr_CheckSignals() != 0) return -1;
    if (callback_.ptr() == Py_None) return 1;
    PyObject* answer = PyObject_CallFunction(callback_.ptr(), "d", fraction);
    if (answer == nullptr) return -1;
    const int go_on = answer == Py_None ? 1 : PyObject_IsTrue(answer);
    Py_DECREF(answer);
    return go_on;
  }

  /// Seldom: waiting for the GIL can take longer than a step of the work.
  bool is_signal_check_due() {
    constexpr std::chrono::milliseconds kInterval{100};
    const auto now = std::chrono::steady_clock::now();
    if (now - last_signal_check_ < kInterval) return false;
    last_signal_check_ = now;
    return true;
  }

  py::object callback_;
  std::chrono::steady_clock::time_point last_signal_check_ = std::chrono::steady_clock::now();
};

// --------------------------------------------------------------------------------------------------------- jobs

using arap_native::Job;

/// The jobs under way, and what must live as long as each. A job that nobody asks for any more ends by itself.
class Jobs {
 public:
  void check_open() const {
    if (is_closed_) throw std::runtime_error("Python is about to exit: no job can be begun");
  }

  void add(const std::shared_ptr<Job>& job, const py::object& kept) {
    std::erase_if(entries_, [](const Entry& entry) { return entry.job->is_done(); });
    entries_.push_back({job, kept});
  }

  /// Ends all. For Python's exit: what they use would go away below them.
  void close() {
    is_closed_ = true;
    for (const Entry& entry : entries_) entry.job->cancel();
    {
      const WithoutGil no_gil;
      for (const Entry& entry : entries_) entry.job->wait();
    }
    entries_.clear();
  }

 private:
  struct Entry {
    std::shared_ptr<Job> job;
    py::object kept;
  };
  std::vector<Entry> entries_;
  bool is_closed_ = false;
};

/// A Job for Python. Only the thread that calls it touches Python.
class JobHandle {
 public:
  /// @param result  makes the result once the job is done; called once
  JobHandle(std::shared_ptr<Job> job, std::function<py::object()> result)
      : job_(std::move(job)), make_result_(std::move(result)) {}
  ~JobHandle() { job_->cancel(); }
  JobHandle(const JobHandle&) = delete;
  JobHandle& operator=(const JobHandle&) = delete;

  [[nodiscard]] double fraction() const { return job_->fraction(); }
  [[nodiscard]] bool is_done() const { return job_->is_done(); }
  void cancel() { job_->cancel(); }

  bool wait(double timeout_s) {
    using Clock = std::chrono::steady_clock;
    constexpr double kSignalCheckS = 0.1;
    if (!(timeout_s >= 0))
      throw py::value_error(py::str("timeout_s = {}, must be 0 or more").format(timeout_s).cast<std::string>());
    const auto start = Clock::now();
    for (;;) {
      const double left = timeout_s - Job::Seconds(Clock::now() - start).count();
      if (waited_for(std::clamp(left, 0.0, kSignalCheckS))) return true;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (left <= kSignalCheckS) return false;
    }
  }

  py::object result() {
    wait(std::numeric_limits<double>::infinity());
    job_->finish();
    if (!result_) result_ = std::exchange(make_result_, nullptr)();
    return result_;
  }

  [[nodiscard]] std::string repr() const {
    return is_done() ? "<Job: done>" : py::str("<Job: {:.0%}>").format(fraction()).cast<std::string>();
  }

  static void* operator new(size_t) { throw py::type_error("this Job has no work, because only __new__ was called"); }
  static void operator delete(void* job) { ::operator delete(job); }

 private:
  [[nodiscard]] bool waited_for(double seconds) const {
    const WithoutGil no_gil;
    return job_->wait_for(Job::Seconds(seconds));
  }

  std::shared_ptr<Job> job_;
  std::function<py::object()> make_result_;
  py::object result_;
};

/// Begins a job. Its result is to_python(work(progress)), and only to_python has the GIL. `kept` lives until it is
/// done.
template <typename Work, typename ToPython>
std::unique_ptr<JobHandle> begin_job(Jobs& jobs, Work work, ToPython to_python, const py::object& kept = py::none()) {
  using Result = std::invoke_result_t<Work&, const arap::Progress&>;
  jobs.check_open();
  const auto result = std::make_shared<std::optional<Result>>();
  const auto job = Job::begin(
      [work = std::move(work), result](const arap::Progress& progress) mutable { result->emplace(work(progress)); });
  jobs.add(job, kept);
  return std::unique_ptr<JobHandle>(::new JobHandle(
      job, [result, to_python = std::move(to_python)]() mutable { return to_python(std::move(**result)); }));
}

void bind_job(py::module_& m) {
  py::class_<JobHandle>(m, "Job", docstrings::Job)
      .def_property_readonly("fraction", &JobHandle::fraction, docstrings::Job_fraction)
      .def_property_readonly("is_done", &JobHandle::is_done, docstrings::Job_is_done)
      .def("cancel", &JobHandle::cancel, docstrings::Job_cancel)
      .def("wait", &JobHandle::wait, docstrings::Job_wait,
           py::arg("timeout_s") = std::numeric_limits<double>::infinity())
      .def("result", &JobHandle::result, docstrings::Job_result)
      .def("__repr__", &JobHandle::repr);
}

// ------------------------------------------------------------------------------------------------------- solver

/// A SurfaceArap, and whether it is at work.
struct Model {
  explicit Model(arap::SurfaceArap bound) : solver(std::move(bound)) {}

  arap::SurfaceArap solver;
  std::atomic<int> n_targets = 0;
  std::atomic<bool> is_busy = false;
};

/// One call at a time on one object; a second one is refused, for waiting could take for ever (below a callback).
class Turn {
 public:
  explicit Turn(std::shared_ptr<Model> model) : model_(std::move(model)) {
    if (model_->is_busy.exchange(true)) {
      model_ = nullptr;
      throw std::runtime_error(
          "this SurfaceArap is at work in a job, in another thread or below its own progress callback: wait until that "
          "has ended, or use one SurfaceArap per thread");
    }
  }
  ~Turn() {
    if (model_ != nullptr) model_->is_busy = false;
  }
  Turn(Turn&&) noexcept = default;
  Turn& operator=(Turn&&) = delete;
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

  Model& operator*() const { return *model_; }

 private:
  std::shared_ptr<Model> model_;
};

/// What a SurfaceArap is bound to.
struct BindInput {
  MeshArrays mesh;
  arap::Options options;
  arap::SurfaceArap::VertexProperties properties;

  BindInput(const py::object& rest_positions, const py::object& corner_vertices, const py::object& face_sizes,
            const arap::Options* given, const py::object& stiffness, const py::object& rigid_regions)
      : mesh(mesh_from(rest_positions, corner_vertices, face_sizes)) {
    if (given != nullptr) options = *given;
    const Extent n = mesh.positions.rows();
    if (!stiffness.is_none())
      properties.stiffness = vector_from<double>(stiffness, "stiffness", n, "one entry per vertex");
    if (!rigid_regions.is_none())
      properties.rigid_regions = vector_from<int>(rigid_regions, "rigid_regions", n, "one entry per vertex");
  }

  /// Binds, once: takes the arrays. Needs no GIL.
  std::shared_ptr<Model> bind(const arap::Progress& progress) {
    return std::make_shared<Model>(arap::SurfaceArap(mesh_of(std::move(mesh)), options, properties, progress));
  }
};

arap::ConstraintSet constraints_from(const py::object& vertices, const py::object& strengths,
                                     const py::object& patches) {
  arap::ConstraintSet set;
  set.vertices = vector_from<int>(vertices, "vertices", "k", "one entry per constrained vertex");
  if (!strengths.is_none())
    set.strengths = vector_from<double>(strengths, "strengths", static_cast<py::ssize_t>(set.vertices.size()),
                                        "one entry per constrained vertex");
  set.patches = patches_from(patches);
  return set;
}

void set_constraints_of(Model& model, const arap::ConstraintSet& set, const arap::Progress& progress) {
  model.solver.set_constraints(set, progress);
  model.n_targets = set.size();
}

py::tuple patch_to_python(const arap::Patch& patch) {
  return py::make_tuple(to_array(patch.vertices), to_array(patch.weights),
                        to_array(std::vector<double>(patch.rest_position.begin(), patch.rest_position.end())));
}

/// arap::SurfaceArap for Python: checks arrays, then works without the GIL.
class Solver {
 public:
  static std::unique_ptr<Solver> of(std::shared_ptr<Model> model) {
    // Not make_unique: it would use the class's own new, which refuses.
    return std::unique_ptr<Solver>(::new Solver(std::move(model)));  // NOLINT(modernize-make-unique)
  }

  static std::unique_ptr<Solver> bind(BindInput input, py::object progress) {
    ProgressCall call(std::move(progress));
    const WithoutGil no_gil;
    return of(input.bind(call.function()));
  }

  static std::unique_ptr<JobHandle> begin_bind(Jobs& jobs, BindInput input) {
    return begin_job(
        jobs, [input = std::move(input)](const arap::Progress& progress) mutable { return input.bind(progress); },
        [](std::shared_ptr<Model> model) { return py::cast(of(std::move(model))); });
  }

  void set_constraints(const arap::ConstraintSet& set, py::object progress) {
    ProgressCall call(std::move(progress));
    exclusively([&](Model& model) { set_constraints_of(model, set, call.function()); });
  }

  std::unique_ptr<JobHandle> begin_set_constraints(Jobs& jobs, arap::ConstraintSet set) {
    return begin_job(
        jobs,
        [turn = Turn(model_), set = std::move(set)](const arap::Progress& progress) {
          set_constraints_of(*turn, set, progress);
          return true;
        },
        [](bool) { return py::none(); });
  }

  SolveResult solve(const py::object& targets, const arap::SolveOptions* options, const py::object& rotations,
                    py::object progress, const py::object& out) {
    const SolveInput input(*this, targets, options, rotations, out);
    ProgressCall call(std::move(progress));
    return {exclusively([&](Model& model) { return input.solve(model, call.function()); }), out};
  }

  std::unique_ptr<JobHandle> begin_solve(Jobs& jobs, const py::object& targets, const arap::SolveOptions* options,
                                         const py::object& rotations, const py::object& out) {
    return begin_job(
        jobs,
        [input = SolveInput(*this, targets, options, rotations, out),
         turn = Turn(model_)](const arap::Progress& progress) { return input.solve(*turn, progress); },
        [out](arap::SolveResult result) { return py::cast(SolveResult(std::move(result), out)); }, out);
  }

  void reset() {
    exclusively([&](Model& model) { model.solver.reset(); });
  }

  void set_positions(const py::object& positions) {
    const arap::Positions points = points_from(positions);
    exclusively([&](Model& model) { model.solver.set_positions(points); });
  }

  py::tuple patch_around(const py::object& vertices, double radius) {
    const auto indices = vector_from<int>(vertices, "vertices", "k", "one entry per vertex");
    return patch_to_python(exclusively([&](Model& model) { return model.solver.patch_around(indices, radius); }));
  }

  std::unique_ptr<JobHandle> begin_patches(Jobs& jobs, const py::object& around, const py::object& radii) {
    if (!py::isinstance<py::list>(around))
      throw py::type_error("around is of type " + type_name(around) + ", expected a list of numpy arrays of int32");
    std::vector<std::vector<int>> groups;
    for (const py::handle vertices : around)
      groups.push_back(vector_from<int>(py::reinterpret_borrow<py::object>(vertices), "an array of around", "k",
                                        "one entry per vertex"));
    auto reaches = vector_from<double>(radii, "radii", static_cast<py::ssize_t>(groups.size()), "one entry per patch");
    return begin_job(
        jobs,
        [turn = Turn(model_), groups = std::move(groups),
         reaches = std::move(reaches)](const arap::Progress& progress) {
          std::vector<arap::Patch> patches;
          for (size_t i = 0; i < groups.size(); ++i) {
            if (!progress(static_cast<double>(i) / static_cast<double>(groups.size())))
              throw arap::Cancelled("finding patches was cancelled");
            patches.push_back((*turn).solver.patch_around(groups[i], reaches[i]));
          }
          return patches;
        },
        [](const std::vector<arap::Patch>& patches) {
          py::list result;
          for (const arap::Patch& patch : patches) result.append(patch_to_python(patch));
          return result;
        });
  }

  double energy(const py::object& positions) {
    const arap::Positions points = points_from(positions);
    return exclusively([&](Model& model) { return model.solver.energy(points); });
  }

  py::array energy_gradient(const py::object& positions) {
    const arap::Positions points = points_from(positions);
    return to_array(exclusively([&](Model& model) { return model.solver.energy_gradient(points); }));
  }

  py::array positions() {
    return to_array(exclusively([](Model& model) { return model.solver.positions(); }));
  }

  int n_factorizations() {
    return exclusively([](Model& model) { return model.solver.n_factorizations(); });
  }

  // Fixed at bind: these may be read at any time.
  [[nodiscard]] py::ssize_t n_vertices() const { return model_->solver.n_vertices(); }
  [[nodiscard]] int n_parts() const { return model_->solver.n_parts(); }
  [[nodiscard]] int threads() const { return model_->solver.threads(); }
  [[nodiscard]] py::array part_of_vertex() const { return to_array(model_->solver.part_of_vertex()); }
  [[nodiscard]] py::array loose_vertices() const { return to_array(model_->solver.loose_vertices()); }

  [[nodiscard]] std::string repr() const {
    return py::str("<SurfaceArap: {} vertices, {} {}, {} {}>")
        .format(n_vertices(), n_parts(), n_parts() == 1 ? "part" : "parts", threads(),
                threads() == 1 ? "thread" : "threads");
  }

 private:
  explicit Solver(std::shared_ptr<Model> model) : model_(std::move(model)) {}

  /// What a solve is called with. Holds no Python object: whoever solves keeps `out` alive.
  class SolveInput {
   public:
    SolveInput(const Solver& solver, const py::object& targets, const arap::SolveOptions* options,
               const py::object& rotations, const py::object& out) {
      // Without constraints the library says so; any number of rows is as good then.
      const int n_targets = solver.model_->n_targets;
      const Extent rows = n_targets > 0 ? Extent(n_targets) : Extent("k + n_patches");
      targets_ = positions_from(targets, "targets", rows, "one row per constrained vertex, then one per patch");
      if (options != nullptr) options_ = *options;
      rotations_ = rotations_from(rotations, rows);
      out_ = out_from(out, solver.n_vertices());
    }

    [[nodiscard]] arap::SolveResult solve(Model& model, const arap::Progress& progress) const {
      return model.solver.solve(targets_, options_, rotations_, progress, out_);
    }

   private:
    arap::Positions targets_;
    arap::SolveOptions options_;
    std::vector<arap::Matrix3> rotations_;
    std::span<float> out_;
  };

  [[nodiscard]] arap::Positions points_from(const py::object& positions) const {
    return positions_from(positions, "positions", n_vertices(), "one row per vertex");
  }

  template <typename Work>
  std::invoke_result_t<Work, Model&> exclusively(const Work& work) {
    const Turn turn(model_);
    const WithoutGil no_gil;
    return work(*turn);
  }

  /// pybind11 asks for memory without an object in it if a script has called __new__ alone.
 public:
  static void* operator new(size_t) {
    throw py::type_error("this SurfaceArap has no mesh, because only __new__ was called: call SurfaceArap(...)");
  }
  static void operator delete(void* solver) { ::operator delete(solver); }

 private:
  std::shared_ptr<Model> model_;
};

void bind_solver(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  const py::object none = py::none();
  using Object = const py::object&;
  py::class_<Solver>(m, "SurfaceArap", docstrings::SurfaceArap)
      .def(py::init([](Object rest_positions, Object corner_vertices, Object face_sizes, const arap::Options* options,
                       Object stiffness, Object rigid_regions, py::object progress) {
             return Solver::bind({rest_positions, corner_vertices, face_sizes, options, stiffness, rigid_regions},
                                 std::move(progress));
           }),
           docstrings::SurfaceArap_init, py::arg("rest_positions"), py::arg("corner_vertices"),
           py::arg("face_sizes") = none, py::arg("options") = none, py::kw_only(), py::arg("stiffness") = none,
           py::arg("rigid_regions") = none, py::arg("progress") = none)
      .def_static(
          "begin_bind",
          [jobs](Object rest_positions, Object corner_vertices, Object face_sizes, const arap::Options* options,
                 Object stiffness, Object rigid_regions) {
            return Solver::begin_bind(*jobs,
                                      {rest_positions, corner_vertices, face_sizes, options, stiffness, rigid_regions});
          },
          docstrings::SurfaceArap_begin_bind, py::arg("rest_positions"), py::arg("corner_vertices"),
          py::arg("face_sizes") = none, py::arg("options") = none, py::kw_only(), py::arg("stiffness") = none,
          py::arg("rigid_regions") = none)
      .def(
          "set_constraints",
          [](Solver& solver, Object vertices, Object strengths, Object patches, py::object progress) {
            solver.set_constraints(constraints_from(vertices, strengths, patches), std::move(progress));
          },
          docstrings::SurfaceArap_set_constraints, py::arg("vertices"), py::arg("strengths") = none,
          py::arg("patches") = none, py::kw_only(), py::arg("progress") = none)
      .def(
          "begin_set_constraints",
          [jobs](Solver& solver, Object vertices, Object strengths, Object patches) {
            return solver.begin_set_constraints(*jobs, constraints_from(vertices, strengths, patches));
          },
          docstrings::SurfaceArap_begin_set_constraints, py::arg("vertices"), py::arg("strengths") = none,
          py::arg("patches") = none)
      .def("solve", &Solver::solve, docstrings::SurfaceArap_solve, py::arg("targets"), py::arg("options") = none,
           py::kw_only(), py::arg("rotations") = none, py::arg("progress") = none, py::arg("out") = none)
      .def(
          "begin_solve",
          [jobs](Solver& solver, Object targets, const arap::SolveOptions* options, Object rotations, Object out) {
            return solver.begin_solve(*jobs, targets, options, rotations, out);
          },
          docstrings::SurfaceArap_begin_solve, py::arg("targets"), py::arg("options") = none, py::kw_only(),
          py::arg("rotations") = none, py::arg("out") = none)
      .def("reset", &Solver::reset, docstrings::SurfaceArap_reset)
      .def("set_positions", &Solver::set_positions, docstrings::SurfaceArap_set_positions, py::arg("positions"))
      .def("patch_around", &Solver::patch_around, docstrings::SurfaceArap_patch_around, py::arg("vertices"),
           py::arg("radius") = 0.0)
      .def(
          "begin_patches",
          [jobs](Solver& solver, Object around, Object radii) { return solver.begin_patches(*jobs, around, radii); },
          docstrings::SurfaceArap_begin_patches, py::arg("around"), py::arg("radii"))
      .def("energy", &Solver::energy, docstrings::SurfaceArap_energy, py::arg("positions"))
      .def("energy_gradient", &Solver::energy_gradient, docstrings::SurfaceArap_energy_gradient, py::arg("positions"))
      .def_property_readonly("positions", &Solver::positions, docstrings::SurfaceArap_positions)
      .def_property_readonly("n_vertices", &Solver::n_vertices, docstrings::SurfaceArap_n_vertices)
      .def_property_readonly("n_parts", &Solver::n_parts, docstrings::SurfaceArap_n_parts)
      .def_property_readonly("part_of_vertex", &Solver::part_of_vertex, docstrings::SurfaceArap_part_of_vertex)
      .def_property_readonly("loose_vertices", &Solver::loose_vertices, docstrings::SurfaceArap_loose_vertices)
      .def_property_readonly("n_factorizations", &Solver::n_factorizations, docstrings::SurfaceArap_n_factorizations)
      .def_property_readonly("threads", &Solver::threads, docstrings::SurfaceArap_threads)
      .def("__repr__", &Solver::repr);
}

/// By value: pybind11 takes a pointer to such a function.
void tell_no_memory(std::exception_ptr failure) {  // NOLINT(performance-unnecessary-value-param)
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const arap::NotEnoughMemory& error) {
    PyErr_SetString(PyExc_MemoryError, error.what());
  } catch (const std::bad_alloc&) {
    PyErr_SetString(PyExc_MemoryError,
                    "there is not enough memory for this mesh; close other programs or take a coarser mesh");
  }
}

}  // namespace

PYBIND11_MODULE(_native, m) {
  py::options signatures_come_from_the_stub;
  signatures_come_from_the_stub.disable_function_signatures();

  m.doc() = docstrings::module;
  m.attr("__version__") = ARAP_VERSION;
  py::register_local_exception_translator(tell_no_memory);
  // InvalidInput and SolverError derive from the standard exceptions that pybind11 makes ValueError and RuntimeError.
  auto cancelled = py::register_exception<arap::Cancelled>(m, "Cancelled", PyExc_RuntimeError);
  cancelled.attr("__doc__") = docstrings::Cancelled;
  bind_options(m);
  bind_solve_options(m);
  bind_result(m);
  const auto jobs = std::make_shared<Jobs>();
  bind_job(m);
  bind_solver(m, jobs);
  py::module_::import("atexit").attr("register")(py::cpp_function([jobs] { jobs->close(); }));
  m.def(
      "same_places",
      [](const py::object& rest_positions, const py::object& corner_vertices, const py::object& face_sizes) {
        MeshArrays mesh = mesh_from(rest_positions, corner_vertices, face_sizes);
        std::vector<int> places;
        {
          const WithoutGil no_gil;
          places = mesh_of(std::move(mesh)).same_places();
        }
        return to_array(std::move(places));
      },
      docstrings::same_places, py::arg("rest_positions"), py::arg("corner_vertices"),
      py::arg("face_sizes") = py::none());
  // The public place, in messages and help(): the package, not this file.
  for (const char* name : {"Cancelled", "Job", "Options", "SolveOptions", "SolveResult", "SurfaceArap"})
    m.attr(name).attr("__module__") = "arap_native";
}
