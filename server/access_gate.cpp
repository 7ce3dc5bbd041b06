#include "server/access_gate.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "server/event_log.hpp"

namespace cornerfix::server {
namespace {

/// A table that is not empty and lets nobody in.
std::shared_ptr<const TokenTable> nobodys_token() {
  const std::vector<storage::TokenRecord> expired = {
      {.name = "nobody", .role = "viewer", .expires = "1970-01-01T00:00:00Z"}};
  return std::make_shared<const TokenTable>(std::vector<Token>{}, expired);
}

Response forbidden_page() {
  return problem_response(403, "forbidden", "Another site's page may not change anything here.");
}

/// Whether a browser sends this on behalf of another site's page.
bool is_cross_site(const Caller& caller) {
  return caller.fetch_site == "cross-site" || caller.fetch_site == "same-site";
}

}  // namespace

AccessGate::AccessGate(const ServerConfig& config, std::shared_ptr<StoreAccess> stores,
                       std::shared_ptr<Metrics> metrics, NowText now)
    : hosts_(config.listen, config.allowed_hosts),
      stores_(std::move(stores)),
      metrics_(std::move(metrics)),
      now_(std::move(now)),
      logins_({.wrong_tokens = config.max_wrong_tokens,
               .lockout = std::chrono::seconds(config.lockout_s)}),
      rate_(config.max_requests_per_second),
      configured_(config.tokens) {}

std::shared_ptr<const TokenTable> AccessGate::tokens() {
  const auto epoch = stores_->epoch();
  const std::lock_guard lock(mutex_);
  if (tokens_ && (!epoch || *epoch == epoch_)) return tokens_;
  const auto stored = stores_->tokens();
  if (!stored) return tokens_;
  auto table = std::make_shared<const TokenTable>(configured_, *stored);
  const bool was_closed = tokens_ && !tokens_->is_empty();
  if (was_closed && table->is_empty()) table = nobodys_token();
  tokens_ = std::move(table);
  epoch_ = epoch ? *epoch : 0;
  return tokens_;
}

void AccessGate::set_tokens(std::vector<Token> tokens) {
  {
    const std::lock_guard lock(mutex_);
    configured_ = std::move(tokens);
    epoch_ = 0;  // Epochs of the store begin at 1.
  }
  (void)this->tokens();
}

std::variant<Principal, Response> AccessGate::admit(const Caller& caller, Access access) {
  if (!caller.is_reading && is_cross_site(caller)) return forbidden_page();
  if (access == Access::kPublic) return Principal{};
  const auto known = tokens();
  if (known->is_empty()) {
    if (auto refusal = refuse_foreign_page(caller)) return std::move(*refusal);
  }
  auto identified = identify(caller, *known);
  const auto* principal = std::get_if<Principal>(&identified);
  if (principal == nullptr) return identified;
  if (!may(principal->role, access))
    return problem_response(403, "forbidden", "The token's role does not allow this.");
  if (auto refusal = refuse_rate(caller, *known, *principal)) return std::move(*refusal);
  return identified;
}

std::variant<Principal, Response> AccessGate::identify(const Caller& caller,
                                                       const TokenTable& known) {
  if (known.is_empty()) return Principal{};
  const auto now = Clock::now();
  if (const auto wait = logins_.must_wait(caller.address, caller.authorization, now)) {
    metrics_->count_limited("locked_out");
    return too_many_response("locked_out", "Too many wrong tokens came from this address.", *wait);
  }
  if (auto principal = known.identify(caller.authorization, now_())) {
    logins_.note_accepted(caller.address, caller.authorization);
    return std::move(*principal);
  }
  const bool has_tried = !caller.authorization.empty();
  if (has_tried && logins_.note_wrong(caller.address, caller.authorization, now)) {
    metrics_->count_lockout();
    log_warning("locked_out", {{"client", caller.address}});
  }
  Response response = problem_response(401, "unauthorized", "Send Authorization: Bearer TOKEN.");
  response.headers.emplace_back("WWW-Authenticate", "Bearer realm=\"cornerfix\"");
  return response;
}

/// Callers are known by the names of their tokens; where there are none, by their addresses.
std::optional<Response> AccessGate::refuse_rate(const Caller& caller, const TokenTable& known,
                                                const Principal& principal) {
  const std::string& name = known.is_empty() ? caller.address : principal.name;
  const auto wait = rate_.must_wait(name, Clock::now());
  if (!wait) return std::nullopt;
  metrics_->count_limited("too_many_requests");
  return too_many_response("too_many_requests",
                           "More requests per second than max_requests_per_second.", *wait);
}

std::optional<Response> AccessGate::refuse_foreign_page(const Caller& caller) const {
  if (!caller.host.empty() && !hosts_.allows_host(caller.host)) {
    return problem_response(421, "misdirected_request",
                            "Host " + caller.host +
                                " is not known as a name of this server: configure tokens, or add "
                                "it to allowed_hosts.");
  }
  const bool is_foreign = std::ranges::any_of(caller.origins, [&](const std::string& origin) {
    return !hosts_.allows_origin(origin, caller.host);
  });
  if (!caller.is_reading && is_foreign) return forbidden_page();
  return std::nullopt;
}

}  // namespace cornerfix::server
