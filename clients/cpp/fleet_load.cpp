#include "clients/cpp/fleet_load.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "clients/cpp/http_client.hpp"
#include "clients/cpp/scan_json.hpp"

namespace cornerfix::client {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;
using Milliseconds = std::chrono::duration<double, std::milli>;

Clock::duration duration_of(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
}

/// The scans of a log, rendered once: a stamp is all that changes from one use to the next.
class FleetScans {
 public:
  explicit FleetScans(const evaluation::RecordedLog& log) : lidar_(lidar_json(log.header)) {
    for (const evaluation::LogScan& scan : log.scans) {
      nlohmann::ordered_json json = robot_scan_json(log.header, scan, true);
      json.erase("stamp");
      scans_.push_back(json.dump().substr(1));
    }
  }

  [[nodiscard]] const nlohmann::ordered_json& lidar() const { return lidar_; }
  [[nodiscard]] std::size_t size() const { return scans_.size(); }

  /// Scan `number` of a robot that goes back at the end of the log and again at its beginning.
  void append(std::string& body, std::size_t number, double stamp) const {
    const std::size_t period = std::max<std::size_t>(1, 2 * scans_.size() - 2);
    const std::size_t step = number % period;
    const std::size_t at = step < scans_.size() ? step : period - step;
    body.append("{\"stamp\":").append(std::to_string(stamp)).append(",").append(scans_[at]);
  }

 private:
  nlohmann::ordered_json lidar_;
  std::vector<std::string> scans_;  ///< Without "{" and the stamp.
};

struct Schedule {
  Clock::time_point first;   ///< Of this robot.
  Clock::time_point steady;  ///< All robots are on.
  Clock::time_point end;
  Clock::duration period{};
};

/// One robot on a connection of its own.
class LoadRobot {
 public:
  LoadRobot(HttpClient client, const FleetOptions& options, const FleetScans& scans,
            std::size_t number)
      : client_(std::move(client)),
        options_(options),
        scans_(scans),
        number_(number),
        next_scan_(number * 2 * scans.size() / options.robots),
        is_searching_(static_cast<double>(number) <
                      options.searching * static_cast<double>(options.robots)) {}

  [[nodiscard]] bool is_searching() const { return is_searching_; }
  [[nodiscard]] const BatchTally& ramp() const { return ramp_; }
  [[nodiscard]] const BatchTally& steady() const { return steady_; }

  void run(const Schedule& schedule) {
    std::this_thread::sleep_until(schedule.first);
    for (Clock::time_point due = schedule.first; due < schedule.end; due += schedule.period) {
      std::this_thread::sleep_until(due);
      post_batch(due, schedule.period, due < schedule.steady ? ramp_ : steady_);
    }
    if (!session_.empty()) (void)client_.ask({.method = "DELETE", .path = session_});
  }

 private:
  bool open_session() {
    nlohmann::ordered_json body = {{"robot", options_.robot_prefix + "-" + std::to_string(number_)},
                                   {"lidar", scans_.lidar()}};
    if (!options_.map.empty()) body["map"] = options_.map;
    const auto reply = client_.ask(
        {.method = "POST", .path = "/v1/sessions", .body = body.dump(), .creates_session = true});
    if (!reply || reply->status != 201) return false;
    const auto session = nlohmann::json::parse(reply->body, nullptr, false);
    session_ = "/v1/sessions/" + session.value("id", "");
    return true;
  }

  std::string next_body() {
    std::string body = "{\"sequence\":" + std::to_string(sequence_) + ",\"scans\":[";
    for (std::size_t i = 0; i < options_.batch; ++i) {
      if (i > 0) body += ',';
      stamp_ += 1.0 / (options_.batches_per_s * static_cast<double>(options_.batch));
      scans_.append(body, next_scan_++, stamp_);
    }
    return body += "]}";
  }

  void post_batch(Clock::time_point due, Clock::duration period, BatchTally& tally) {
    ++tally.offered;
    const std::string body = next_body();
    const bool is_on = !session_.empty() || open_session();
    std::optional<HttpReply> reply;
    if (is_on) {
      auto answer = client_.ask({.method = "POST", .path = session_ + "/scans", .body = body});
      if (answer) reply = std::move(*answer);
    }
    const Clock::duration latency = Clock::now() - due;
    const int status = reply ? reply->status : 0;
    if (status == 200) {
      ++sequence_;
      ++tally.served;
      tally.late += latency > period ? 1 : 0;
      tally.latencies_ms.push_back(Milliseconds(latency).count());
      const bool is_localized = reply->body.find("\"localized\"") != std::string::npos;
      tally.localized += is_localized ? 1 : 0;
      if (is_searching_ && is_localized)
        (void)client_.ask({.method = "POST", .path = session_ + "/reset"});
    } else if (status == 429 || status == 503) {
      ++tally.shed;
    } else {
      ++tally.failed;
      ++tally.other_statuses[status];
    }
  }

  HttpClient client_;
  const FleetOptions& options_;
  const FleetScans& scans_;
  std::size_t number_;
  std::size_t next_scan_;
  bool is_searching_;
  std::string session_;  ///< Its path.
  std::size_t sequence_ = 0;
  double stamp_ = 1000.0;
  BatchTally ramp_;
  BatchTally steady_;
};

/// Processor time of the server's process by its metrics; 0 when it does not say.
double server_cpu_s(HttpClient& client) {
  constexpr std::string_view kName = "\nprocess_cpu_seconds_total ";
  const auto reply = client.ask({.method = "GET", .path = "/metrics"});
  if (!reply) return 0.0;
  const auto at = reply->body.find(kName);
  return at == std::string::npos ? 0.0
                                 : std::strtod(reply->body.c_str() + at + kName.size(), nullptr);
}

Result<std::vector<LoadRobot>> make_robots(const FleetOptions& options, const FleetScans& scans) {
  std::vector<LoadRobot> robots;
  robots.reserve(options.robots);
  for (std::size_t i = 0; i < options.robots; ++i) {
    Result<HttpClient> client = HttpClient::create(options.server);
    if (!client) return client.error();
    robots.emplace_back(std::move(*client), options, scans, i);
  }
  return robots;
}

}  // namespace

void BatchTally::add(const BatchTally& other) {
  offered += other.offered;
  served += other.served;
  late += other.late;
  shed += other.shed;
  failed += other.failed;
  localized += other.localized;
  latencies_ms.insert(latencies_ms.end(), other.latencies_ms.begin(), other.latencies_ms.end());
  for (const auto& [status, count] : other.other_statuses) other_statuses[status] += count;
}

Result<FleetReport> run_fleet(const FleetOptions& options, const evaluation::RecordedLog& log) {
  Result<HttpClient> observer = HttpClient::create(options.server);
  if (!observer) return observer.error();
  if (auto alive = observer->send({.method = "GET", .path = "/healthz"}); !alive)
    return alive.error();
  const FleetScans scans(log);
  Result<std::vector<LoadRobot>> robots = make_robots(options, scans);
  if (!robots) return robots.error();

  const Clock::duration period = duration_of(1.0 / options.batches_per_s);
  const Clock::duration spread = std::max(duration_of(options.ramp_s), period);
  const auto start = Clock::now();
  const auto steady = start + spread + period;
  const auto end = steady + duration_of(options.seconds);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < robots->size(); ++i) {
    const auto first = start + spread * static_cast<long>(i) / static_cast<long>(options.robots);
    threads.emplace_back([&robot = (*robots)[i], schedule = Schedule{first, steady, end, period}] {
      robot.run(schedule);
    });
  }
  std::this_thread::sleep_until(steady);
  const double cpu_before_s = server_cpu_s(*observer);
  std::this_thread::sleep_until(end);
  FleetReport report;
  report.server_cpu_s = server_cpu_s(*observer) - cpu_before_s;
  for (std::thread& thread : threads) thread.join();
  for (const LoadRobot& robot : *robots) {
    report.ramp.add(robot.ramp());
    (robot.is_searching() ? report.searching : report.tracking).add(robot.steady());
  }
  return report;
}

}  // namespace cornerfix::client
