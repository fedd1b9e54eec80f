// SPDX-License-Identifier: GPL-3.0-or-later
#include "optimize/drag_predictor.h"

#include <algorithm>

#include "optimize/row_grain.h"
#include "parallel/parallel.h"

namespace arap {

double DragPredictor::share(const Positions& step) const {
  // Above 1 what is ahead grows from frame to frame; a drag that gets faster needs a little of it.
  constexpr double kMost = 1.5;
  if (step.rows() == 0 || step.rows() != last_step_.rows()) return 0;
  const double length_squared = last_step_.squaredNorm();
  if (!(length_squared > 0)) return 0;
  return std::clamp(last_step_.cwiseProduct(step).sum() / length_squared, -kMost, kMost);
}

void DragPredictor::add_to(Positions& residual, double share, const Workers& workers) const {
  parallel_for<kRows>(workers, static_cast<int>(residual.rows()), [&](int begin, int end) {
    residual.middleRows(begin, end - begin) += share * change_.middleRows(begin, end - begin).cast<double>();
  });
}

void DragPredictor::observe(const Positions& residual, double share, const Workers& workers) {
  observed_.resize(residual.rows(), 3);
  parallel_for<kRows>(workers, static_cast<int>(residual.rows()), [&](int begin, int end) {
    const int n = end - begin;
    if (share == 0)
      observed_.middleRows(begin, n) = residual.middleRows(begin, n).cast<float>();
    else
      observed_.middleRows(begin, n) =
          residual.middleRows(begin, n).cast<float>() + static_cast<float>(share) * change_.middleRows(begin, n);
  });
}

void DragPredictor::learn(const Positions& step, const Workers& workers) {
  const bool is_finite = parallel_all<kRows>(workers, static_cast<int>(observed_.rows()), [&](int begin, int end) {
    return observed_.middleRows(begin, end - begin).allFinite();
  });
  if (!is_finite) {
    forget();
    return;
  }
  last_step_ = step;
  change_.swap(observed_);
}

}  // namespace arap
