#include "evaluation/metrics/confidence_interval.hpp"

#include <cassert>
#include <cmath>

namespace cornerfix::evaluation {

namespace {

constexpr double kTiny = 1e-300;  // in place of 0 in a denominator
constexpr double kPrecision = 1e-15;
constexpr int kMaxTerms = 100'000;  // about sqrt(max(a, b)) are needed
constexpr int kBisections = 60;

double away_from_zero(double value) { return std::abs(value) < kTiny ? kTiny : value; }

/// Continued fraction of the incomplete beta function, where about x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  double c = 1.0;
  double d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
  double fraction = d;
  for (int term = 1; term <= kMaxTerms; ++term) {
    const double m = term;
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    d = 1.0 / away_from_zero(1.0 + even * d);
    c = away_from_zero(1.0 + even / c);
    fraction *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    d = 1.0 / away_from_zero(1.0 + odd * d);
    c = away_from_zero(1.0 + odd / c);
    fraction *= d * c;
    if (std::abs(d * c - 1.0) < kPrecision) break;
  }
  return fraction;
}

/// I_x(a, b), where the fraction converges.
double lower_incomplete_beta(double a, double b, double x) {
  const double log_factor =
      std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x);
  return std::exp(log_factor) * beta_fraction(a, b, x) / a;
}

/// The x at which I_x(a, b), which grows with x, reaches `probability`.
double beta_quantile(double a, double b, double probability) {
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (incomplete_beta(a, b, middle) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double incomplete_beta(double a, double b, double x) {
  assert(a > 0.0 && b > 0.0 && x >= 0.0 && x <= 1.0);
  if (x <= 0.0 || x >= 1.0) return x;
  const bool converges = x < (a + 1.0) / (a + b + 2.0);
  return converges ? lower_incomplete_beta(a, b, x) : 1.0 - lower_incomplete_beta(b, a, 1.0 - x);
}

ConfidenceInterval clopper_pearson(std::size_t hits, std::size_t trials, double confidence) {
  assert(hits <= trials && confidence > 0.0 && confidence < 1.0);
  if (trials == 0) return {};
  const double tail = 0.5 * (1.0 - confidence);
  const auto k = static_cast<double>(hits);
  const auto n = static_cast<double>(trials);
  return {hits == 0 ? 0.0 : beta_quantile(k, n - k + 1.0, tail),
          hits == trials ? 1.0 : beta_quantile(k + 1.0, n - k, 1.0 - tail)};
}

}  // namespace cornerfix::evaluation
