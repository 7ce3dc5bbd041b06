#include "server/media_types.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <string>

namespace cornerfix::server {
namespace {

using api::BodyFormat;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Cuts the part before `separator` off `text`.
std::string_view next_part(std::string_view& text, char separator) {
  const auto end = text.find(separator);
  const std::string_view part = trimmed(text.substr(0, end));
  text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
  return part;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  });
  return lower;
}

std::optional<BodyFormat> format_of(std::string_view media_type) {
  const std::string type = lower_case(media_type);
  if (type == "application/json") return BodyFormat::kJson;
  if (type == "application/cbor") return BodyFormat::kCbor;
  // Registered only in 2024, after the others had been in use for years.
  const bool is_message_pack = type == "application/msgpack" || type == "application/x-msgpack" ||
                               type == "application/vnd.msgpack";
  if (is_message_pack) {
    return BodyFormat::kMessagePack;
  }
  return std::nullopt;
}

/// The weight "q" among the parameters of a media range (RFC 9110, 12.4.2).
double quality_of(std::string_view parameters) {
  while (!parameters.empty()) {
    const std::string_view parameter = next_part(parameters, ';');
    if (!parameter.starts_with("q=") && !parameter.starts_with("Q=")) continue;
    double quality = 0.0;
    std::from_chars(parameter.data() + 2, parameter.data() + parameter.size(), quality);
    return quality;
  }
  return 1.0;
}

/// The parameter `profile` of a media range.
api::AnswerProfile profile_of(std::string_view parameters) {
  constexpr std::string_view kName = "profile=";
  while (!parameters.empty()) {
    const std::string parameter = lower_case(next_part(parameters, ';'));
    if (!parameter.starts_with(kName)) continue;
    std::string name = parameter.substr(kName.size());
    std::erase(name, '"');
    return api::answer_profile_from_string(name).value_or(api::AnswerProfile::kPlain);
  }
  return api::AnswerProfile::kPlain;
}

}  // namespace

std::string media_type_of(std::string_view content_type) {
  return lower_case(next_part(content_type, ';'));
}

std::optional<BodyFormat> format_of_content_type(std::string_view content_type) {
  const std::string media_type = media_type_of(content_type);
  if (media_type.empty()) return BodyFormat::kJson;
  if (media_type == kBinaryBatchType) return BodyFormat::kBinaryBatch;
  return format_of(media_type);
}

AnswerFormat best_format(std::string_view accept) {
  AnswerFormat best;
  double best_quality = 0.0;
  while (!accept.empty()) {
    std::string_view range = next_part(accept, ',');
    const std::string_view media_range = next_part(range, ';');
    const bool any = media_range == "*/*" || media_range == "application/*";
    const auto format = any ? BodyFormat::kJson : format_of(media_range);
    const double quality = quality_of(range);
    if (format && quality > best_quality) {
      best = {*format, profile_of(range)};
      best_quality = quality;
    }
  }
  return best;
}

}  // namespace cornerfix::server
