#include "server/access_gate.hpp"

#include <gmock/gmock.h>

#include "support/temporary_directory.hpp"

namespace cornerfix::server {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Pair;

class AccessGateTest : public ::testing::Test {
 protected:
  AccessGate gate_of(const ServerConfig& config) {
    return {config, stores_, metrics_, [] { return std::string("2024-05-01T12:00:00Z"); }};
  }

  static ServerConfig with_token() {
    ServerConfig config;
    config.tokens = {{.token = "0123456789abcdef", .role = Role::kRobot, .name = "cart-7"}};
    config.max_wrong_tokens = 2;
    return config;
  }

  static Caller caller(const std::string& token) {
    return {.address = "10.0.0.1", .is_reading = true, .authorization = "Bearer " + token};
  }

  static int status_of(AccessGate& gate, const Caller& caller, Access access = Access::kRead) {
    const auto admitted = gate.admit(caller, access);
    const auto* refusal = std::get_if<Response>(&admitted);
    return refusal == nullptr ? 200 : refusal->status;
  }

  testing::TemporaryDirectory directory_;
  std::shared_ptr<StoreAccess> stores_ = StoreAccess::open(directory_ / "test.db").value();
  std::shared_ptr<Metrics> metrics_ = std::make_shared<Metrics>();
};

TEST_F(AccessGateTest, AdmitsTheHolderOfATokenForWhatItsRoleMay) {
  AccessGate gate = gate_of(with_token());
  EXPECT_EQ(status_of(gate, caller("0123456789abcdef")), 200);
  EXPECT_EQ(status_of(gate, caller("0123456789abcdef"), Access::kMap), 403);
  EXPECT_EQ(status_of(gate, caller("wrong")), 401);
  EXPECT_EQ(status_of(gate, {.address = "10.0.0.1"}, Access::kPublic), 200);
}

TEST_F(AccessGateTest, LocksAnAddressOutThatTriesManyTokens) {
  AccessGate gate = gate_of(with_token());
  for (const char* wrong : {"wrong 1", "wrong 2", "wrong 3"})
    EXPECT_EQ(status_of(gate, caller(wrong)), 401);
  const auto refused = gate.admit(caller("0123456789abcdef"), Access::kRead);
  const auto& response = std::get<Response>(refused);
  EXPECT_EQ(response.status, 429);
  EXPECT_THAT(response.body, HasSubstr("\"locked_out\""));
  EXPECT_THAT(response.headers, Contains(Pair("Retry-After", "60")));
  EXPECT_THAT(metrics_->render({}), HasSubstr("cornerfix_lockouts_total 1"));
  EXPECT_THAT(metrics_->render({}),
              HasSubstr("cornerfix_requests_limited_total{reason=\"locked_out\"} 1"));
}

TEST_F(AccessGateTest, ALockOutLeavesRobotsThatWereAdmittedAlone) {
  AccessGate gate = gate_of(with_token());
  EXPECT_EQ(status_of(gate, caller("0123456789abcdef")), 200);
  for (const char* wrong : {"wrong 1", "wrong 2", "wrong 3"})
    EXPECT_EQ(status_of(gate, caller(wrong)), 401);
  EXPECT_EQ(status_of(gate, caller("0123456789abcdef")), 200);
  EXPECT_EQ(status_of(gate, caller("wrong 1")), 429);
}

TEST_F(AccessGateTest, RequestsWithoutATokenLockNobodyOut) {
  AccessGate gate = gate_of(with_token());
  for (int i = 0; i < 10; ++i) EXPECT_EQ(status_of(gate, {.address = "10.0.0.1"}), 401);
  EXPECT_EQ(status_of(gate, caller("0123456789abcdef")), 200);
}

TEST_F(AccessGateTest, LimitsTheRequestsPerSecond) {
  ServerConfig config = with_token();
  config.max_requests_per_second = 1;
  AccessGate gate = gate_of(config);
  const Caller robot = caller("0123456789abcdef");
  int limited = 0;
  for (int i = 0; i < 100 && limited == 0; ++i) limited = status_of(gate, robot) == 429 ? 1 : 0;
  EXPECT_EQ(limited, 1);
  EXPECT_THAT(metrics_->render({}),
              HasSubstr("cornerfix_requests_limited_total{reason=\"too_many_requests\"} 1"));
}

}  // namespace
}  // namespace cornerfix::server
