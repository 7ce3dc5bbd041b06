/// \file  Jobs as documents.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "api/json_codec.hpp"

namespace cornerfix::api {

/// A job without its input. Times are RFC 3339.
struct JobEntry {
  std::string_view id;
  std::string_view kind;
  std::string_view map;
  std::string_view status;
  std::string_view stage;  ///< Empty before the work begins.
  double progress = 0.0;   ///< In [0, 1].
  bool is_cancelling = false;
  std::string_view created;
  std::string_view started;   ///< Empty before.
  std::string_view finished;  ///< Empty before.
  std::string_view problem;   ///< Of a job that failed: the text of a document; else empty.
  bool has_result = false;
};
[[nodiscard]] Json render_job(const JobEntry& job);
/// `next_page_token` is null on the last page.
[[nodiscard]] Json render_job_list(std::span<const JobEntry> jobs,
                                   std::optional<std::string_view> next_page_token);

}  // namespace cornerfix::api
