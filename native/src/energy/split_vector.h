// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "arap/types.h"

namespace arap {

/// A vector to 40 binary digits, 18 bytes of numbers: floats for the passes in single precision, and what these leave,
/// which the passes in double add.
struct SplitVector {
  std::array<float, 3> high{};
  std::array<std::int16_t, 3> low{};  ///< in units of 2^-39 of the largest power of two in `high`

  SplitVector() = default;
  explicit SplitVector(const Vector3& v) {
    for (int i = 0; i < 3; ++i) {
      high[i] = static_cast<float>(v[i]);
      const double power = power_below(high[i]);
      if (!(power > 0 && std::isfinite(power))) continue;
      const double units = (v[i] - static_cast<double>(high[i])) / (kUnit * power);
      low[i] = static_cast<std::int16_t>(std::clamp(units < 0 ? units - 0.5 : units + 0.5, -32768.0, 32767.0));
    }
  }

  [[nodiscard]] Vector3 whole() const {
    Vector3 v;
    for (int i = 0; i < 3; ++i) v[i] = static_cast<double>(high[i]) + low[i] * (kUnit * power_below(high[i]));
    return v;
  }

 private:
  static constexpr double kUnit = 0x1p-39;

  /// 0 for zeros and for numbers that are too small for all digits of a float.
  static double power_below(float x) {
    constexpr std::uint32_t kExponent = 0x7f800000;
    return static_cast<double>(std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) & kExponent));
  }
};

}  // namespace arap
