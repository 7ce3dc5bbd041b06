#include "server/request_head.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

using ::testing::HasSubstr;
using HeadState = HeadReader::State;

constexpr const char* kHost = "Host: a\r\n";

HeadState read_head(HeadReader& reader, std::string_view bytes) { return reader.take(bytes); }

Refusal refusal_of(const std::string& bytes, HeadLimits limits = {}) {
  HeadReader reader(limits);
  EXPECT_EQ(read_head(reader, bytes), HeadState::kRefused) << bytes;
  return reader.refusal();
}

std::string with_header(const std::string& lines) {
  return std::string("POST /v1/maps HTTP/1.1\r\n") + kHost + lines + "\r\n";
}

TEST(RequestHead, IsTakenInPiecesAndLeavesWhatFollows) {
  const std::string head = with_header("Content-Length:  5 \r\nX-Mine:\r\n");
  HeadReader reader;
  for (std::size_t i = 0; i + 1 < head.size(); ++i) {
    ASSERT_EQ(read_head(reader, head.substr(i, 1)), HeadState::kReading) << i;
  }
  std::string_view rest = "\nhello";
  ASSERT_EQ(reader.take(rest), HeadState::kDone);
  EXPECT_EQ(rest, "hello");
  EXPECT_EQ(reader.head().method, "POST");
  EXPECT_EQ(reader.head().framing.length, 5U);
  EXPECT_EQ(reader.head().text,
            "POST /v1/maps HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\nX-Mine: \r\n\r\n");
}

TEST(RequestHead, MayFollowOneEmptyLine) {
  HeadReader reader;
  EXPECT_EQ(read_head(reader, "\r\n" + with_header("")), HeadState::kDone);
  EXPECT_EQ(refusal_of("\r\n\r\n").status, 400);
}

TEST(RequestHead, IsRefusedWhereTwoReadersCouldDisagree) {
  for (const char* lines : {"Content-Length : 5\r\n",
                            "Content-Length\t: 5\r\n",
                            "X-A: b\r\n Content-Length: 5\r\n",
                            "X-A: b\r\n\tfolded\r\n",
                            "X-A: b\nContent-Length: 5\r\n",
                            "X-A: b\rc\r\n",
                            "Content-Length: 5\r\nContent-Length: 5\r\n",
                            "Content-Length: 5, 5\r\n",
                            "Content-Length: +5\r\n",
                            "Content-Length: 0x5\r\n",
                            "Content-Length: %35\r\n",
                            "Content-Length: \r\n",
                            "Content-Length: 99999999999999999999\r\n",
                            "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
                            "Transfer-Encoding: chunked\r\nContent-Length: 5\r\n",
                            "Content-Length: 5\r\ntransfer-encoding: chunked\r\n",
                            "Transfer-Encoding: xchunked\r\n",
                            "Transfer-Encoding: gzip, chunked\r\n",
                            "Transfer-Encoding: identity\r\n",
                            "Host: b\r\n",
                            "no colon\r\n",
                            ": empty\r\n",
                            "X-A\x01: b\r\n",
                            "X-A: \x1b[31m\r\n"}) {
    EXPECT_EQ(refusal_of(with_header(lines)).status, 400) << lines;
  }
  for (const char* head :
       {"GET /\r\n", "GET  / HTTP/1.1\r\n", "GET / HTTP/1.1 \r\n", "GET / HTTP/2\r\n",
        "G,T / HTTP/1.1\r\n", " GET / HTTP/1.1\r\n", "GET / HTTP/1.1\n", "GET /\x7f HTTP/1.1\r\n",
        "GET / HTTP/1.1\r\n\r\n", "POST / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n"}) {
    EXPECT_EQ(refusal_of(head).status, 400) << head;
  }
  EXPECT_EQ(refusal_of(with_header(std::string("X-A: \0\r\n", 8))).status, 400);
}

TEST(RequestHead, WithAnEmptyConditionIsRefused) {
  const Refusal refusal = refusal_of(with_header("If-Match: \r\n"));
  EXPECT_EQ(refusal.status, 400);
  EXPECT_EQ(refusal.detail, "If-Match is empty, expected an ETag in double quotes, or *.");
}

TEST(RequestHead, OfGetAndHeadHasNoBody) {
  for (const char* method : {"GET", "HEAD"}) {
    for (const char* framing : {"Content-Length: 5\r\n", "Transfer-Encoding: chunked\r\n"}) {
      const auto refusal =
          refusal_of(std::string(method) + " / HTTP/1.1\r\n" + kHost + framing + "\r\n");
      EXPECT_EQ(refusal.status, 400);
      EXPECT_THAT(refusal.detail, HasSubstr("no body"));
    }
  }
  HeadReader reader;
  EXPECT_EQ(read_head(reader, "GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 0\r\n\r\n"),
            HeadState::kDone);
}

TEST(RequestHead, KeepsExpectToTheConnection) {
  HeadReader reader;
  ASSERT_EQ(read_head(reader, with_header("Expect: 100-Continue\r\nContent-Length: 5\r\n")),
            HeadState::kDone);
  EXPECT_TRUE(reader.head().expects_continue);
  EXPECT_THAT(reader.head().text, ::testing::Not(HasSubstr("Expect")));
  EXPECT_EQ(refusal_of(with_header("Expect: more\r\n")).status, 417);
}

TEST(RequestHead, IsRefusedBeforeItIsTooLarge) {
  const std::string begin = with_header("");
  const std::string open_head = begin.substr(0, begin.size() - 2);
  std::string many = open_head;
  for (int i = 0; i < 101; ++i) many += "a:b\r\n";
  EXPECT_EQ(refusal_of(many).status, 431);
  EXPECT_EQ(refusal_of(open_head + "X: " + std::string(8200, 'a')).status, 431);
  std::string large = open_head;
  for (int i = 0; i < 5; ++i) large += "X: " + std::string(8000, 'a') + "\r\n";
  EXPECT_EQ(refusal_of(large).status, 431);
  const auto long_target = refusal_of("GET /" + std::string(9000, 'a'));
  EXPECT_EQ(long_target.status, 414);
  EXPECT_EQ(long_target.code, "uri_too_long");
}

TEST(RequestHead, MayHaveAsManyLinesAsTheLimit) {
  std::string head = std::string("GET / HTTP/1.1\r\n") + kHost;
  for (int i = 0; i < 99; ++i) head += "a:b\r\n";
  HeadReader reader;
  EXPECT_EQ(read_head(reader, head + "\r\n"), HeadState::kDone);
}

}  // namespace
}  // namespace cornerfix::server
