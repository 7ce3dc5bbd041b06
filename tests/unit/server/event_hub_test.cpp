#include "server/event_hub.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

using namespace std::chrono_literals;

TEST(EventHub, GivesEventsToThoseWhoWatchTheSession) {
  EventHub hub(2);
  const auto one = hub.subscribe("one");
  const auto other = hub.subscribe("other");
  hub.publish("one", "event");
  EXPECT_EQ(one->next(0ms), "event");
  EXPECT_EQ(other->next(0ms), ": still here\n\n");
}

TEST(EventHub, KnowsWhetherASessionIsWatched) {
  EventHub hub(1);
  EXPECT_FALSE(hub.is_watched("one"));
  auto subscription = hub.subscribe("one");
  EXPECT_TRUE(hub.is_watched("one"));
  subscription.reset();
  EXPECT_FALSE(hub.is_watched("one"));
}

TEST(EventHub, TakesSoManyWatchersOnly) {
  EventHub hub(1);
  auto first = hub.subscribe("one");
  EXPECT_EQ(hub.subscribe("two"), nullptr);
  first.reset();
  EXPECT_NE(hub.subscribe("two"), nullptr);
}

TEST(EventHub, DropsAWatcherThatDoesNotKeepUp) {
  EventHub hub(1);
  const auto slow = hub.subscribe("one");
  for (int i = 0; i < 100; ++i) hub.publish("one", std::to_string(i));
  EXPECT_FALSE(hub.is_watched("one"));
  std::string last;
  while (const auto event = slow->next(0ms)) last = *event;
  EXPECT_EQ(last, "63");
}

TEST(EventHub, EndsTheStreamsOfASession) {
  EventHub hub(2);
  const auto one = hub.subscribe("one");
  const auto other = hub.subscribe("other");
  hub.end("one");
  EXPECT_EQ(one->next(1h), std::nullopt);
  EXPECT_TRUE(hub.is_watched("other"));
}

TEST(EventHub, EndsAllStreamsWhenItCloses) {
  EventHub hub(2);
  const auto subscription = hub.subscribe("one");
  hub.close();
  EXPECT_EQ(subscription->next(1h), std::nullopt);
  EXPECT_EQ(hub.subscribe("one"), nullptr);
}

TEST(EventFormat, CarriesNameNumberAndData) {
  EXPECT_EQ(format_answer_event(7, "{}"), "event: answer\nid: 7\ndata: {}\n\n");
}

}  // namespace
}  // namespace cornerfix::server
