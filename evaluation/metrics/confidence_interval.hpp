/// \file  Confidence intervals of measured proportions.
#pragma once

#include <cstddef>

namespace cornerfix::evaluation {

/// Lower and upper bound of a proportion, in [0, 1].
struct ConfidenceInterval {
  double lower = 0.0;
  double upper = 1.0;
};

/// The exact two-sided interval of Clopper and Pearson (1934) for `hits` in `trials` independent
/// trials. Without trials the interval is [0, 1]. Accurate to 1e-9. `confidence` is in (0, 1) and
/// `hits` is at most `trials` (asserted).
[[nodiscard]] ConfidenceInterval clopper_pearson(std::size_t hits, std::size_t trials,
                                                 double confidence = 0.95);

/// The regularised incomplete beta function I_x(a, b), by the continued fraction of Lentz (Press et
/// al., Numerical Recipes, 6.4). a > 0, b > 0, x in [0, 1] (asserted).
[[nodiscard]] double incomplete_beta(double a, double b, double x);

}  // namespace cornerfix::evaluation
