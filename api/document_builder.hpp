/// \file  Builds a request's document from parse events of any format.
///
/// Speaks nlohmann's SAX interface. The numbers of /scans/*/ranges never become JSON values: they
/// go straight into float arrays, because they are nearly all of a request. Nesting, number of
/// values, scans and beams are bounded while parsing, so no body can make it take much memory.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/problem.hpp"
#include "api/requests.hpp"

namespace cornerfix::api {

/// A body as read, not yet validated.
// NOLINTNEXTLINE(bugprone-exception-escape): moving a nlohmann::json only asserts.
struct Document {
  nlohmann::json root;
  /// By scan. Where the body has an array `ranges`, `root` has an empty one in its place and the
  /// values are here; null is NaN.
  std::vector<std::vector<float>> ranges;
  FieldErrors errors;  ///< Values inside of `ranges` that are neither number nor null.
};

/// A body that can be read but is no object.
[[nodiscard]] Problem no_object();

class DocumentBuilder {
 public:
  static constexpr std::size_t kMaxDepth = 16;
  static constexpr std::size_t kMaxValues = 500'000;  ///< Without ranges.
  /// So many ranges allow one value more: as many as a scan of 360 beams has with odometry and
  /// pose. They take as much memory as such a value, so a body still takes little more than its
  /// ranges.
  static constexpr std::size_t kRangesPerValue = 32;

  explicit DocumentBuilder(const RequestLimits& limits) : limits_(limits) {}

  // Events; false: stop, problem() says why.
  bool null();
  bool boolean(bool value);
  bool number_integer(std::int64_t value);
  bool number_unsigned(std::uint64_t value);
  bool number_float(double value, const std::string& token);
  bool string(std::string& value);
  bool binary(nlohmann::json::binary_t& value);
  bool start_object(std::size_t size);
  bool key(std::string& name);
  bool end_object();
  bool start_array(std::size_t size);
  bool end_array();
  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::json::exception& error);

  /// Whether a number would be the range of a beam; range() takes it faster than an event.
  [[nodiscard]] bool in_ranges() const { return aside_ == Aside::kRanges && aside_depth_ == 1; }
  bool range(double value_m) {
    if (ranges_->size() >= limits_.max_beams) return too_many_beams();
    ranges_->push_back(to_float(value_m));
    return true;
  }

  /// Gives up with `problem`; false, so that an event can return it.
  bool fail(Problem problem);
  [[nodiscard]] const std::optional<Problem>& problem() const { return problem_; }
  /// After the last event, without a problem.
  [[nodiscard]] Document take() && { return std::move(document_); }

 private:
  /// Arrays of a scan that do not go into the document's root.
  enum class Aside { kNothing, kRanges, kIgnored };

  bool leaf(nlohmann::json value);
  bool open(nlohmann::json empty);
  bool close();
  bool add(nlohmann::json value);
  void start_ranges(std::size_t scan);
  bool wrong_range();
  bool too_many_beams();
  [[nodiscard]] bool in_scans() const;
  [[nodiscard]] Aside aside_for_array() const;

  /// What no float can hold is no return; the cast would be undefined.
  static float to_float(double value) {
    constexpr double kMost = std::numeric_limits<float>::max();
    return std::abs(value) <= kMost ? static_cast<float>(value)
                                    : std::numeric_limits<float>::quiet_NaN();
  }

  RequestLimits limits_;
  Document document_;
  std::vector<float>* ranges_ = nullptr;  ///< Of the scan being read.
  std::vector<nlohmann::json*> open_;     ///< From the root to the innermost open container.
  std::vector<std::string> keys_;         ///< Of `open_`, the key read last; empty in arrays.
  nlohmann::json* last_ = nullptr;        ///< The value added last.
  std::size_t values_ = 0;
  std::size_t max_values_ = kMaxValues;
  Aside aside_ = Aside::kNothing;
  std::size_t aside_depth_ = 0;  ///< 1 in the array itself, more in containers within.
  std::optional<Problem> problem_;
};

}  // namespace cornerfix::api
