#include "ros2/session_client.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

// After all else: its <resolv.h> defines macros.
#include <httplib.h>

namespace cornerfix::ros2 {

namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr auto kConnectTimeout = std::chrono::seconds(5);
constexpr auto kAnswerTimeout = std::chrono::seconds(60);  // A search of many maps takes seconds.
constexpr auto kCloseTimeout = std::chrono::seconds(1);
constexpr milliseconds kFirstPause{100};
constexpr milliseconds kLongestPause{5000};
constexpr int kMaxRetryAfterSeconds = 30;

/// Doubles from attempt to attempt.
milliseconds pause_after(int failures) {
  return std::min(kFirstPause * (1 << std::min(failures, 10)), kLongestPause);
}

Json pose_json(const Pose2& pose) { return {{"x", pose.x}, {"y", pose.y}, {"yaw", pose.yaw}}; }

/// Geometry and mount, for a session or a scan.
Json lidar_json(const AssembledScan& scan) {
  const LaserScan& lidar = scan.scan;
  Json json = {{"angle_min", lidar.angle_min},
               {"angle_increment", lidar.angle_increment},
               {"range_min", lidar.range_min},
               {"range_max", nullptr},  // JSON has no infinity.
               {"mount", pose_json(scan.T_base_link_laser)}};
  if (std::isfinite(lidar.range_max)) json["range_max"] = lidar.range_max;
  if (scan.time_increment != 0.0) json["time_increment"] = scan.time_increment;
  return json;
}

Json scan_json(const AssembledScan& scan) {
  Json json = lidar_json(scan);  // It may differ from scan to scan.
  json["stamp"] = scan.scan.stamp;
  json["ranges"] = scan.scan.ranges;
  if (!scan.lidar.empty()) json["lidar"] = scan.lidar;
  if (scan.T_odom_base_link) json["odom"] = pose_json(*scan.T_odom_base_link);
  return json;
}

/// CBOR has infinity and NaN, and floats in half of the space.
std::string batch_cbor(std::uint64_t sequence, std::span<const AssembledScan> batch) {
  Json scans = Json::array();
  for (const AssembledScan& scan : batch) scans.push_back(scan_json(scan));
  std::string body;
  Json::to_cbor({{"sequence", sequence}, {"scans", std::move(scans)}}, body);
  return body;
}

Json near_json(const StartRegion& near) {
  Json json = {{"x", near.center.x()}, {"y", near.center.y()}, {"radius_m", near.radius_m}};
  if (!near.map.empty()) json["map"] = near.map;
  if (near.yaw) {
    json["yaw"] = *near.yaw;
    json["yaw_tolerance_rad"] = near.yaw_tolerance_rad;
  }
  return json;
}

std::string text_member(const Json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() && member->is_string() ? member->get<std::string>() : "";
}

/// What a problem document says, in a line.
std::string describe_problem(int status, const std::string& body) {
  const Json problem = Json::parse(body, nullptr, false);
  std::string text = std::to_string(status);
  if (!problem.is_object()) return text + " of the server";
  text += " " + text_member(problem, "detail");
  const auto errors = problem.find("errors");
  if (errors != problem.end() && errors->is_array() && !errors->empty()) {
    text += " (at " + text_member(errors->front(), "pointer") + ")";
  }
  return text;
}

std::optional<std::uint64_t> expected_sequence(const std::string& body) {
  const Json problem = Json::parse(body, nullptr, false);
  if (!problem.is_object()) return std::nullopt;
  const auto expected = problem.find("expected");
  if (expected == problem.end() || !expected->is_number_unsigned()) return std::nullopt;
  return expected->get<std::uint64_t>();
}

int retry_after_s(const httplib::Response& response) {
  const std::string header = response.get_header_value("Retry-After");
  int seconds = 1;
  std::from_chars(header.data(), header.data() + header.size(), seconds);
  return std::clamp(seconds, 1, kMaxRetryAfterSeconds);
}

std::string origin_of(const std::string& url) {
  return url.substr(0, url.find('/', url.find("://") + 3));
}

std::string base_path_of(const std::string& url) {
  std::string path = url.substr(origin_of(url).size());
  while (path.ends_with('/')) path.pop_back();
  return path;
}

}  // namespace

class SessionClient::Connection {
 public:
  explicit Connection(const ServerAddress& server)
      : client_(origin_of(server.url)), base_path_(base_path_of(server.url)) {
    client_.set_tcp_nodelay(true);  // Nagle's algorithm would cost 40 ms per request.
    client_.set_keep_alive(true);
    client_.set_connection_timeout(kConnectTimeout);
    client_.set_read_timeout(kAnswerTimeout);
    client_.set_write_timeout(kAnswerTimeout);
    if (!server.token.empty()) client_.set_bearer_token_auth(server.token.c_str());
  }

  httplib::Result get(const std::string& path) { return client_.Get((base_path_ + path).c_str()); }
  httplib::Result post(const std::string& path, const std::string& body, const char* type) {
    return client_.Post((base_path_ + path).c_str(), body, type);
  }
  void remove(const std::string& path) {
    client_.set_connection_timeout(kCloseTimeout);
    client_.set_read_timeout(kCloseTimeout);
    client_.Delete((base_path_ + path).c_str());
    client_.set_connection_timeout(kConnectTimeout);
    client_.set_read_timeout(kAnswerTimeout);
  }
  void stop() { client_.stop(); }

 private:
  httplib::Client client_;
  std::string base_path_;
};

SessionClient::SessionClient(const ServerAddress& server, SessionOptions options)
    : connection_(std::make_unique<Connection>(server)),
      url_(server.url),
      options_(std::move(options)) {}

SessionClient::~SessionClient() = default;

std::optional<Error> SessionClient::check() {
  std::vector<std::string> paths;
  for (const std::string& map : options_.maps) paths.push_back("/v1/maps/" + map);
  if (paths.empty()) paths.emplace_back("/v1/sessions?limit=1");
  for (const std::string& path : paths) {
    const httplib::Result reply = connection_->get(path);
    if (!reply || reply->status < 400 || reply->status >= 500 || reply->status == 429) continue;
    return Error{ErrorCode::kNotFound, describe_problem(reply->status, reply->body), url_ + path};
  }
  return std::nullopt;
}

SessionClient::Outcome SessionClient::fail_unreachable() {
  return {Outcome::Kind::kTryAgain, {}, "no answer from " + url_, pause_after(failures_++)};
}

SessionClient::Outcome SessionClient::fail(int status, const std::string& body, int retry_after_s) {
  const bool is_busy = status == 429 || status == 503;
  const milliseconds wait = is_busy ? std::chrono::seconds(retry_after_s) : pause_after(failures_);
  ++failures_;
  return {Outcome::Kind::kTryAgain, {}, describe_problem(status, body), wait};
}

std::optional<SessionClient::Outcome> SessionClient::open(const AssembledScan& first) {
  Json body = {{"robot", options_.robot}};
  if (options_.lidars.empty()) body["lidar"] = lidar_json(first);
  // Scans bring their own geometry, so that of a lidar which was not heard yet does not matter.
  for (const std::string& name : options_.lidars) body["lidars"][name] = lidar_json(first);
  if (!options_.maps.empty()) body["maps"] = options_.maps;
  if (options_.near) body["near"] = near_json(*options_.near);
  const httplib::Result reply = connection_->post("/v1/sessions", body.dump(), "application/json");
  if (!reply) return fail_unreachable();
  const Json session = Json::parse(reply->body, nullptr, false);
  if (reply->status != 201 || !session.is_object()) {
    return fail(reply->status, reply->body, retry_after_s(*reply));
  }
  session_ = text_member(session, "id");
  sequence_ = 0;
  options_.near.reset();
  return std::nullopt;
}

SessionClient::Outcome SessionClient::post(std::span<const AssembledScan> batch) {
  if (batch.front().begins_run && !std::exchange(is_run_begun_, true)) close();
  if (session_.empty()) {
    if (auto failure = open(batch.front())) return std::move(*failure);
  }
  const httplib::Result reply = connection_->post("/v1/sessions/" + session_ + "/scans",
                                                  batch_cbor(sequence_, batch), "application/cbor");
  if (!reply) return fail_unreachable();
  const int status = reply->status;
  if (status == 200) {
    const Json json = Json::parse(reply->body, nullptr, false);
    Outcome outcome{Outcome::Kind::kAnswered, parse_answer(json), "", milliseconds(0)};
    if (!outcome.answer) return fail(status, reply->body, 1);
    ++sequence_;
    failures_ = 0;
    is_run_begun_ = false;
    return outcome;
  }
  Outcome outcome = fail(status, reply->body, retry_after_s(*reply));
  if (const auto expected = expected_sequence(reply->body); status == 409 && expected) {
    sequence_ = *expected;
  } else if (status == 409 || status == 404) {
    session_.clear();
  } else if (status >= 400 && status < 500 && status != 401 && status != 403 && status != 408 &&
             status != 429) {
    outcome.kind = Outcome::Kind::kRefused;
    is_run_begun_ = false;
  }
  return outcome;
}

void SessionClient::close() {
  if (!session_.empty()) connection_->remove("/v1/sessions/" + std::exchange(session_, {}));
}

void SessionClient::stop() { connection_->stop(); }

}  // namespace cornerfix::ros2
