#include "server/request_body.hpp"

#include <strings.h>

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "server/body_buffer.hpp"
#include "server/connection.hpp"
#include "server/media_types.hpp"
#include "server/responses.hpp"

// Last, because its <resolv.h> defines a macro `_res` that breaks Eigen's headers after it.
#include <httplib.h>

namespace cornerfix::server {
namespace {

constexpr const char* kEmptyObject = "{}";
constexpr std::size_t kMaxArchiveBytes = std::size_t{256} << 20U;
constexpr std::size_t kMaxFormBytes = std::size_t{128} << 20U;  // A pgm of the most cells.
constexpr std::size_t kMaxFormParts = 8;

/// Reads the body as it comes over the wire. Without these headers the library neither inflates,
/// which it does without a limit, nor looks for the parts of a form.
bool read_raw(Exchange& exchange, const httplib::ContentReceiver& receiver) {
  exchange.body_was_read = true;
  exchange.raw.headers.erase("Content-Encoding");
  exchange.raw.headers.erase("Content-Type");
  return (*exchange.reader)(receiver);
}

Response too_large(std::size_t limit) {
  return problem_response(
      413, "too_large",
      "A body has at most " + std::to_string(limit) + " bytes, after decompression.");
}

/// The body, inflated; or the answer to a body that cannot be read.
std::variant<std::string, Response> read_body(Exchange& exchange, bool gzip, std::size_t limit) {
  if (exchange.framing.length > limit) return too_large(limit);
  BodyBuffer buffer(gzip, limit, exchange.framing.length);
  std::size_t received = 0;
  const bool is_complete = read_raw(exchange, [&](const char* data, std::size_t size) {
    received += size;
    // What has arrived already is read to its end, so that the connection can be kept.
    return buffer.append({data, size}) == BodyBuffer::State::kGood || received <= kMaxBufferedBody;
  });
  exchange.close |= !is_complete;
  const BodyBuffer::State state = buffer.finish();
  if (state == BodyBuffer::State::kTooLarge) return too_large(limit);
  if (!is_complete)
    return problem_response(400, "malformed", "The body ended early, or came too slowly.");
  if (state == BodyBuffer::State::kBadGzip) {
    return problem_response(400, "malformed", "The body is not gzip, or ends early.");
  }
  return buffer.take();
}

/// The parts of a form by name, read by the library, or the answer to one that cannot be read.
std::variant<std::map<std::string, std::string>, Response> read_form(Exchange& exchange,
                                                                     std::size_t limit) {
  if (exchange.framing.length > limit) return too_large(limit);
  std::map<std::string, std::string> parts;
  std::string* part = nullptr;
  std::size_t received = 0;
  bool is_too_large = false;
  bool is_repeated = false;
  exchange.body_was_read = true;
  const bool is_complete = (*exchange.reader)(
      [&](const httplib::MultipartFormData& header) {
        const auto [at, is_new] = parts.try_emplace(header.name);
        part = &at->second;
        received += header.name.size();
        is_repeated |= !is_new;
        return is_new && parts.size() <= kMaxFormParts;
      },
      [&](const char* data, std::size_t size) {
        received += size;
        is_too_large = received > limit;
        if (is_too_large) return false;
        part->append(data, size);
        return true;
      });
  exchange.close |= !is_complete;
  if (is_too_large) return too_large(limit);
  if (parts.contains("")) {
    return problem_response(400, "malformed",
                            "A part of the form has no name, expected name=\"yaml\" in double "
                            "quotes.");
  }
  if (is_repeated) return problem_response(400, "malformed", "A part is there twice.");
  if (!is_complete) return problem_response(400, "malformed", "The form cannot be read.");
  return parts;
}

Response unsupported_media_type(const std::string& content_type, BodyRule rule) {
  const std::string types =
      rule == BodyRule::kScanBatch
          ? std::string("application/json, application/cbor, application/msgpack or ") +
                kBinaryBatchType
          : "application/json, application/cbor or application/msgpack";
  std::string detail = "Send " + types + ", not " + content_type + ".";
  if (content_type.starts_with("application/x-www-form-urlencoded")) {
    detail += " (That is curl's default: add -H 'Content-Type: application/json'.)";
  }
  return problem_response(415, "unsupported_media_type", detail);
}

std::optional<Response> take_form(Exchange& exchange, std::size_t limit) {
  const bool is_form = exchange.raw.is_multipart_form_data();
  if (!is_form || exchange.raw.has_header("Content-Encoding")) {
    return problem_response(415, "unsupported_media_type",
                            "Send multipart/form-data without Content-Encoding, as curl -F does.");
  }
  auto form = read_form(exchange, limit);
  if (auto* refusal = std::get_if<Response>(&form)) return std::move(*refusal);
  exchange.request.parts = std::move(std::get<0>(form));
  return std::nullopt;
}

}  // namespace

Framing framing_of(const httplib::Request& raw) {
  if (raw.has_header("Transfer-Encoding")) return {Framing::Kind::kChunked};
  if (!raw.has_header("Content-Length")) return {};
  return {Framing::Kind::kLength, raw.get_header_value<std::uint64_t>("Content-Length")};
}

std::optional<Response> take_body(Exchange& exchange, BodyRule rule, std::size_t limit) {
  if (rule == BodyRule::kIgnored) return std::nullopt;
  if (rule == BodyRule::kOptionalDocument && !exchange.framing.has_body()) {
    exchange.request.body = kEmptyObject;
    return std::nullopt;
  }
  if (exchange.framing.kind == Framing::Kind::kNone) {
    return problem_response(411, "length_required", "A body with Content-Length is needed.");
  }
  if (rule == BodyRule::kForm) return take_form(exchange, kMaxFormBytes);
  const bool is_archive = rule == BodyRule::kArchive;
  const std::string content_type = exchange.raw.get_header_value("Content-Type");
  const auto format = is_archive ? api::BodyFormat::kJson : format_of_content_type(content_type);
  const bool is_foreign = format == api::BodyFormat::kBinaryBatch && rule != BodyRule::kScanBatch;
  if (!format || is_foreign) return unsupported_media_type(content_type, rule);
  if (is_archive && media_type_of(content_type) != kArchiveType) {
    return problem_response(415, "unsupported_media_type",
                            std::string("Send an archive as ") + kArchiveType + ".");
  }
  std::string encoding = exchange.raw.get_header_value("Content-Encoding");
  // x-gzip is an old name of gzip (RFC 9110, section 8.4.1.3).
  const bool is_gzip =
      strcasecmp(encoding.c_str(), "gzip") == 0 || strcasecmp(encoding.c_str(), "x-gzip") == 0;
  if (!is_gzip && !encoding.empty() && strcasecmp(encoding.c_str(), "identity") != 0) {
    Response response = problem_response(415, "unsupported_media_type",
                                         "Content-Encoding is gzip or none, not " + encoding + ".");
    response.headers.emplace_back("Accept-Encoding", "gzip");
    return response;
  }
  auto body = read_body(exchange, is_gzip, is_archive ? kMaxArchiveBytes : limit);
  if (auto* refusal = std::get_if<Response>(&body)) return std::move(*refusal);
  exchange.request.body_format = *format;
  exchange.request.body = std::move(std::get<std::string>(body));
  if (rule == BodyRule::kOptionalDocument && exchange.request.body.empty()) {
    exchange.request.body = kEmptyObject;
    exchange.request.body_format = api::BodyFormat::kJson;
  }
  return std::nullopt;
}

bool is_left_unread(const Exchange& exchange) {
  const bool may_still_come = exchange.framing.kind == Framing::Kind::kChunked ||
                              exchange.framing.length > kMaxBufferedBody;
  return may_still_come && !exchange.body_was_read;
}

}  // namespace cornerfix::server
