#include "api/body_reader.hpp"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/binary_batch.hpp"
#include "api/json_reader.hpp"

namespace cornerfix::api {
namespace {

/// Bytes of a CBOR head's argument (RFC 8949, section 3).
std::size_t argument_bytes(unsigned additional) {
  return additional >= 24 && additional <= 27 ? std::size_t{1} << (additional - 24) : 0;
}

/// Whether a CBOR body has a string of indefinite length. nlohmann reads a chunk of such a string
/// by recursion, so that a body of 0x7f bytes would end the stack; nobody sends them.
bool has_indefinite_string(std::string_view body) {
  std::size_t at = 0;
  while (at < body.size()) {
    const auto head = static_cast<std::uint8_t>(body[at++]);
    const unsigned major = head >> 5U;
    const unsigned additional = head & 0x1FU;
    const bool is_string = major == 2 || major == 3;
    if (is_string && additional == 31) return true;
    const std::size_t bytes = argument_bytes(additional);
    if (bytes > body.size() - at) return false;
    std::uint64_t argument = additional;
    if (bytes > 0) argument = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      argument = argument << 8U | static_cast<std::uint8_t>(body[at++]);
    }
    if (!is_string) continue;
    if (argument > body.size() - at) return false;
    at += static_cast<std::size_t>(argument);
  }
  return false;
}

bool read_binary(std::string_view body, nlohmann::json::input_format_t format,
                 DocumentBuilder& builder) {
  return nlohmann::json::sax_parse(body, &builder, format);
}

bool read(std::string_view body, BodyFormat format, DocumentBuilder& builder) {
  if (format == BodyFormat::kJson) return read_json(body, builder);
  if (format == BodyFormat::kBinaryBatch) return read_binary_batch(body, builder);
  if (format == BodyFormat::kMessagePack) {
    return read_binary(body, nlohmann::json::input_format_t::msgpack, builder);
  }
  if (has_indefinite_string(body)) {
    return builder.fail(
        make_problem(ErrorCode::kMalformed, "Strings of indefinite length are not accepted."));
  }
  return read_binary(body, nlohmann::json::input_format_t::cbor, builder);
}

}  // namespace

std::variant<Document, Problem> read_body(std::string_view body, BodyFormat format,
                                          const RequestLimits& limits) {
  if (body.empty()) return make_problem(ErrorCode::kMalformed, "The body is empty.");
  DocumentBuilder builder(limits);
  if (!read(body, format, builder)) {
    return builder.problem().value_or(make_problem(ErrorCode::kMalformed, "Cannot be read."));
  }
  Document document = std::move(builder).take();
  if (!document.root.is_object()) {
    return no_object();
  }
  return document;
}

}  // namespace cornerfix::api
