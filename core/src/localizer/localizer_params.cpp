#include <cornerfix/localizer_params.hpp>

#include <array>
#include <utility>

namespace cornerfix {
namespace {

constexpr std::array<std::pair<Method, std::string_view>, 3> kMethodNames{{
    {Method::kIndexed, "indexed"},
    {Method::kRma, "rma"},
    {Method::kNma, "nma"},
}};

}  // namespace

std::string_view to_string(Method method) {
  for (const auto& [value, name] : kMethodNames) {
    if (value == method) return name;
  }
  return "unknown";
}

std::optional<Method> method_from_string(std::string_view name) {
  for (const auto& [value, known] : kMethodNames) {
    if (known == name) return value;
  }
  return std::nullopt;
}

std::optional<Error> validate(const LocalizerParams& params) {
  const auto broken = [](const char* field, const char* message) {
    return Error{ErrorCode::kInvalidArgument, message, field};
  };
  if (params.paper.min_features < 3) return broken("min_features", "must be at least 3");
  if (params.paper.min_votes < 1) return broken("min_votes", "must be at least 1");
  if (params.paper.max_matches < 1 || params.paper.max_matches > 1000)
    return broken("max_matches", "must be in [1, 1000]");
  const SampledMatchParams& sampling = params.paper.sampling;
  if (!(sampling.success_probability > 0.0 && sampling.success_probability < 1.0)) {
    return broken("sampling.success_probability", "must be in (0, 1)");
  }
  if (!(sampling.overlap > 0.0 && sampling.overlap <= 1.0))
    return broken("sampling.overlap", "must be in (0, 1]");
  if (!(params.search_budget_ms > 0.0)) return broken("search_budget_ms", "must be positive");
  const AcceptanceParams& acceptance = params.acceptance;
  if (!(acceptance.min_probability > 0.0 && acceptance.min_probability < 1.0)) {
    return broken("acceptance.min_probability", "must be in (0, 1)");
  }
  if (!(acceptance.min_gap >= 0.0)) return broken("acceptance.min_gap", "must not be negative");
  if (!(acceptance.min_mean_gap >= 0.0))
    return broken("acceptance.min_mean_gap", "must not be negative");
  if (auto error = validate(params.paper.estimator)) {
    error->field = "estimator." + error->field;
    return error;
  }
  return std::nullopt;
}

}  // namespace cornerfix
