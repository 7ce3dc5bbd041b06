/// \file  Runs the command line in this process and keeps what it prints.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/command_line.hpp"
#include "support/temporary_directory.hpp"

namespace cornerfix::cli {

struct Outcome {
  int exit_code = 0;
  std::string out;
  std::string err;
};

inline Outcome run(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv = {"cornerfix"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.exit_code = run_command_line(static_cast<int>(argv.size()), argv.data());
  outcome.out = ::testing::internal::GetCapturedStdout();
  outcome.err = ::testing::internal::GetCapturedStderr();
  return outcome;
}

inline constexpr const char* kLogHeader =
    R"({"name": "walk", "beams": 2, "angle_min": 0, "angle_increment": 1, )"
    R"("range_min": 0.1, "range_max": 9})"
    "\n";

/// Scans a metre apart; the poses of key scans only where they are marked.
inline std::string walk(int scans, bool with_key_scans = false) {
  std::string text = kLogHeader;
  for (int i = 0; i < scans; ++i) {
    const std::string number = std::to_string(i);
    text += R"({"t": )" + number + R"(, "ranges": [1, null], "odom": [)" + number +
            R"(, 0, 0], "pose": [)" + number + ", 0, 0]" +
            (with_key_scans && i % 3 == 0 ? R"(, "kf": 1)" : "") + "}\n";
  }
  return text;
}

}  // namespace cornerfix::cli
