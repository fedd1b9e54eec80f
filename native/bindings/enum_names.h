// SPDX-License-Identifier: GPL-3.0-or-later
// The names of the enums in Python, and back.
#pragma once

#include <pybind11/pybind11.h>

#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "arap/cage.h"
#include "arap/cage_arap.h"
#include "arap/embedded_deformation.h"
#include "arap/options.h"
#include "arap/poisson_editing.h"
#include "arap/surface_arap.h"
#include "signature.h"

namespace arap_native {

namespace py = pybind11;

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
constexpr std::pair<const char*, arap::InitialGuess> kInitialGuesses[] = {
    {"previous", arap::InitialGuess::kPrevious},
    {"rest", arap::InitialGuess::kRest},
    {"naive_laplacian", arap::InitialGuess::kNaiveLaplacian},
    {"handle_rotations", arap::InitialGuess::kHandleRotations},
};
constexpr std::pair<const char*, arap::Acceleration> kAccelerations[] = {
    {"conjugate_gradients", arap::Acceleration::kConjugateGradients}, {"none", arap::Acceleration::kNone}};
constexpr std::pair<const char*, arap::Propagation> kPropagations[] = {{"harmonic", arap::Propagation::kHarmonic},
                                                                       {"geodesic", arap::Propagation::kGeodesic}};
constexpr std::pair<const char*, arap::GraphNodes> kGraphNodes[] = {{"affine", arap::GraphNodes::kAffine},
                                                                    {"rigid", arap::GraphNodes::kRigid}};
constexpr std::pair<const char*, arap::GraphWeights> kGraphWeights[] = {{"smooth", arap::GraphWeights::kSmooth},
                                                                        {"nearest", arap::GraphWeights::kNearest}};
constexpr std::pair<const char*, arap::CageCoordinates> kCageCoordinates[] = {
    {"mean_value", arap::CageCoordinates::kMeanValue},
    {"green", arap::CageCoordinates::kGreen},
    {"harmonic", arap::CageCoordinates::kHarmonic},
};
constexpr std::pair<const char*, arap::CageEnergy> kCageEnergies[] = {{"mesh", arap::CageEnergy::kMesh},
                                                                      {"cage", arap::CageEnergy::kCage}};
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
Enum value_of(const py::object& wanted, const char* field, Names<Enum> names) {
  if (!py::isinstance<py::str>(wanted)) throw wrong_type(field, wanted, "str");
  std::string valid;
  for (const auto& [name, value] : names) {
    if (PyUnicode_CompareWithASCIIString(wanted.ptr(), name) == 0) return value;
    valid += std::string(valid.empty() ? "'" : ", '") + name + "'";
  }
  throw py::value_error(std::string(field) + " = " + shown(wanted) + ", must be one of " + valid);
}

}  // namespace arap_native
