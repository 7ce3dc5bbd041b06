// Any bytes are a sequence of calls on two maps by up to four sessions, with restarts of the server
// between them. No call ends in a 5xx or an exception. What was acknowledged stays: a batch that is
// posted again gets its first answer, sequences go on, and a restart changes no map.
//
// A letter chooses a call, the characters after it its details: '0' is the first choice. So the
// seeds in seeds/calls can be read and written by hand.
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "api/json_codec.hpp"
#include "fuzz/api_under_test.hpp"
#include "support/room_drive.hpp"

namespace {

using namespace cornerfix;
using api::Json;
using fuzz::Call;
using fuzz::require;
using server::Response;

constexpr std::size_t kMaxCalls = 24;
constexpr std::size_t kMaxSessions = 4;
constexpr std::size_t kMapScans = 48;
constexpr std::size_t kRobotScans = 63;  // Once around the room.

/// The input, one choice after the other; the first one of all when it is at its end.
class Choices {
 public:
  explicit Choices(std::string_view input) : input_(input) {}

  [[nodiscard]] bool at_end() const { return input_.empty(); }
  std::size_t below(std::size_t count) { return byte('0') % count; }
  std::size_t call(std::size_t count) { return byte('a') % count; }
  std::string text(std::size_t length) {
    const std::string_view taken = input_.substr(0, length);
    input_.remove_prefix(taken.size());
    return std::string(taken);
  }

 private:
  std::size_t byte(char first) {
    if (input_.empty()) return 0;
    const auto value = static_cast<std::uint8_t>(input_.front() - first);
    input_.remove_prefix(1);
    return value;
  }

  std::string_view input_;
};

Json ranges_of(const LaserScan& scan) {
  Json ranges = Json::array();
  for (std::size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    ranges.push_back(scan.has_return(beam) ? Json(scan.ranges[beam]) : Json(nullptr));
  }
  return ranges;
}

Json json_of(const Pose2& pose) { return {{"x", pose.x}, {"y", pose.y}, {"yaw", pose.yaw}}; }

/// What the robots see; made once.
struct Drives {
  Drives() {
    for (const PosedScan& posed : testing::mapping_drive()) {
      map.push_back({{"stamp", posed.scan.stamp},
                     {"ranges", ranges_of(posed.scan)},
                     {"pose", json_of(posed.T_map_base_link)}});
    }
    for (const RobotScan& robot_scan : testing::robot_drive(kRobotScans).scans) {
      robot.push_back({{"ranges", ranges_of(robot_scan.scan)},
                       {"odom", json_of(*robot_scan.T_odom_base_link)}});
    }
    const LaserScan scan = testing::scan_in_room({5.0, 5.0, 0.0}, 0.0);
    lidar = {{"angle_min", scan.angle_min},
             {"angle_increment", scan.angle_increment},
             {"range_min", scan.range_min},
             {"range_max", scan.range_max}};
  }
  std::vector<Json> map;
  std::vector<Json> robot;
  Json lidar;
};

const Drives& drives() {
  static const Drives made;
  return made;
}

/// A scan that a robot may post but should not.
void spoil(Json& scan, std::size_t fault) {
  Json& ranges = scan["ranges"];
  switch (fault) {
    case 1:
      for (Json& range : ranges) range = nullptr;
      break;
    case 2:
      for (Json& range : ranges) range = 1e-3;
      break;
    case 3:
      ranges[7] = 1e300;
      break;
    case 4:
      ranges[7] = -1.0;
      break;
    case 5:
      scan["stamp"] = -1e12;
      break;
    case 6:
      if (scan.contains("odom")) scan["odom"]["x"] = 1e8;
      break;
    case 7:
      scan.erase("odom");
      break;
    case 8:
      if (scan.contains("pose")) scan["pose"]["x"] = 3000.0;
      break;
    case 9:
      ranges.erase(ranges.begin() + 1, ranges.end());
      break;
    default:
      break;
  }
}

/// What the client knows of one of its sessions.
struct KnownSession {
  std::string id;
  std::uint64_t expected = 0;
  std::uint64_t scans = 0;  ///< Posted so far; they choose the next ones and their stamps.
  std::string last_batch{};
  std::string last_answer{};
};

class Sequence {
 public:
  Sequence(std::string_view input, const std::filesystem::path& directory) : choices_(input) {
    config_.database = directory / "calls.db";
    config_.min_free_bytes = 0;
    config_.max_sessions_per_robot = 3;
    config_.max_maps = 2;
    config_.kept_revisions = 1 + choices_.below(3);
    const std::size_t memory = choices_.below(3);
    if (memory > 0) config_.max_session_bytes = 1;
    if (memory > 1) config_.max_map_bytes = config_.max_mappers = 1;
    config_.checkpoint_interval_s = choices_.below(2) == 0 ? 0 : 3600;
    config_.recorded_answers = choices_.below(2) * 3;
    api_ = std::make_unique<fuzz::ApiUnderTest>(config_);
  }

  void run() {
    using Step = void (Sequence::*)();
    static constexpr std::array<Step, 14> kSteps{
        &Sequence::put_map,    &Sequence::post_map_scans, &Sequence::create_session,
        &Sequence::post_batch, &Sequence::repeat_batch,   &Sequence::reset,
        &Sequence::localize,   &Sequence::read,           &Sequence::put_trajectory,
        &Sequence::roll_back,  &Sequence::copy_map,       &Sequence::put_grid,
        &Sequence::restart,    &Sequence::remove};
    for (std::size_t i = 0; i < kMaxCalls && !choices_.at_end(); ++i) {
      (this->*kSteps[choices_.call(kSteps.size())])();
    }
    restart();
  }

 private:
  Response answer(const Call& call) { return api_->answer(call); }
  int status_of(const char* method, const std::string& path, const Json& body) {
    return answer({.method = method, .path = path, .body = body.dump()}).status;
  }
  std::string map_path() { return choices_.below(2) == 0 ? "/v1/maps/a" : "/v1/maps/b"; }
  KnownSession* session() {
    return sessions_.empty() ? nullptr : &sessions_[choices_.below(sessions_.size())];
  }
  Json near() {
    static constexpr std::array<double, 4> kCoordinates{5.0, 0.0, -1e5, 1e8};
    Json circle{{"x", kCoordinates[choices_.below(4)]},
                {"y", kCoordinates[choices_.below(4)]},
                {"radius_m", choices_.below(2) == 0 ? 2.0 : 1e5}};
    if (choices_.below(2) == 1) circle["yaw"] = 0.1;
    return circle;
  }
  Json options() {
    static constexpr std::array<const char*, 3> kMethods{"indexed", "rma", "nma"};
    return {{"method", kMethods[choices_.below(3)]}};
  }

  void put_map() {
    const std::string path = map_path();
    Json body{{"lidar", drives().lidar}};
    if (choices_.below(2) == 1) body["parameters"] = {{"grid", {{"resolution_m", 0.1}}}};
    if (choices_.below(2) == 1) body.erase("lidar");
    status_of("PUT", path, body);
  }

  void post_map_scans() {
    const std::string path = map_path();
    const std::size_t first = choices_.below(kMapScans);
    const std::size_t count = std::min<std::size_t>(8 * (1 + choices_.below(6)), kMapScans - first);
    const bool has_poses = choices_.below(2) == 0;
    Json scans = Json::array();
    for (std::size_t i = first; i < first + count; ++i) {
      scans.push_back(drives().map[i]);
      if (!has_poses) scans.back().erase("pose");
    }
    spoil(scans[choices_.below(scans.size())], choices_.below(10));
    status_of("POST", path + "/scans", {{"lidar", drives().lidar}, {"scans", scans}});
  }

  void create_session() {
    static const std::array<Json, 3> kMaps{Json{"a"}, Json{"b"}, Json{"a", "b"}};
    Json body{{"robot", choices_.below(2) == 0 ? "cart" : "fork"}, {"lidar", drives().lidar}};
    if (const auto maps = choices_.below(4); maps > 0) body["maps"] = kMaps[maps - 1];
    body["options"] = options();
    if (choices_.below(2) == 1) body["near"] = near();
    const Response response =
        answer({.method = "POST", .path = "/v1/sessions", .body = body.dump()});
    if (response.status != 201) return;
    const Json created = Json::parse(response.body);
    if (sessions_.size() == kMaxSessions) sessions_.erase(sessions_.begin());
    sessions_.push_back({.id = created.at("id")});
  }

  Json next_scans(std::uint64_t first) {
    Json scans = Json::array();
    const std::size_t count = 1 + choices_.below(4);
    for (std::uint64_t i = first; i < first + count; ++i) {
      scans.push_back(drives().robot[i % kRobotScans]);
      scans.back()["stamp"] = 500.0 + testing::kScanPeriodS * static_cast<double>(i);
    }
    spoil(scans.back(), choices_.below(10));
    return scans;
  }

  void post_batch() {
    KnownSession* const known = session();
    if (known == nullptr) return;
    const std::uint64_t ahead = choices_.below(3) % 2;
    const Json scans = next_scans(known->scans);
    const std::string batch = Json{{"sequence", known->expected + ahead}, {"scans", scans}}.dump();
    const Response response = post(*known, batch);
    require(ahead == 0 || response.status != 200);
    if (response.status != 200) return;
    require(Json::parse(response.body).at("sequence") == known->expected);
    known->expected += 1;
    known->scans += scans.size();
    known->last_batch = batch;
    known->last_answer = response.body;
  }

  void repeat_batch() {
    KnownSession* const known = session();
    if (known == nullptr || known->expected == 0) return;
    const bool is_another = choices_.below(2) == 1;
    if (!is_another) {
      const Response response = post(*known, known->last_batch);
      // The map may have been removed.
      require(response.status != 200 || response.body == known->last_answer);
      return;
    }
    Json batch = Json::parse(known->last_batch);
    batch["scans"].back()["ranges"][0] = 1.2345;
    require(post(*known, batch.dump()).status != 200);
  }

  Response post(const KnownSession& known, const std::string& batch) {
    Response response =
        answer({.method = "POST", .path = "/v1/sessions/" + known.id + "/scans", .body = batch});
    if (response.status != 409) return response;
    const Json problem = Json::parse(response.body);
    require(problem.at("code") != "sequence_conflict" || problem.at("expected") == known.expected);
    return response;
  }

  void reset() {
    KnownSession* const known = session();
    if (known == nullptr) return;
    const std::string body = choices_.below(2) == 0 ? "" : Json{{"near", near()}}.dump();
    answer({.method = "POST", .path = "/v1/sessions/" + known->id + "/reset", .body = body});
  }

  void localize() {
    const std::string path = map_path() + "/localize";
    Json body{{"lidar", drives().lidar}, {"options", options()}};
    body["scans"] = next_scans(choices_.below(kRobotScans));
    status_of("POST", path, body);
  }

  void read() {
    static constexpr std::array<const char*, 10> kOfMaps{
        "",           "/features", "/features/0/descriptor",     "/grid.png", "/grid.yaml",
        "/revisions", "/archive",  "/features/99999/descriptor", "/nothing",  "/report"};
    static constexpr std::array<const char*, 6> kOthers{
        "/v1/maps", "/v1/sessions", "/v1/jobs", "/readyz", "/metrics", "/openapi.json"};
    const std::size_t what = choices_.below(20);
    if (what < kOfMaps.size()) {
      Call call{.method = "GET", .path = map_path() + kOfMaps[what]};
      if (call.path.ends_with("/report")) call.query = {{"wait", "0"}};
      answer(call);
    } else if (what < kOfMaps.size() + kOthers.size()) {
      Call call{.method = "GET", .path = kOthers[what - kOfMaps.size()]};
      if (choices_.below(2) == 1) call.query = {{"limit", "1"}, {"page_token", choices_.text(3)}};
      answer(call);
    } else if (const KnownSession* const known = session()) {
      answer({.method = "GET", .path = "/v1/sessions/" + known->id + "/history"});
    }
  }

  void put_trajectory() {
    const std::string path = map_path() + "/trajectory";
    static constexpr std::array<double, 4> kShifts{0.0, 0.3, 1e4, -1e8};
    const double shift = kShifts[choices_.below(4)];
    const std::size_t step = 1 + choices_.below(4);
    Json poses = Json::array();
    for (std::size_t i = 0; i < kMapScans; i += step) {
      Json pose = drives().map[i].at("pose");
      pose["x"] = pose["x"].get<double>() + shift;
      pose["stamp"] = drives().map[i].at("stamp");
      poses.push_back(std::move(pose));
    }
    status_of("PUT", path, {{"poses", poses}});
  }

  void roll_back() {
    const std::string path = map_path() + "/rollback";
    status_of("POST", path, {{"revision", choices_.below(9)}});
  }

  void copy_map() {
    const bool is_a = choices_.below(2) == 0;
    const std::string from = is_a ? "/v1/maps/a/archive" : "/v1/maps/b/archive";
    Response archive = answer({.method = "GET", .path = from});
    if (archive.status != 200) return;
    if (choices_.below(4) == 1) archive.body = choices_.text(200);
    answer({.method = "POST",
            .path = choices_.below(2) == 0 ? from
                                           : (is_a ? "/v1/maps/b/archive" : "/v1/maps/a/archive"),
            .body = archive.body});
  }

  void put_grid() {
    const std::string path = map_path() + "/grid";
    const std::size_t width = 1 + choices_.below(80);
    const std::size_t height = 1 + choices_.below(80);
    std::string image = "P5 " + std::to_string(width) + " " + std::to_string(height) + " 255\n";
    const std::string pixels = choices_.text(32);
    for (std::size_t i = 0; i < width * height; ++i) {
      image +=
          pixels.empty() ? static_cast<char>(i % width < 2 ? 0 : 254) : pixels[i % pixels.size()];
    }
    answer({.method = "PUT",
            .path = path,
            .parts = {{"yaml",
                       "image: a.pgm\nresolution: 0.1\norigin: [1, 2, 0.5]\nnegate: 0\n"
                       "occupied_thresh: 0.65\nfree_thresh: 0.196\n"},
                      {"image", image}}});
  }

  void remove() {
    const std::size_t what = choices_.below(3);
    if (what == 0) {
      answer({.method = "DELETE", .path = map_path()});
    } else if (KnownSession* const known = session()) {
      require(answer({.method = "DELETE", .path = "/v1/sessions/" + known->id}).status == 204);
      sessions_.erase(sessions_.begin() + (known - sessions_.data()));
    }
  }

  /// All that a restart must not change.
  std::vector<std::string> state() {
    std::vector<std::string> bodies;
    for (const char* path :
         {"/v1/maps", "/v1/maps/a/features", "/v1/maps/b/features", "/v1/maps/a/grid.png",
          "/v1/maps/b/grid.png", "/v1/maps/a/revisions", "/v1/maps/b/revisions"}) {
      bodies.push_back(answer({.method = "GET", .path = path}).body);
    }
    for (const KnownSession& known : sessions_) {
      const Response response = answer({.method = "GET", .path = "/v1/sessions/" + known.id});
      require(response.status == 200);
      const Json session = Json::parse(response.body);
      require(session.at("expected") == known.expected);
      bodies.push_back(session.at("status").dump() + session.at("map_version").dump());
    }
    return bodies;
  }

  void restart() {
    const auto before = state();
    api_.reset();
    api_ = std::make_unique<fuzz::ApiUnderTest>(config_);
    require(state() == before);
  }

  Choices choices_;
  server::ServerConfig config_;
  std::unique_ptr<fuzz::ApiUnderTest> api_;
  std::vector<KnownSession> sessions_;
};

/// In memory, for this process alone.
const std::filesystem::path& directory() {
  static const std::filesystem::path path = "/dev/shm/cornerfix-calls-" + std::to_string(getpid());
  return path;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spdlog::set_level(spdlog::level::off);
  std::filesystem::create_directory(directory());
  Sequence({reinterpret_cast<const char*>(data), size}, directory()).run();
  std::filesystem::remove_all(directory());
  return 0;
}
