#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "evaluation/datasets/lidar_choice.hpp"
#include "evaluation/datasets/scan_limits.hpp"
#include "evaluation/datasets/scan_parser.hpp"

namespace cornerfix::evaluation {

namespace {

constexpr double kPi = std::numbers::pi;

/// A SICK LMS reports 81.9 m and a little less for "nothing there"; old messages do not say.
constexpr double kRangeMax = 80.0;

/// A laser pose this close to the odometry says no more than the odometry does: no one corrected
/// it.
constexpr double kSamePosition = 1e-4;  // [m]
constexpr double kSameHeading = 1e-4;   // [rad]

/// The blank-separated words of a line.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  std::string_view next() {
    const std::size_t begin = rest_.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    rest_.remove_prefix(begin);
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(word.size());
    return word;
  }

  template <typename Number>
  std::optional<Number> next_number() {
    const std::string_view word = next();
    Number number{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
    if (!std::isfinite(static_cast<double>(number))) return std::nullopt;
    return number;
  }

  /// A range; nan and inf, which converters from ROS write, are no return.
  std::optional<float> next_range() {
    const std::string_view word = next();
    float number = 0.0F;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
    return std::isfinite(number) ? number : std::numeric_limits<float>::quiet_NaN();
  }

  std::optional<Pose2> next_pose() {
    const auto x = next_number<double>();
    const auto y = next_number<double>();
    const auto yaw = next_number<double>();
    if (!x || !y || !yaw) return std::nullopt;
    return Pose2{*x, *y, wrap_angle(*yaw)};
  }

  /// How many words are left.
  [[nodiscard]] std::size_t count() const {
    Words rest(rest_);
    std::size_t words = 0;
    while (!rest.next().empty()) ++words;
    return words;
  }

 private:
  std::string_view rest_;
};

/// A laser that a message name stands for. The PARAM messages with its place on the robot begin
/// with `param_prefix`.
struct Laser {
  std::string_view message;
  std::string_view param_prefix;
  bool tells_its_geometry;  ///< Newer messages do.
  Pose2 T_robot_laser;
};

constexpr std::array kLasers = {
    Laser{"FLASER", "robot_frontlaser_", false, {}},
    Laser{"RLASER", "robot_rearlaser_", false, {0.0, 0.0, kPi}},
    Laser{"ROBOTLASER1", "robot_frontlaser_", true, {}},
    Laser{"ROBOTLASER2", "robot_rearlaser_", true, {0.0, 0.0, kPi}},
    Laser{"RAWLASER1", "robot_frontlaser_", true, {}},
    Laser{"RAWLASER2", "robot_rearlaser_", true, {0.0, 0.0, kPi}},
};

/// A scan in the logs that GMapping writes (.gfs).
constexpr std::string_view kGMappingScan = "LASER_READING";

const Laser* laser_of(std::string_view message) {
  const auto* const laser = std::find_if(
      kLasers.begin(), kLasers.end(), [&](const Laser& known) { return known.message == message; });
  return laser == kLasers.end() ? nullptr : laser;
}

/// How many messages of each name a log has.
class MessageCounts {
 public:
  void count(std::string_view message) {
    if (message.empty() || message.starts_with('#')) return;
    const auto known = counts_.find(message);
    if (known != counts_.end()) {
      ++known->second;
    } else if (counts_.size() < kMostNames) {
      counts_.emplace(message.substr(0, kLongestName), 1);
    }
  }

  /// "ODOM (120), RAWLASER3 (60)".
  [[nodiscard]] std::string text() const {
    std::string text;
    for (const auto& [name, count] : counts_) {
      text += (text.empty() ? "" : ", ") + name + " (" + std::to_string(count) + ")";
    }
    return text.empty() ? "none" : text;
  }

 private:
  static constexpr std::size_t kMostNames = 20;
  static constexpr std::size_t kLongestName = 40;

  std::map<std::string, std::size_t, std::less<>> counts_;
};

/// What PARAM messages have said so far.
struct Params {
  double range_max_m = kRangeMax;
  std::optional<double> field_of_view_rad;
  std::array<Pose2, 2> laser_offset;  ///< Front and rear, on the robot; headings without the turn.
};

/// Of the robot, from the ODOM messages.
struct Odometry {
  Pose2 T_odom_robot;
  double forward_m_per_s = 0.0;
  double turn_rad_per_s = 0.0;
  double stamp = 0.0;
};

bool is_same(const Pose2& a, const Pose2& b) {
  return distance(a, b) <= kSamePosition && angle_between(a, b) <= kSameHeading;
}

/// Old messages have no angles: half a turn unless a PARAM has them, with both ends when the number
/// of beams is odd.
LaserScan untold_lidar(std::size_t beams, const Params& params) {
  const double field_of_view = params.field_of_view_rad.value_or(kPi);
  LaserScan lidar;
  lidar.angle_min = -field_of_view / 2.0;
  lidar.angle_increment = field_of_view / static_cast<double>(beams % 2 == 0 ? beams : beams - 1);
  lidar.range_min = 0.0;
  lidar.range_max = params.range_max_m;
  return lidar;
}

/// Whether so many beams may be half a turn of a SICK LMS: a degree apart, a half or a quarter.
bool may_be_half_turn(std::size_t beams) {
  constexpr std::size_t kDegrees = 180;
  return beams % 2 == 0 ? kDegrees * 4 % beams == 0 : kDegrees * 4 % (beams - 1) == 0;
}

class CarmenParser final : public ScanParser {
 public:
  explicit CarmenParser(std::string lidar)
      : lidars_(lidar.empty() ? std::nullopt : std::optional(std::move(lidar))) {}

  Result<std::optional<LogScan>> parse(const std::string& line) override {
    Words words(line);
    const std::string_view message = words.next();
    messages_.count(message);
    if (message == "PARAM") {
      take_param(words);
    } else if (message == "ODOM") {
      if (!take_odometry(words)) return malformed(message, "expected x y theta tv rv accel stamp");
      return finish();
    } else if (message == kGMappingScan && is_wanted(message)) {
      return parse_gmapping(words);
    } else if (message == "SM_UPDATE" && matched_) {
      matched_->T_map_laser = best_particle(words);
      return finish();
    } else if (const Laser* laser = laser_of(message); laser != nullptr && is_wanted(message)) {
      Result<std::optional<LogScan>> scan =
          laser->tells_its_geometry ? parse_new(*laser, words) : parse_old(*laser, words);
      if (scan && *scan) lidars_.take(std::string(message));
      return scan;
    }
    return std::optional<LogScan>();
  }

  std::optional<LogScan> finish() override { return std::exchange(matched_, std::nullopt); }

  [[nodiscard]] std::string choice() const override { return lidars_.choice(); }

  [[nodiscard]] std::string assumption() const override { return assumption_; }

  [[nodiscard]] std::string contents() const override {
    return "its messages are " + messages_.text() + "; expected " + std::string(kGMappingScan) +
           ", FLASER, RLASER, ROBOTLASER1, ROBOTLASER2, RAWLASER1 or RAWLASER2";
  }

 private:
  static constexpr std::size_t kLongestWord = 20;
  /// Two poses, timestamp, host and logger_timestamp.
  static constexpr std::size_t kMostWordsBehindRanges = 9;

  static Error malformed(std::string_view message, const std::string& what) {
    return {ErrorCode::kMalformed, std::string(message) + ": " + what, ""};
  }

  [[nodiscard]] bool is_wanted(std::string_view message) {
    return lidars_.is_wanted(std::string(message));
  }

  /// name value; those without a laser's settings are passed over.
  void take_param(Words& words) {
    const std::string_view name = words.next();
    const auto value = words.next_number<double>();
    if (!value) return;
    if (name == "robot_front_laser_max" && *value > 0.0) {
      params_.range_max_m = std::min(kRangeMax, *value);
    } else if (name == "laser_front_laser_fov" && *value > 0.0 && *value <= 360.0) {
      params_.field_of_view_rad = *value * kPi / 180.0;
    }
    for (std::size_t i = 0; i < params_.laser_offset.size(); ++i) {
      const std::string_view prefix = kLasers[i].param_prefix;
      if (!name.starts_with(prefix)) continue;
      const std::string_view which = name.substr(prefix.size());
      if (which == "offset") params_.laser_offset[i].x = *value;
      if (which == "side_offset") params_.laser_offset[i].y = *value;
      if (which == "angular_offset") params_.laser_offset[i].yaw = *value;
    }
  }

  /// x y theta tv rv accel ipc_timestamp; of GMapping x y theta timestamp.
  bool take_odometry(Words& words) {
    constexpr std::size_t kOfGMapping = 4;
    const bool is_of_gmapping = words.count() == kOfGMapping;
    const auto pose = words.next_pose();
    if (is_of_gmapping) {
      const auto stamp = words.next_number<double>();
      if (!pose || !stamp) return false;
      odometry_ = Odometry{*pose, 0.0, 0.0, *stamp};
      return true;
    }
    const auto forward = words.next_number<double>();
    const auto turn = words.next_number<double>();
    const auto acceleration = words.next_number<double>();
    const auto stamp = words.next_number<double>();
    if (!pose || !forward || !turn || !acceleration || !stamp) return false;
    odometry_ = Odometry{*pose, *forward, *turn, *stamp};
    return true;
  }

  void note_field_of_view(std::string_view message, std::size_t beams) {
    if (params_.field_of_view_rad || may_be_half_turn(beams) || !assumption_.empty()) return;
    assumption_ = std::string(message) + " has no angles: its " + std::to_string(beams) +
                  " beams are taken for half a turn; a line PARAM laser_front_laser_fov 270 in "
                  "front would state another field of view in degrees";
  }

  [[nodiscard]] Pose2 T_robot_laser(const Laser& laser) const {
    const std::size_t place = laser.param_prefix == kLasers[0].param_prefix ? 0 : 1;
    return params_.laser_offset[place] * laser.T_robot_laser;
  }

  /// num_readings [ranges] x y theta odom_x odom_y odom_theta ipc_timestamp, then host and
  /// logger_timestamp, which are not needed. The first pose is the laser's, the second the robot's.
  Result<std::optional<LogScan>> parse_old(const Laser& laser, Words& words) {
    LogScan out;
    const auto beams = words.next_number<std::size_t>();
    if (auto error = check_beams(laser, beams)) return *error;
    out.scan = untold_lidar(*beams, params_);
    note_field_of_view(laser.message, *beams);
    if (auto error = read_ranges(laser, words, *beams, out.scan)) return *error;
    if (words.count() > kMostWordsBehindRanges) {
      return malformed(laser.message, std::to_string(words.count()) + " words behind " +
                                          std::to_string(*beams) + " ranges, expected at most " +
                                          std::to_string(kMostWordsBehindRanges) +
                                          ": is num_readings too small?");
    }
    const auto T_map_laser = words.next_pose();
    if (!T_map_laser) return malformed(laser.message, "expected x y theta of the laser");
    const auto T_odom_robot = words.next_pose();
    if (!T_odom_robot) return malformed(laser.message, "expected odom_x odom_y odom_theta");
    const auto stamp = words.next_number<double>();
    if (!stamp) return malformed(laser.message, "expected a timestamp");
    out.scan.stamp = *stamp;
    out.T_odom_laser = *T_odom_robot * T_robot_laser(laser);
    // Without a PARAM that has the laser's place some logs give both poses of the laser.
    if (!is_same(*T_map_laser, *out.T_odom_laser) && !is_same(*T_map_laser, *T_odom_robot)) {
      out.T_map_laser = T_map_laser;
    }
    return check(laser, std::move(out));
  }

  /// num_readings [ranges] x y theta timestamp, as GMapping writes it; the pose is not needed
  /// beside ODOM. The scan waits for the SM_UPDATE that says where scan matching found the robot.
  Result<std::optional<LogScan>> parse_gmapping(Words& words) {
    constexpr Laser kLaser{kGMappingScan, "robot_frontlaser_", false, {}};
    LogScan out;
    const auto beams = words.next_number<std::size_t>();
    if (auto error = check_beams(kLaser, beams)) return *error;
    out.scan = untold_lidar(*beams, params_);
    note_field_of_view(kGMappingScan, *beams);
    if (auto error = read_ranges(kLaser, words, *beams, out.scan)) return *error;
    const auto T_odom_robot = words.next_pose();
    const auto stamp = words.next_number<double>();
    if (!T_odom_robot || !stamp) return malformed(kGMappingScan, "expected x y theta timestamp");
    out.scan.stamp = *stamp;
    out.T_odom_laser = odometry_ ? odometry_->T_odom_robot : *T_odom_robot;
    Result<std::optional<LogScan>> scan = check(kLaser, std::move(out));
    if (!scan) return scan;
    lidars_.take(std::string(kGMappingScan));
    std::swap(matched_, *scan);
    return scan;
  }

  /// num_particles [x y theta log_weight] timestamp: the pose of the greatest weight.
  static std::optional<Pose2> best_particle(Words& words) {
    const auto particles = words.next_number<std::size_t>();
    std::optional<Pose2> best;
    double best_weight = 0.0;
    for (std::size_t i = 0; particles && i < *particles; ++i) {
      const auto pose = words.next_pose();
      const auto weight = words.next_number<double>();
      if (!pose || !weight) return std::nullopt;
      if (best && *weight <= best_weight) continue;
      best = pose;
      best_weight = *weight;
    }
    return best;
  }

  /// laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode
  /// num_readings [ranges] num_remissions [remissions], and for ROBOTLASER laser pose, robot pose,
  /// laser_tv laser_rv forward_safety_dist side_safety_dist turn_axis; then the timestamp. Logs
  /// with an older header have neither remissions nor turn_axis.
  Result<std::optional<LogScan>> parse_new(const Laser& laser, Words& words) {
    LogScan out;
    words.next();
    const auto start_angle = words.next_number<double>();
    const auto field_of_view = words.next_number<double>();
    const auto resolution = words.next_number<double>();
    const auto maximum_range = words.next_number<double>();
    words.next();
    words.next();
    if (!start_angle || !field_of_view || !resolution || !maximum_range) {
      return malformed(laser.message,
                       "expected laser_type start_angle field_of_view angular_resolution "
                       "maximum_range accuracy remission_mode");
    }
    const auto beams = words.next_number<std::size_t>();
    if (auto error = check_beams(laser, beams)) return *error;
    out.scan.angle_min = *start_angle;
    out.scan.angle_increment =
        *resolution != 0.0 ? *resolution : *field_of_view / static_cast<double>(*beams - 1);
    if (*field_of_view > 0.0) out.stated_angle_max = *start_angle + *field_of_view;
    out.scan.range_max = *maximum_range > 0.0 ? *maximum_range : params_.range_max_m;
    if (auto error = read_ranges(laser, words, *beams, out.scan)) return *error;
    const bool has_poses = laser.message.starts_with("ROBOT");
    if (!skip_remissions(words, has_poses)) {
      return malformed(laser.message, "expected num_remissions and as many remissions");
    }
    if (has_poses) {
      out.T_odom_laser = words.next_pose();
      if (!out.T_odom_laser || !words.next_pose()) {
        return malformed(laser.message, "expected the poses of laser and robot");
      }
    }
    const auto stamp = read_new_stamp(words);
    if (!stamp) return malformed(laser.message, "expected a timestamp");
    out.scan.stamp = *stamp;
    if (!has_poses) out.T_odom_laser = odometry_at(*stamp, laser);
    return check(laser, std::move(out));
  }

  /// True when what follows are the poses or the timestamp.
  static bool skip_remissions(Words& words, bool has_poses) {
    constexpr std::size_t kStamps = 3;
    constexpr std::size_t kPosesAndSpeeds = 6 + 4;  // speeds and safety distances
    if (words.count() == kStamps + (has_poses ? kPosesAndSpeeds : 0)) return true;
    const auto remissions = words.next_number<std::size_t>();
    if (!remissions || *remissions > LogReader::kMaxBeams) return false;
    for (std::size_t i = 0; i < *remissions; ++i) {
      if (words.next().empty()) return false;
    }
    return true;
  }

  /// The last but two of the words.
  static std::optional<double> read_new_stamp(Words& words) {
    std::size_t rest = words.count();
    if (rest < 3) return std::nullopt;
    for (; rest > 3; --rest) words.next();
    return words.next_number<double>();
  }

  /// The last ODOM carried on at its speed.
  [[nodiscard]] std::optional<Pose2> odometry_at(double stamp, const Laser& laser) const {
    constexpr double kMaxAge = 1.0;  // [s]
    if (!odometry_ || std::abs(stamp - odometry_->stamp) > kMaxAge) return std::nullopt;
    const double seconds = stamp - odometry_->stamp;
    const double turn = odometry_->turn_rad_per_s * seconds;
    const double forward = odometry_->forward_m_per_s * seconds;
    const Pose2 motion{forward * std::cos(turn / 2.0), forward * std::sin(turn / 2.0), turn};
    return odometry_->T_odom_robot * motion * T_robot_laser(laser);
  }

  [[nodiscard]] static std::optional<Error> check_beams(const Laser& laser,
                                                        std::optional<std::size_t> beams) {
    if (!beams || *beams < 2 || *beams > LogReader::kMaxBeams) {
      return malformed(laser.message, "expected a number of beams from 2 to " +
                                          std::to_string(LogReader::kMaxBeams));
    }
    return std::nullopt;
  }

  /// Reads the ranges, or says which is none.
  static std::optional<Error> read_ranges(const Laser& laser, Words& words, std::size_t beams,
                                          LaserScan& scan) {
    scan.ranges.reserve(beams);
    for (std::size_t beam = 0; beam < beams; ++beam) {
      Words here = words;
      const auto range = words.next_range();
      if (!range) {
        const std::string word(here.next().substr(0, kLongestWord));
        const std::string found = word.empty() ? "the line ends" : "\"" + word + "\" is none";
        return malformed(laser.message, "expected " + std::to_string(beams) +
                                            " ranges in metres, with a point; at range " +
                                            std::to_string(beam) + " " + found);
      }
      scan.ranges.push_back(*range);
    }
    return std::nullopt;
  }

  /// The first good scan makes the header.
  Result<std::optional<LogScan>> check(const Laser& laser, LogScan scan) {
    if (cut_to_full_turn(scan.scan)) scan.stated_angle_max.reset();
    if (const auto error = validate(scan.scan)) {
      return malformed(laser.message, error->field + ": " + error->message);
    }
    if (const auto error = find_value_beyond_limits(scan)) {
      return malformed(laser.message, error->field + ": " + error->message);
    }
    if (header_.beams == 0) set_lidar(header_, scan.scan);
    return std::optional<LogScan>(std::move(scan));
  }

  LidarChoice lidars_;  ///< By message.
  MessageCounts messages_;
  Params params_;
  std::optional<Odometry> odometry_;
  std::optional<LogScan> matched_;  ///< Of GMapping, until its SM_UPDATE.
  std::string assumption_;
};

}  // namespace

std::unique_ptr<ScanParser> make_carmen_parser(std::string lidar) {
  return std::make_unique<CarmenParser>(std::move(lidar));
}

}  // namespace cornerfix::evaluation
