#include "api/document_builder.hpp"

#include <simdjson.h>
#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

namespace cornerfix::api {
namespace {

constexpr double kNoReturn = std::numeric_limits<double>::quiet_NaN();
/// Room for the first scan's ranges before its size is known.
constexpr std::size_t kUsualBeams = 1081;

Problem too_large(std::string pointer, const std::string& detail) {
  Problem problem = make_problem(ErrorCode::kTooLarge, pointer + ": " + detail);
  problem.errors.push_back({std::move(pointer), detail});
  return problem;
}

/// ": CBOR value: invalid byte: 0xF7" of a message of the library; empty for another message.
std::string reason_of(std::string_view message) {
  constexpr std::string_view kFront = "syntax error while parsing ";
  const auto found = message.find(kFront);
  if (found == std::string_view::npos) return "";
  std::string reason = ": " + std::string(message.substr(found + kFront.size()));
  if (reason.find("CBOR value: invalid byte") == std::string::npos) return reason;
  return reason + ", where tags and undefined are not read";
}

}  // namespace

Problem no_object() {
  Problem problem = make_problem(ErrorCode::kInvalidArgument, "The body must be an object.");
  problem.errors.push_back({"", "must be an object"});
  return problem;
}

bool DocumentBuilder::null() {
  if (in_ranges()) return range(kNoReturn);
  return leaf(nullptr);
}

bool DocumentBuilder::boolean(bool value) { return leaf(value); }

bool DocumentBuilder::number_integer(std::int64_t value) {
  return in_ranges() ? range(static_cast<double>(value)) : leaf(value);
}

bool DocumentBuilder::number_unsigned(std::uint64_t value) {
  return in_ranges() ? range(static_cast<double>(value)) : leaf(value);
}

bool DocumentBuilder::number_float(double value, const std::string& /*token*/) {
  return in_ranges() ? range(value) : leaf(value);
}

bool DocumentBuilder::string(std::string& value) {
  if (!simdjson::validate_utf8(value)) {
    return fail(make_problem(ErrorCode::kMalformed, "A string is not valid UTF-8."));
  }
  return leaf(std::move(value));
}

bool DocumentBuilder::binary(nlohmann::json::binary_t& value) {
  return leaf(nlohmann::json::binary(std::move(value)));
}

bool DocumentBuilder::start_object(std::size_t /*size*/) { return open(nlohmann::json::object()); }

bool DocumentBuilder::key(std::string& name) {
  if (aside_ != Aside::kNothing) return true;
  if (!simdjson::validate_utf8(name)) {
    return fail(make_problem(ErrorCode::kMalformed, "A member's name is not valid UTF-8."));
  }
  if (open_.back()->contains(name)) {
    return fail(make_problem(ErrorCode::kMalformed,
                             "The member \"" + name + "\" is there twice in one object."));
  }
  keys_.back() = std::move(name);
  return true;
}

bool DocumentBuilder::end_object() { return close(); }

bool DocumentBuilder::start_array(std::size_t /*size*/) {
  const Aside aside = aside_ == Aside::kNothing ? aside_for_array() : Aside::kNothing;
  if (!open(nlohmann::json::array())) return false;
  if (aside == Aside::kNothing) return true;
  aside_ = aside;
  aside_depth_ = 1;
  if (aside == Aside::kRanges) start_ranges(open_[1]->size() - 1);
  return true;
}

bool DocumentBuilder::end_array() { return close(); }

bool DocumentBuilder::parse_error(std::size_t position, const std::string& /*token*/,
                                  const nlohmann::json::exception& error) {
  return fail(make_problem(ErrorCode::kMalformed, "The body cannot be read from byte " +
                                                      std::to_string(position) +
                                                      reason_of(error.what()) + "."));
}

bool DocumentBuilder::fail(Problem problem) {
  problem_ = std::move(problem);
  return false;
}

bool DocumentBuilder::leaf(nlohmann::json value) {
  if (aside_ == Aside::kNothing) return add(std::move(value));
  return in_ranges() ? wrong_range() : true;
}

bool DocumentBuilder::open(nlohmann::json empty) {
  if (open_.size() + aside_depth_ >= kMaxDepth) {
    return fail(make_problem(ErrorCode::kMalformed, "The body is nested deeper than " +
                                                        std::to_string(kMaxDepth) + " levels."));
  }
  if (aside_ != Aside::kNothing) {
    if (in_ranges() && !wrong_range()) return false;
    ++aside_depth_;
    return true;
  }
  if (!add(std::move(empty))) return false;
  open_.push_back(last_);
  keys_.emplace_back();
  return true;
}

bool DocumentBuilder::close() {
  if (aside_ != Aside::kNothing && --aside_depth_ > 0) return true;
  if (aside_ == Aside::kRanges) max_values_ += ranges_->size() / kRangesPerValue;
  aside_ = Aside::kNothing;
  open_.pop_back();
  keys_.pop_back();
  return true;
}

bool DocumentBuilder::add(nlohmann::json value) {
  if (++values_ > max_values_) {
    return fail(make_problem(
        ErrorCode::kTooLarge,
        "The body has more than " + std::to_string(max_values_) + " values, ranges not counted."));
  }
  if (open_.empty()) {
    document_.root = std::move(value);
    last_ = &document_.root;
    return true;
  }
  nlohmann::json& parent = *open_.back();
  if (parent.is_object()) {
    last_ = &(parent[keys_.back()] = std::move(value));
    return true;
  }
  if (in_scans() && parent.size() >= limits_.max_scans) {
    return fail(too_large("/scans", "more than " + std::to_string(limits_.max_scans) +
                                        " scans in one batch are not accepted"));
  }
  parent.push_back(std::move(value));
  last_ = &parent.back();
  return true;
}

void DocumentBuilder::start_ranges(std::size_t scan) {
  const std::size_t beams = ranges_ != nullptr ? ranges_->size() : kUsualBeams;
  document_.ranges.resize(scan + 1);
  ranges_ = &document_.ranges.back();
  ranges_->reserve(std::min(beams, limits_.max_beams));
}

bool DocumentBuilder::too_many_beams() {
  return fail(
      too_large("/scans/" + std::to_string(document_.ranges.size() - 1) + "/ranges",
                "more than " + std::to_string(limits_.max_beams) + " beams are not accepted"));
}

bool DocumentBuilder::wrong_range() {
  const std::string scan = std::to_string(document_.ranges.size() - 1);
  const std::string beam = std::to_string(ranges_->size());
  document_.errors.add("/scans/" + scan + "/ranges/" + beam,
                       "must be a number of metres, or null for no return");
  return range(kNoReturn);
}

bool DocumentBuilder::in_scans() const {
  return open_.size() == 2 && keys_[0] == "scans" && open_[1]->is_array();
}

DocumentBuilder::Aside DocumentBuilder::aside_for_array() const {
  const bool in_a_scan =
      open_.size() == 3 && keys_[0] == "scans" && open_[1]->is_array() && open_[2]->is_object();
  if (!in_a_scan) return Aside::kNothing;
  if (keys_[2] == "ranges") return Aside::kRanges;
  return keys_[2] == "intensities" ? Aside::kIgnored : Aside::kNothing;
}

}  // namespace cornerfix::api
