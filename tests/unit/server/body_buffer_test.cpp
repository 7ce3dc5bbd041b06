#include "server/body_buffer.hpp"

#include <gmock/gmock.h>

#include "support/gzip.hpp"

namespace cornerfix::server {
namespace {

using BufferState = BodyBuffer::State;
using testing::gzipped;

constexpr std::size_t kLimit = 1000;

/// Feeds `body` in pieces of `piece` bytes.
BufferState feed(BodyBuffer& buffer, std::string_view body, std::size_t piece) {
  for (std::size_t at = 0; at < body.size(); at += piece) buffer.append(body.substr(at, piece));
  return buffer.finish();
}

TEST(BodyBuffer, KeepsAPlainBodyOfTheLimit) {
  BodyBuffer buffer(false, kLimit);
  EXPECT_EQ(feed(buffer, std::string(kLimit, 'x'), 7), BufferState::kGood);
  EXPECT_EQ(buffer.take(), std::string(kLimit, 'x'));
}

TEST(BodyBuffer, RefusesOneByteMore) {
  BodyBuffer buffer(false, kLimit);
  EXPECT_EQ(feed(buffer, std::string(kLimit + 1, 'x'), 7), BufferState::kTooLarge);
}

TEST(BodyBuffer, InflatesHoweverTheBodyIsCut) {
  const std::string text = R"({"scans": [1, 2, 3]})";
  for (const std::size_t piece : {1U, 3U, 1000U}) {
    BodyBuffer buffer(true, kLimit);
    EXPECT_EQ(feed(buffer, gzipped(text), piece), BufferState::kGood);
    EXPECT_EQ(buffer.take(), text);
  }
}

TEST(BodyBuffer, InflatesSeveralMembers) {
  BodyBuffer buffer(true, kLimit);
  EXPECT_EQ(feed(buffer, gzipped("ab") + gzipped("cd"), 5), BufferState::kGood);
  EXPECT_EQ(buffer.take(), "abcd");
}

TEST(BodyBuffer, LimitsWhatComesOutNotWhatGoesIn) {
  const std::string bomb = gzipped(std::string(10'000'000, '\0'));
  ASSERT_LT(bomb.size(), 20'000U);
  BodyBuffer buffer(true, 20'000);
  EXPECT_EQ(feed(buffer, bomb, 1000), BufferState::kTooLarge);
}

TEST(BodyBuffer, RefusesAStreamThatEndsEarly) {
  const std::string whole = gzipped("some text");
  for (std::size_t length = 1; length < whole.size(); ++length) {
    BodyBuffer buffer(true, kLimit);
    EXPECT_EQ(feed(buffer, whole.substr(0, length), 100), BufferState::kBadGzip) << length;
  }
}

TEST(BodyBuffer, RefusesWhatIsNotGzip) {
  BodyBuffer buffer(true, kLimit);
  EXPECT_EQ(feed(buffer, "{}", 100), BufferState::kBadGzip);
}

TEST(BodyBuffer, RefusesAnEmptyGzipBody) {
  BodyBuffer buffer(true, kLimit);
  EXPECT_EQ(buffer.finish(), BufferState::kBadGzip);
}

}  // namespace
}  // namespace cornerfix::server
