#include "server/preference.hpp"

#include <gtest/gtest.h>

namespace cornerfix::server {
namespace {

TEST(Preference, FindsRespondAsyncAmongOthers) {
  for (const char* header : {"respond-async", "Respond-Async", "wait=10, respond-async",
                             " respond-async ;x=1,wait=5", "handling=strict,\trespond-async"}) {
    EXPECT_TRUE(prefers_async(header)) << header;
  }
}

TEST(Preference, IgnoresAllOthers) {
  for (const char* header : {"", ",", ";", "wait", "wait=10", "respond-asynchronously", "respond",
                             "x=respond-async", "respond-async=0"}) {
    EXPECT_FALSE(prefers_async(header)) << header;
  }
}

}  // namespace
}  // namespace cornerfix::server
