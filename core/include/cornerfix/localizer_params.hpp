/// \file  All settings of a localizer in one struct, a nested struct a stage.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <cornerfix/descriptor_matcher.hpp>
#include <cornerfix/pose_estimator.hpp>
#include <cornerfix/result.hpp>
#include <cornerfix/vfp_corners.hpp>

namespace cornerfix {

/// Where hypotheses come from. Names on the wire: to_string().
enum class Method {
  kRma,  ///< The paper's random match.
  kNma,  ///< The paper's naive match: every local against every global descriptor.
};

[[nodiscard]] std::string_view to_string(Method method);
[[nodiscard]] std::optional<Method> method_from_string(std::string_view name);

struct LocalizerParams {
  Method method = Method::kRma;
  std::uint64_t seed = 1;  ///< Of all random draws.
};

[[nodiscard]] std::optional<Error> validate(const LocalizerParams& params);

}  // namespace cornerfix
