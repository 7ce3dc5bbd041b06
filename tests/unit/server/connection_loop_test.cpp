#include "server/connection_loop.hpp"

#include <gmock/gmock.h>

#include <condition_variable>
#include <deque>
#include <optional>
#include <thread>

#include "support/raw_connection.hpp"

namespace cornerfix::server {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::RawConnection;
using ::testing::StartsWith;

constexpr const char* kGet = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";

std::string post(std::size_t length) {
  return "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: " + std::to_string(length) + "\r\n\r\n";
}

/// A loop in a thread of its own, and the test as its worker.
class LoopUnderTest {
 public:
  explicit LoopUnderTest(ConnectionLimits limits = {}) {
    auto listener = ListenSocket::open("127.0.0.1", 0);
    if (!listener) throw std::runtime_error(listener.error().message);
    port_ = listener->port();
    loop_.emplace(
        std::move(*listener), limits,
        [this](const RequestInWorkPtr& request) { return dispatch(request); },
        [](const Refusal& refusal) {
          return "HTTP/1.1 " + std::to_string(refusal.status) + "\r\n\r\n" + refusal.detail;
        });
    thread_ = std::thread([this] { EXPECT_TRUE(loop_->run()); });
  }
  ~LoopUnderTest() { drain(); }

  [[nodiscard]] int port() const { return port_; }
  ConnectionLoop& operator*() { return *loop_; }

  void drain() {
    loop_->drain();
    if (thread_.joinable()) thread_.join();
  }
  void refuse_work() { is_full_ = true; }

  /// The next request that reaches a worker.
  RequestInWorkPtr next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !requests_.empty(); });
    RequestInWorkPtr request = std::move(requests_.front());
    requests_.pop_front();
    return request;
  }
  /// Takes the next request and answers it; returns the request.
  std::string answer(const std::string& text, bool is_kept = true) {
    RequestInWorkPtr request = next();
    std::string received = request->receiver.take_text();
    loop_->finish(std::move(request), text, is_kept);
    return received;
  }

 private:
  bool dispatch(const RequestInWorkPtr& request) {
    if (is_full_) return false;
    const std::lock_guard lock(mutex_);
    requests_.push_back(request);
    changed_.notify_all();
    return true;
  }

  int port_ = 0;
  std::atomic<bool> is_full_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<RequestInWorkPtr> requests_;
  std::optional<ConnectionLoop> loop_;
  std::thread thread_;
};

TEST(ConnectionLoop, HandsARequestOverOnceItsBodyHasArrived) {
  LoopUnderTest loop;
  RawConnection slow(loop.port());
  slow.send(post(5) + "he");
  RawConnection quick(loop.port());
  quick.send(kGet);
  EXPECT_THAT(loop.answer("quick"), StartsWith("GET"));
  EXPECT_EQ(quick.read_until("quick"), "quick");
  slow.send("llo");
  EXPECT_EQ(loop.answer("slow"), post(5) + "hello");
  EXPECT_EQ(slow.read_until("slow"), "slow");
}

TEST(ConnectionLoop, AnswersRequestsThatWereSentTogetherInTheirOrder) {
  LoopUnderTest loop;
  RawConnection connection(loop.port());
  connection.send(std::string(kGet) + post(2) + "hi" + kGet);
  EXPECT_THAT(loop.answer("1"), StartsWith("GET"));
  EXPECT_THAT(loop.answer("2"), StartsWith("POST"));
  EXPECT_THAT(loop.answer("3", /*is_kept=*/false), StartsWith("GET"));
  EXPECT_EQ(connection.read_to_end(), "123");
}

TEST(ConnectionLoop, AsksForABodyThatWaitsToBeAskedFor) {
  LoopUnderTest loop;
  RawConnection connection(loop.port());
  connection.send(
      "POST / HTTP/1.1\r\nHost: a\r\nExpect: 100-continue\r\nContent-Length: 2\r\n\r\n");
  EXPECT_THAT(connection.read_until("\r\n\r\n"), StartsWith("HTTP/1.1 100"));
  connection.send("hi");
  EXPECT_EQ(loop.answer("done"), post(2) + "hi");
}

TEST(ConnectionLoop, HandsALargeBodyOverWithItsHead) {
  LoopUnderTest loop({.streamed_requests = 1});
  RawConnection large(loop.port());
  large.send(post(kMaxBufferedBody + 1));
  RequestInWorkPtr streamed = loop.next();
  EXPECT_TRUE(streamed->is_streamed());
  RawConnection another(loop.port());
  another.send(post(kMaxBufferedBody + 1));
  EXPECT_THAT(another.read_until("large bodies"), StartsWith("HTTP/1.1 503"));
  (*loop).finish(std::move(streamed), "refused", /*is_kept=*/false);
  EXPECT_EQ(large.read_to_end(), "refused");
}

TEST(ConnectionLoop, SendsAnAnswerThatTheClientReadsInPieces) {
  LoopUnderTest loop;
  RawConnection connection(loop.port());
  connection.send(kGet);
  const std::string large(std::size_t{20} << 20U, 'x');
  loop.answer(large, /*is_kept=*/false);
  EXPECT_EQ(connection.read_to_end().size(), large.size());
}

TEST(ConnectionLoop, RefusesAHeadThatTakesTooLong) {
  LoopUnderTest loop({.head_timeout = 20ms});
  RawConnection connection(loop.port());
  connection.send("GET / HTTP/1.1\r\n");
  EXPECT_THAT(connection.read_to_end(), StartsWith("HTTP/1.1 408"));
}

TEST(ConnectionLoop, RefusesABadHead) {
  LoopUnderTest loop;
  RawConnection connection(loop.port());
  connection.send("GET / HTTP/1.1\r\nContent-Length : 5\r\n\r\nhello");
  EXPECT_THAT(connection.read_to_end(), StartsWith("HTTP/1.1 400"));
}

TEST(ConnectionLoop, ClosesAnIdleConnection) {
  LoopUnderTest loop({.idle_timeout = 20ms});
  RawConnection connection(loop.port());
  EXPECT_THAT(connection.read_to_end(), IsEmpty());
}

TEST(ConnectionLoop, SaysBusyWhenTheWorkersHaveEnough) {
  LoopUnderTest loop;
  loop.refuse_work();
  RawConnection connection(loop.port());
  connection.send(kGet);
  EXPECT_THAT(connection.read_to_end(), StartsWith("HTTP/1.1 503"));
}

TEST(ConnectionLoop, LimitsConnections) {
  for (const ConnectionLimits& limits :
       {ConnectionLimits{.connections = 1}, ConnectionLimits{.connections_per_address = 1}}) {
    LoopUnderTest loop(limits);
    {
      RawConnection first(loop.port());
      RawConnection second(loop.port());
      EXPECT_THAT(second.read_to_end(), StartsWith("HTTP/1.1 503"));
    }
    while ((*loop).count() > 0) std::this_thread::yield();
    RawConnection third(loop.port());
    third.send(kGet);
    loop.answer("welcome");
    EXPECT_EQ(third.read_until("welcome"), "welcome");
  }
}

TEST(ConnectionLoop, LimitsWhatItKeepsOfRequests) {
  LoopUnderTest loop({.buffered_bytes = 100'000});
  RawConnection connection(loop.port());
  connection.send(post(200'000) + std::string(199'999, 'x'));
  EXPECT_THAT(connection.read_to_end(), StartsWith("HTTP/1.1 503"));
}

TEST(ConnectionLoop, HoldsLargeBodiesWithoutAWorker) {
  LoopUnderTest loop({.held_body = 4 * kMaxBufferedBody, .streamed_requests = 0});
  std::deque<RawConnection> slow;
  for (int i = 0; i < 20; ++i) slow.emplace_back(loop.port()).send(post(2 * kMaxBufferedBody));
  RawConnection quick(loop.port());
  const std::string body(2 * kMaxBufferedBody, 'x');
  quick.send(post(body.size()) + body);
  EXPECT_EQ(loop.answer("taken"), post(body.size()) + body);
  EXPECT_EQ(quick.read_until("taken"), "taken");
  EXPECT_EQ((*loop).count(), 21U);
}

TEST(ConnectionLoop, LetsTheSlowestBodiesGiveWay) {
  LoopUnderTest loop({.buffered_bytes = 100'000});
  std::deque<RawConnection> slow;
  for (int i = 0; i < 40; ++i)
    slow.emplace_back(loop.port()).send(post(50'000) + std::string(2'000, 'x'));
  RawConnection witness(loop.port());
  witness.send(kGet);
  loop.answer("seen");  // The loop has the slow ones' begin by now.
  EXPECT_EQ(witness.read_until("seen"), "seen");
  RawConnection quick(loop.port());
  const std::string body(60'000, 'x');
  quick.send(post(body.size()) + body);
  EXPECT_EQ(loop.answer("taken"), post(body.size()) + body);
  EXPECT_EQ(quick.read_until("taken"), "taken");
}

TEST(ConnectionLoop, ServesBesideConnectionsThatNeverSendARequest) {
  LoopUnderTest loop;
  std::deque<RawConnection> hostile;
  for (int i = 0; i < 300; ++i) {
    hostile.emplace_back(loop.port()).send(i % 2 == 0 ? "" : "GET / HTTP/1.1\r\nHo");
  }
  RawConnection robot(loop.port());
  robot.send(kGet);
  loop.answer("served");
  EXPECT_EQ(robot.read_until("served"), "served");
  EXPECT_EQ((*loop).count(), 301U);
}

TEST(ConnectionLoop, DrainsWithoutWaitingForClientsThatDoNotEnd) {
  LoopUnderTest loop({.drain_timeout = 20ms});
  RawConnection half(loop.port());
  half.send("GET / HT");
  RawConnection in_work(loop.port());
  in_work.send(kGet);
  RequestInWorkPtr request = loop.next();
  loop.drain();
  (*loop).finish(std::move(request), "too late", true);
}

TEST(ConnectionLoop, AnswersWhatHasBegunBeforeItEnds) {
  LoopUnderTest loop({.drain_timeout = 1h});
  RawConnection connection(loop.port());
  connection.send(post(5) + "hel");
  RawConnection witness(loop.port());
  witness.send(kGet);
  RequestInWorkPtr request = loop.next();  // The loop has the other request's begin by now.
  (*loop).drain();
  connection.send("lo");
  EXPECT_EQ(loop.answer("done", /*is_kept=*/false), post(5) + "hello");
  EXPECT_EQ(connection.read_to_end(), "done");
  (*loop).finish(std::move(request), "done", /*is_kept=*/false);
  EXPECT_EQ(witness.read_to_end(), "done");
  loop.drain();
}

}  // namespace
}  // namespace cornerfix::server
