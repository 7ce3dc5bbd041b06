#include "server/preference.hpp"

#include <gtest/gtest.h>

namespace cornerfix::server {
namespace {

Preference read_preference(std::string_view header) {
  Preference preference;
  add_preference(preference, header);
  return preference;
}

TEST(Preference, FindsRespondAsyncAmongOthers) {
  for (const char* header : {"respond-async", "Respond-Async", "wait=10, respond-async",
                             " respond-async ;x=1,wait=5", "handling=strict,\trespond-async"}) {
    EXPECT_TRUE(read_preference(header).respond_async) << header;
  }
}

TEST(Preference, IgnoresAllOthers) {
  for (const char* header : {"", ",", ";", "wait", "wait=10", "respond-asynchronously", "respond",
                             "x=respond-async", "respond-async=0"}) {
    EXPECT_FALSE(read_preference(header).respond_async) << header;
  }
}

TEST(Preference, FindsHowLongTheClientWaits) {
  using std::chrono::seconds;
  EXPECT_EQ(read_preference("wait=10").wait, seconds(10));
  EXPECT_EQ(read_preference("respond-async, Wait = 7 ;x").wait, seconds(7));
  EXPECT_EQ(read_preference("wait=0, wait=9").wait, seconds(0));
  for (const char* header : {"wait=61", "wait=99999999999999999999"})
    EXPECT_EQ(read_preference(header).wait, kMaxWait) << header;
  for (const char* header : {"", "wait", "wait=", "wait=-1", "wait=1.5", "wait=x", "waits=1"})
    EXPECT_EQ(read_preference(header).wait, std::nullopt) << header;
}

}  // namespace
}  // namespace cornerfix::server
