// SPDX-License-Identifier: GPL-3.0-or-later
// The Python module arap_native._native: arrays in and out, names for the enums, the GIL. Nothing is computed here.
#include <pybind11/pybind11.h>

#include <exception>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "arrays.h"
#include "bound_model.h"
#include "cage_deformation.h"
#include "docstrings.h"
#include "extra_models.h"
#include "gil.h"
#include "inputs.h"
#include "job_handle.h"
#include "options.h"
#include "progress_call.h"
#include "result.h"
#include "signature.h"
#include "wrap_deformation.h"

namespace arap_native {

namespace {

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

std::vector<int> places_of(MeshArrays mesh, const py::object& progress) {
  constexpr int kThreads = 1;
  ProgressCall call(progress);
  const WithoutGil no_gil;
  return mesh_of(std::move(mesh)).same_places(kThreads, call.function());
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
  bind_lattice_options(m);
  bind_cage_options(m);
  bind_wrap_options(m);
  bind_solve_options(m);
  bind_result(m);
  const auto jobs = std::make_shared<Jobs>();
  bind_job(m);
  bind_model(m, jobs);
  bind_surface_arap(m, jobs);
  bind_lattice_arap(m, jobs);
  bind_cage_deformation(m, jobs);
  bind_wrap_deformation(m, jobs);
#ifdef ARAP_EXTRA_MODELS
  bind_extra_models(m, jobs);
  m.attr("has_extra_models") = true;
#else
  m.attr("has_extra_models") = false;
#endif
  py::module_::import("atexit").attr("register")(py::cpp_function([jobs] { jobs->close(); }));
  def(m, docstrings::same_places,
      [](const py::object& rest_positions, const py::object& faces, const py::object& face_sizes,
         const py::object& progress) {
        return to_array(places_of(mesh_from(rest_positions, faces, face_sizes), progress));
      });
  // The public place, in messages and help(): the package, not this file.
  for (const char* name :
       {"CageDeformation", "CageOptions", "Cancelled", "Job", "LatticeArap", "LatticeOptions", "Model", "Options",
        "SolveOptions", "SolveResult", "SurfaceArap", "WrapDeformation", "WrapOptions", "WrapSurface"})
    m.attr(name).attr("__module__") = "arap_native";
}

}  // namespace arap_native
