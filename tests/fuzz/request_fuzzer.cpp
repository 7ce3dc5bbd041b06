// Any bytes are requests of a connection, or none. The first byte says in what pieces they arrive;
// the outcome is the same as when all arrive at once. What is handed on to the HTTP library leaves
// no doubt about where a request ends.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "server/request_receiver.hpp"

namespace {

using cornerfix::server::RequestReceiver;
using State = RequestReceiver::State;

constexpr std::size_t kMaxRequests = 20;

void require(bool condition) {
  if (!condition) std::abort();
}

std::size_t count_of(std::string_view text, std::string_view part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// What came of the requests of a connection.
struct Outcome {
  std::vector<std::string> texts;
  State last = State::kHead;
  int status = 0;
  friend bool operator==(const Outcome&, const Outcome&) = default;
};

void check_text(RequestReceiver& receiver, std::string_view text) {
  const auto end = text.find("\r\n\r\n");
  require(end != text.npos);
  const std::string_view head = text.substr(0, end + 2);
  require(count_of(head, "\n") == count_of(head, "\r\n"));
  require(head.find('\0') == head.npos);
  for (const char* folded : {"\r\n ", "\r\n\t"}) require(head.find(folded) == head.npos);
  using cornerfix::server::Framing;
  const Framing& framing = receiver.head().framing;
  if (framing.kind == Framing::Kind::kLength) require(text.size() - end - 4 == framing.length);
  if (framing.kind == Framing::Kind::kNone) require(text.size() == end + 4);
  if (framing.kind == Framing::Kind::kChunked) require(text.ends_with("0\r\n\r\n"));
}

Outcome outcome_of(std::string_view bytes, std::size_t piece) {
  Outcome outcome;
  RequestReceiver receiver;
  while (!bytes.empty() && outcome.texts.size() < kMaxRequests) {
    std::string_view rest = bytes.substr(0, piece);
    const std::size_t given = rest.size();
    outcome.last = receiver.take(rest);
    bytes.remove_prefix(given - rest.size());
    if (outcome.last == State::kRefused) {
      outcome.status = receiver.refusal().status;
      require(outcome.status >= 400 && outcome.status < 600 && !receiver.refusal().detail.empty());
      return outcome;
    }
    if (outcome.last == State::kComplete) {
      outcome.texts.push_back(receiver.take_text());
      check_text(receiver, outcome.texts.back());
      receiver = RequestReceiver();
    } else {
      require(rest.empty());
    }
  }
  return outcome;
}

/// Chunks are handed on as they come, so only their data can be compared.
std::string without_chunk_sizes(const Outcome& outcome) {
  std::string all;
  for (const std::string& text : outcome.texts) all += text.substr(0, text.find("\r\n\r\n"));
  return all + std::to_string(outcome.texts.size()) + " " + std::to_string(outcome.status);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const Outcome whole = outcome_of(bytes, bytes.size() + 1);
  const Outcome pieces = outcome_of(bytes, std::size_t{1} + data[0] % 64U);
  require(without_chunk_sizes(whole) == without_chunk_sizes(pieces));
  return 0;
}
