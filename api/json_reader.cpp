#include "api/json_reader.hpp"

#include <simdjson.h>

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace cornerfix::api {
namespace {

namespace ondemand = simdjson::ondemand;

/// Distinguishes JSON that cannot be parsed (throws simdjson_error) from a builder that stopped
/// (false).
bool walk(ondemand::value value, DocumentBuilder& builder);

/// simdjson refuses what does not fit its types, as 1e999; JSON has no such limit.
bool walk_unusual_number(std::string_view token, DocumentBuilder& builder) {
  try {
    return builder.number_float(nlohmann::json::parse(token).get<double>(), {});
  } catch (const nlohmann::json::out_of_range&) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    return builder.number_float(token.starts_with('-') ? -kInfinity : kInfinity, {});
  } catch (const nlohmann::json::exception&) {
    throw simdjson::simdjson_error(simdjson::NUMBER_ERROR);
  }
}

bool walk_number(ondemand::value value, DocumentBuilder& builder) {
  ondemand::number number;
  if (value.get_number().get(number) != simdjson::SUCCESS) {
    return walk_unusual_number(value.raw_json_token(), builder);
  }
  if (number.is_int64()) return builder.number_integer(number.get_int64());
  if (number.is_uint64()) return builder.number_unsigned(number.get_uint64());
  return builder.number_float(number.get_double(), {});
}

bool walk_object(ondemand::object object, DocumentBuilder& builder) {
  if (!builder.start_object(0)) return false;
  for (auto field : object) {
    std::string name(std::string_view(field.unescaped_key()));
    if (!builder.key(name) || !walk(field.value(), builder)) return false;
  }
  return builder.end_object();
}

/// Most of a request; numbers skip the events.
bool walk_ranges(ondemand::array& array, DocumentBuilder& builder) {
  for (auto element : array) {
    ondemand::value value = element.value();
    double range_m = 0.0;
    const bool is_number = value.get_double().get(range_m) == simdjson::SUCCESS;
    if (!(is_number ? builder.range(range_m) : walk(value, builder))) return false;
  }
  return builder.end_array();
}

bool walk_array(ondemand::array array, DocumentBuilder& builder) {
  if (!builder.start_array(0)) return false;
  if (builder.in_ranges()) return walk_ranges(array, builder);
  for (auto element : array) {
    if (!walk(element.value(), builder)) return false;
  }
  return builder.end_array();
}

bool walk(ondemand::value value, DocumentBuilder& builder) {
  switch (value.type()) {
    case ondemand::json_type::object:
      return walk_object(value.get_object(), builder);
    case ondemand::json_type::array:
      return walk_array(value.get_array(), builder);
    case ondemand::json_type::number:
      return walk_number(value, builder);
    case ondemand::json_type::string: {
      std::string text(std::string_view(value.get_string()));
      return builder.string(text);
    }
    case ondemand::json_type::boolean:
      return builder.boolean(value.get_bool());
    case ondemand::json_type::null:
      break;
  }
  if (!value.is_null()) throw simdjson::simdjson_error(simdjson::N_ATOM_ERROR);
  return builder.null();
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Whether one of the numbers that JSON does not have stands in `text`, in any case.
bool has_unusual_number(std::string_view text) {
  constexpr std::array<std::string_view, 3> kNames = {"nan", "inf", "infinity"};
  std::string word;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    const char c = i < text.size() ? text[i] : ' ';
    if (is_letter(c)) {
      if (word.size() <= kNames.back().size()) word.push_back(static_cast<char>(c | 0x20));
      continue;
    }
    if (c != '"' && std::ranges::find(kNames, word) != kNames.end()) return true;
    word.clear();
  }
  return false;
}

/// What a body may be that is no JSON.
std::string hint_for(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) {
    return " It begins with a byte order mark: send UTF-8 without one.";
  }
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    return " It begins with the byte order mark of UTF-16: send UTF-8 without one.";
  }
  if (text.starts_with("\x1f\x8b")) {
    return " It is packed with gzip: send Content-Encoding: gzip.";
  }
  if (has_unusual_number(text)) return " It has no NaN and no Infinity: send null.";
  return "";
}

std::string without_period(std::string text) {
  while (text.ends_with('.') || text.ends_with(' ')) text.pop_back();
  return text;
}

/// " at byte 17: ,]}" where the document stopped being JSON.
std::string place_in(const simdjson::padded_string& text, ondemand::document& document) {
  constexpr std::size_t kLongest = 20;
  const char* location = nullptr;
  if (document.current_location().get(location) != simdjson::SUCCESS) return " at its end";
  const std::string_view all = text;
  const auto at = static_cast<std::size_t>(location - all.data());
  if (at >= all.size()) return " at its end";
  std::string rest(all.substr(at, kLongest));
  const auto is_plain = [](char c) { return c >= ' ' && c <= '~'; };
  rest.erase(std::ranges::find_if_not(rest, is_plain), rest.end());
  return " at byte " + std::to_string(at) + (rest.empty() ? "" : ": " + rest);
}

bool malformed(const std::string& why, DocumentBuilder& builder) {
  return builder.fail(make_problem(ErrorCode::kMalformed, "The body is not JSON: " + why));
}

}  // namespace

bool read_json(std::string_view text, DocumentBuilder& builder) {
  const simdjson::padded_string padded(text);
  ondemand::parser parser;
  // Nothing while it is searched for strings that never end and for what is no UTF-8.
  std::optional<ondemand::document> opened;
  try {
    ondemand::document& document = opened.emplace(parser.iterate(padded));
    // A lone number or string is no request; simdjson has no generic value for it.
    if (document.is_scalar()) {
      if (!nlohmann::json::accept(text)) return malformed("it must be an object", builder);
      return builder.fail(no_object());
    }
    if (!walk(document.get_value(), builder)) return false;
    if (document.current_location().error() != simdjson::OUT_OF_BOUNDS) {
      return malformed("there is more after its end" + place_in(padded, document), builder);
    }
    return true;
  } catch (const simdjson::simdjson_error& error) {
    const std::string place = opened ? place_in(padded, *opened) : "";
    return malformed(without_period(error.what()) + place + "." + hint_for(text), builder);
  }
}

}  // namespace cornerfix::api
