// SPDX-License-Identifier: GPL-3.0-or-later
#include "job_handle.h"

#include "docstrings.h"

namespace arap_native {

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

}  // namespace arap_native
