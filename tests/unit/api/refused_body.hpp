/// \file  Cases of bodies that are refused, by table: each gets its status, and where one member is
/// wrong, its pointer.
///
/// The tables are literals: temporary strings would make a file take minutes to compile.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "api/requests.hpp"
#include "unit/api/scan_text.hpp"

namespace cornerfix::api {

struct Case {
  const char* name;
  const char* body;  ///< Or a part of it, see the fixture.
  int status;
  const char* pointer = nullptr;  ///< Of one of the errors.
};

inline void PrintTo(const Case& c, std::ostream* os) { *os << c.name << ": " << c.body; }

inline std::string case_name(const ::testing::TestParamInfo<Case>& tested) {
  return tested.param.name;
}

[[nodiscard]] inline bool points_at(const Problem& problem, const std::string& pointer) {
  return std::any_of(problem.errors.begin(), problem.errors.end(),
                     [&](const FieldError& error) { return error.pointer == pointer; });
}

template <typename Request>
void expect_problem(const Parsed<Request>& parsed, int status, const char* pointer = nullptr) {
  const auto* problem = std::get_if<Problem>(&parsed);
  ASSERT_NE(problem, nullptr) << "was taken";
  EXPECT_EQ(problem->status, status) << render(*problem);
  EXPECT_FALSE(problem->detail.empty());
  if (pointer != nullptr) {
    EXPECT_TRUE(points_at(*problem, pointer)) << render(*problem);
  }
}

[[nodiscard]] inline std::string repeat(const std::string& text, std::size_t times) {
  std::string out;
  for (std::size_t i = 0; i < times; ++i) out += text;
  return out;
}

inline const std::string kScan = R"({"stamp": 1, "ranges": [1, 2, 3]})";

[[nodiscard]] inline Parsed<SessionScansRequest> parse_batch(const std::string& body) {
  return parse_session_scans(body, BodyFormat::kJson, three_beam_lidar(), {});
}

}  // namespace cornerfix::api
