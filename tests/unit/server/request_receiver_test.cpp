#include "server/request_receiver.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

using ::testing::EndsWith;
using ReceiverState = RequestReceiver::State;

std::string head(const std::string& lines) {
  return "POST / HTTP/1.1\r\nHost: a\r\n" + lines + "\r\n";
}

/// A chunked request after its head.
ReceiverState read_chunks(RequestReceiver& receiver, const std::string& chunks) {
  const std::string text = head("Transfer-Encoding: chunked\r\n") + chunks;
  std::string_view bytes = text;
  return receiver.take(bytes);
}

Refusal refusal_of_chunks(const std::string& chunks) {
  RequestReceiver receiver;
  EXPECT_EQ(read_chunks(receiver, chunks), ReceiverState::kRefused) << chunks;
  return receiver.refusal();
}

TEST(RequestReceiver, EndsWhereTheBodyEnds) {
  RequestReceiver receiver;
  const std::string text = head("Content-Length: 5\r\n") + "helloGET / HTTP/1.1\r\n";
  std::string_view bytes = text;
  EXPECT_EQ(receiver.take(bytes), ReceiverState::kComplete);
  EXPECT_EQ(bytes, "GET / HTTP/1.1\r\n");
  EXPECT_EQ(receiver.take_text(), head("Content-Length: 5\r\n") + "hello");
}

TEST(RequestReceiver, IsCompleteWithItsHeadWhenThereIsNoBody) {
  for (const char* lines : {"", "Content-Length: 0\r\n"}) {
    RequestReceiver receiver;
    const std::string text = head(lines);
    std::string_view bytes = text;
    EXPECT_EQ(receiver.take(bytes), ReceiverState::kComplete);
  }
}

TEST(RequestReceiver, WritesChunksAnewWithoutExtensionsAndTrailers) {
  RequestReceiver receiver;
  const std::string text = head("Transfer-Encoding: chunked\r\n") +
                           "5;a=\"b\"\r\nhello\r\n0006\r\n world\r\n0\r\nX-Sum: 1\r\n\r\nnext";
  std::string received;
  std::string_view bytes = text;
  while (receiver.state() != ReceiverState::kComplete && !bytes.empty()) {
    std::string_view piece = bytes.substr(0, 7);
    const std::size_t offered = piece.size();
    ASSERT_NE(receiver.take(piece), ReceiverState::kRefused);
    bytes.remove_prefix(offered - piece.size());
    received += receiver.take_text();
  }
  EXPECT_EQ(bytes, "next");
  EXPECT_THAT(received, EndsWith("\r\n0\r\n\r\n"));
  EXPECT_EQ(received.find("X-Sum"), std::string::npos);
  EXPECT_EQ(received.find(';'), std::string::npos);
}

TEST(RequestReceiver, RefusesChunksWhoseEndIsInDoubt) {
  for (const char* chunks :
       {"+5\r\nhello\r\n", "-1\r\n", "0x5\r\nhello\r\n", "\r\n", "5\nhello\r\n", " 5\r\nhello\r\n",
        "5\r\nhelloX\r\n", "5\r\nhello\n", "123456789\r\n", "g\r\n", "0\r\nno colon\r\n\r\n",
        "0\r\n X: folded\r\n\r\n", "0\r\n\n", "5;\x01\r\n"}) {
    EXPECT_EQ(refusal_of_chunks(chunks).status, 400) << chunks;
  }
  EXPECT_EQ(refusal_of_chunks("5;" + std::string(300, 'a')).status, 400);
}

TEST(RequestReceiver, LimitsTrailers) {
  std::string many = "0\r\n";
  for (int i = 0; i < 101; ++i) many += "a:b\r\n";
  EXPECT_EQ(refusal_of_chunks(many).status, 431);
  EXPECT_EQ(refusal_of_chunks("0\r\nX: " + std::string(40'000, 'a')).status, 431);
}

}  // namespace
}  // namespace cornerfix::server
