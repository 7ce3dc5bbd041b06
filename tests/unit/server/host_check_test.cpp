#include "server/host_check.hpp"

#include <gmock/gmock.h>

namespace cornerfix::server {
namespace {

const HostCheck kLoopback("127.0.0.1", {"Robots.example.com"});
const HostCheck kEverywhere("0.0.0.0", {});

TEST(HostCheck, KnowsTheNamesOfLoopback) {
  for (const char* host : {"localhost", "LOCALHOST:8080", "localhost.", "a.localhost", "127.0.0.1",
                           "127.9.9.9:80", "[::1]", "[::1]:8080"}) {
    EXPECT_TRUE(kLoopback.allows_host(host)) << host;
    EXPECT_TRUE(kEverywhere.allows_host(host)) << host;
  }
}

TEST(HostCheck, RefusesNamesThatStrangersCanResolve) {
  for (const char* host : {"", "evil.example.com", "evil.example.com:8080", "127.0.0.1.example.com",
                           "localhost.example.com", "[evil.example.com]"}) {
    EXPECT_FALSE(kLoopback.allows_host(host)) << host;
    EXPECT_FALSE(kEverywhere.allows_host(host)) << host;
  }
  EXPECT_FALSE(kLoopback.allows_host("192.168.1.5"));
}

TEST(HostCheck, AllowsConfiguredNames) {
  EXPECT_TRUE(kLoopback.allows_host("robots.example.com"));
  EXPECT_TRUE(kLoopback.allows_host("ROBOTS.example.com:443"));
}

TEST(HostCheck, AllowsAddressesAndLocalNamesWhereTheServerHasThem) {
  for (const char* host :
       {"192.168.1.5:8080", "[fe80::1]:8080", "cornerfix", "cornerfix:8080", "cart-server.local"}) {
    EXPECT_TRUE(kEverywhere.allows_host(host)) << host;
  }
  EXPECT_TRUE(HostCheck("192.168.1.5", {}).allows_host("192.168.1.5"));
}

TEST(HostCheck, AllowsTheServersOwnPages) {
  EXPECT_TRUE(kLoopback.allows_origin("http://localhost:8080", "localhost:8080"));
  EXPECT_TRUE(kLoopback.allows_origin("https://robots.example.com", "localhost:8080"));
  for (const char* origin : {"http://evil.example.com", "http://localhost:9090", "null", ""}) {
    EXPECT_FALSE(kLoopback.allows_origin(origin, "localhost:8080")) << origin;
  }
}

}  // namespace
}  // namespace cornerfix::server
