#include <cornerfix/localizer_params.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>

namespace cornerfix {
namespace {

/// The field that validate() names after a change of the defaults.
template <typename Change>
std::string broken_field(const Change& change) {
  LocalizerParams params;
  change(params);
  const std::optional<Error> error = validate(params);
  return error ? error->field : "";
}

TEST(LocalizerParams, DefaultsAreValid) { EXPECT_FALSE(validate(LocalizerParams{})); }

TEST(LocalizerParams, NamesOfMethodsLeadBackToThem) {
  for (const Method method : {Method::kIndexed, Method::kRma, Method::kNma})
    EXPECT_EQ(method_from_string(to_string(method)), method);
  EXPECT_FALSE(method_from_string("Indexed"));
}

TEST(LocalizerParams, ErrorsNameTheField) {
  EXPECT_EQ(broken_field([](auto& p) { p.paper.min_features = 2; }), "min_features");
  EXPECT_EQ(broken_field([](auto& p) { p.paper.min_votes = 0; }), "min_votes");
  EXPECT_EQ(broken_field([](auto& p) { p.search_budget_ms = 0.0; }), "search_budget_ms");
  EXPECT_EQ(broken_field([](auto& p) { p.paper.max_matches = 0; }), "max_matches");
  EXPECT_EQ(broken_field([](auto& p) { p.paper.sampling.overlap = 0.0; }), "sampling.overlap");
  EXPECT_EQ(broken_field([](auto& p) { p.paper.sampling.success_probability = 1.0; }),
            "sampling.success_probability");
  EXPECT_EQ(broken_field([](auto& p) { p.paper.estimator.min_inliers = 1; }),
            "estimator.min_inliers");
  EXPECT_EQ(broken_field([](auto& p) { p.acceptance.min_probability = 1.0; }),
            "acceptance.min_probability");
  EXPECT_EQ(broken_field([](auto& p) { p.acceptance.min_gap = -1.0; }), "acceptance.min_gap");
  EXPECT_EQ(broken_field([](auto& p) { p.acceptance.min_mean_gap = -0.1; }),
            "acceptance.min_mean_gap");
}

TEST(LocalizerParams, NotANumberIsNeverValid) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(broken_field([&](auto& p) { p.paper.sampling.overlap = nan; }), "sampling.overlap");
  EXPECT_EQ(broken_field([&](auto& p) { p.acceptance.min_gap = nan; }), "acceptance.min_gap");
}

}  // namespace
}  // namespace cornerfix
