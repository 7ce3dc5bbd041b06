#include "api/scan_batch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/batch_straightening.hpp"
#include "api/ros_odometry.hpp"

namespace cornerfix::api {
namespace {

constexpr std::uint64_t kMaxLidarBeams = 1'000'000;
constexpr double kNanosecond = 1e-9;
constexpr double kMaxTilt = 0.175;  // [rad]
constexpr std::size_t kMaxLidars = 16;
constexpr const char* kNameRule = "[A-Za-z0-9][A-Za-z0-9._-]{0,127}";

/// std_msgs/Header; only the stamp is used.
constexpr std::array<std::string_view, 3> kHeaderMembers{"seq", "stamp", "frame_id"};

struct GeometryMember {
  const char* name;
  const char* meaning;
  double LaserScan::*member;
};
constexpr std::array<GeometryMember, 4> kGeometry{{
    {"angle_min", "the first beam's angle in radians", &LaserScan::angle_min},
    {"angle_increment", "radians from beam to beam", &LaserScan::angle_increment},
    {"range_min", "the shortest range in metres", &LaserScan::range_min},
    {"range_max", "the longest range in metres, null for no limit", &LaserScan::range_max},
}};

LaserScan geometry_of(const Lidar& lidar) {
  return {.stamp = 0.0,
          .angle_min = lidar.angle_min,
          .angle_increment = lidar.angle_increment,
          .range_min = lidar.range_min,
          .range_max = lidar.range_max,
          .ranges = {}};
}

/// {secs, nsecs} of ROS 1 or {sec, nanosec} of ROS 2.
std::optional<double> read_ros_stamp(const JsonField& stamp) {
  if (!stamp.expect_object()) return std::nullopt;
  const auto ros1 = stamp.find("secs");
  if (ros1) {
    stamp.expect_members({"secs", "nsecs"});
  } else {
    stamp.expect_members({"sec", "nanosec"});
  }
  const auto seconds_field = ros1 ? ros1 : stamp.require("sec", "seconds, with nanosec");
  if (!seconds_field) return std::nullopt;
  const auto nanoseconds_field = stamp.find(ros1 ? "nsecs" : "nanosec");
  const auto seconds = seconds_field->as_stamp();
  const auto nanoseconds =
      nanoseconds_field ? nanoseconds_field->as_count(0, 999'999'999) : std::uint64_t{0};
  if (!seconds || !nanoseconds) return std::nullopt;
  return *seconds + kNanosecond * static_cast<double>(*nanoseconds);
}

/// The stamp of a scan's header, if it has one, or nothing after an error.
std::optional<double> read_header_stamp(const JsonField& header, bool is_needed) {
  if (!header.expect_object()) return std::nullopt;
  header.expect_members(kHeaderMembers);
  constexpr const char* kMeaning = "{secs, nsecs} or {sec, nanosec}";
  const auto stamp = is_needed ? header.require("stamp", kMeaning) : header.find("stamp");
  return stamp ? read_ros_stamp(*stamp) : std::nullopt;
}

/// `stamp`, or else that of the header. Both may be there when they are the same time.
std::optional<double> read_stamp(const JsonField& scan) {
  constexpr double kSameStamp = 1e-3;  // [s]
  const auto header = scan.find("header");
  const auto own = scan.find("stamp");
  const auto of_header = header ? read_header_stamp(*header, !own) : std::nullopt;
  if (!own && !header) scan.fail_member("stamp", "is needed: seconds");
  if (!own) return of_header;
  const auto stamp = own->as_stamp();
  if (stamp && of_header && !(std::abs(*stamp - *of_header) <= kSameStamp)) {
    own->fail("must be the time of header.stamp, or one of the two must not be there");
    return std::nullopt;
  }
  return stamp;
}

/// Whether a scan brings its own angles, and with them its own number of ranges.
bool has_own_angles(const nlohmann::json& scan) {
  const auto is_given = [&](const char* name) {
    return scan.contains(name) && !scan[name].is_null();
  };
  return scan.is_object() && (is_given("angle_min") || is_given("angle_increment"));
}

/// Whether `object` says that its lidar has no limit: JSON has no infinity, so that rosbridge
/// writes null; CBOR and MessagePack have it. A null without angles beside it is as if it were not
/// there.
bool has_infinite_range(const JsonField& object, bool is_lidar) {
  const auto found = object.json().find("range_max");
  if (found == object.json().end()) return false;
  if (found->is_null()) return is_lidar || has_own_angles(object.json());
  return found->is_number() && found->get<double>() == std::numeric_limits<double>::infinity();
}

/// The scan's own angles and ranges override the lidar's; without a lidar it must have them.
bool read_geometry(const JsonField& scan, bool has_lidar, LaserScan& geometry) {
  bool good = true;
  for (const auto& [name, meaning, member] : kGeometry) {
    if (member == &LaserScan::range_max && has_infinite_range(scan, !has_lidar)) {
      geometry.range_max = std::numeric_limits<double>::infinity();
      continue;
    }
    const auto field = has_lidar ? scan.find(name) : scan.require(name, meaning);
    const auto number = field ? field->as_number() : std::nullopt;
    if (number) geometry.*member = *number;
    good = good && (number || (has_lidar && !field));
  }
  return good;
}

/// Whether the time from beam to beam is a number or not there.
bool read_time_increment(const JsonField& object, double& time_increment) {
  const auto field = object.find("time_increment");
  const auto number = field ? field->as_number() : std::nullopt;
  if (number) time_increment = *number;
  return !field || number;
}

/// Whether a scan of so many beams can have been taken with the time from beam to beam that
/// `object` gives.
bool check_time_increment(const JsonField& object, double time_increment, std::size_t beams) {
  constexpr double kLongestScan = 10.0;  // [s]; lidars take a second at most.
  const double seconds = std::abs(time_increment) * static_cast<double>(beams);
  if (seconds <= kLongestScan || !object.find("time_increment")) return true;
  const nlohmann::json scan_seconds = seconds;
  object.fail_member("time_increment",
                     "must be seconds from beam to beam: " + std::to_string(beams) +
                         " beams would take " + scan_seconds.dump() + " s, expected at most 10 s");
  return false;
}

/// Whether there is a pose or need not be one.
bool read_pose(const JsonField& scan, const char* name, std::optional<Pose2>& pose) {
  const auto field = scan.find(name);
  if (field) pose = field->as_pose();
  if (pose) field->expect_members({"x", "y", "yaw"});
  return !field || pose;
}

/// How a laser is mounted. Tilts of more than kMaxTilt are refused, since they project badly.
struct Mount {
  Pose2 T_base_link_laser;
  LidarTilt tilt;
};

/// An angle within kMaxTilt of 0, or of pi where the laser may hang upside down; 0 when it is not
/// there.
double read_tilt(const JsonField& mount, const char* name, bool may_hang) {
  const auto field = mount.find(name);
  const auto angle = field ? field->as_number() : std::nullopt;
  if (!angle) return 0.0;
  const double from_level = std::abs(wrap_angle(*angle));
  const bool hangs = may_hang && std::numbers::pi - from_level <= kMaxTilt;
  if (from_level > kMaxTilt && !hangs) {
    field->fail(std::string("must be within 0.175 rad (10 deg) of 0") +
                (may_hang ? " or of pi" : ""));
  }
  return wrap_angle(*angle);
}

/// Whether there is a mount or need not be one.
bool read_mount(const JsonField& object, Mount& mount) {
  const auto field = object.find("mount");
  const auto pose = field ? field->as_pose() : std::nullopt;
  if (!pose) return !field;
  mount.T_base_link_laser = *pose;
  mount.tilt = {.roll = read_tilt(*field, "roll", true),
                .pitch = read_tilt(*field, "pitch", false)};
  field->expect_members({"x", "y", "yaw", "roll", "pitch"});
  return true;
}

/// Fails a mount in millimetres or degrees. Stored ones are not checked.
void check_mount(const JsonField& object) {
  constexpr double kLargestRobot = 100.0;  // [m]
  const auto mount = object.find("mount");
  if (!mount || !mount->json().is_object()) return;
  for (const char* name : {"x", "y"}) {
    const auto field = mount->find(name);
    if (field && field->json().is_number()) (void)field->as_number(-kLargestRobot, kLargestRobot);
  }
  for (const char* name : {"yaw", "roll", "pitch"}) {
    const auto field = mount->find(name);
    if (field && field->json().is_number()) (void)field->as_heading();
  }
}

/// The same for odometry, which may also be a nav_msgs/Odometry.
bool read_odometry(const JsonField& scan, std::optional<Pose2>& pose) {
  const auto field = scan.find("odom");
  if (!field || !is_ros_odometry(field->json())) return read_pose(scan, "odom", pose);
  pose = read_ros_odometry(*field);
  return pose.has_value();
}

/// The members of a scan: ours, and those of sensor_msgs/LaserScan, also the unused ones.
void expect_scan_members(const JsonField& scan, MapPose map_pose, bool has_named_lidars) {
  std::vector<std::string_view> known = {
      "stamp",      "ranges",          "odom",           "mount",     "header",    "angle_min",
      "angle_max",  "angle_increment", "time_increment", "scan_time", "range_min", "range_max",
      "intensities"};
  if (map_pose == MapPose::kTaken) known.emplace_back("pose");
  if (has_named_lidars) known.emplace_back("lidar");
  scan.expect_members(known);
}

class BatchReader {
 public:
  BatchReader(Document& document, ScanBatch& batch, const Lidars& lidars, StampOrder order,
              MapPose map_pose)
      : document_(document), batch_(batch), lidars_(lidars), order_(order), map_pose_(map_pose) {}

  void read(const JsonField& scans) {
    const std::size_t count = scans.json().size();
    batch_.scans.resize(count);
    document_.ranges.resize(count);
    for (std::size_t i = 0; i < count; ++i) read_scan(scans.item(i), i);
  }

 private:
  void read_scan(const JsonField& field, std::size_t index) {
    if (!field.expect_object()) return;
    BatchScan& out = batch_.scans[index];
    const Lidar* lidar = batch_.lidar ? &*batch_.lidar : nullptr;
    std::string lidar_name;
    if (!lidars_.by_name.empty() && !read_name(field, lidar, lidar_name)) return;
    Mount mount;
    if (lidar != nullptr) {
      out.scan = geometry_of(*lidar);
      out.time_increment = lidar->time_increment;
      mount = {lidar->T_base_link_laser, lidar->tilt};
    }
    const auto stamp = read_stamp(field);
    if (stamp) check_order(field, lidar_name, *stamp);
    bool good = stamp.has_value();
    expect_scan_members(field, map_pose_, !lidars_.by_name.empty());
    out.scan.stamp = stamp.value_or(0.0);
    good &= read_geometry(field, lidar != nullptr, out.scan);
    good &= read_ranges(field, index, lidar, out.scan);
    good &= read_time_increment(field, out.time_increment);
    good &= check_time_increment(field, out.time_increment, out.scan.ranges.size());
    good &= read_mount(field, mount);
    check_mount(field);
    out.T_base_link_laser = mount.T_base_link_laser;
    good &= read_odometry(field, out.T_odom_base_link);
    if (map_pose_ == MapPose::kTaken) good &= read_pose(field, "pose", out.T_map_base_link);
    if (good) cut_to_full_turn(out.scan);
    if (const auto error = good ? validate(out.scan) : std::nullopt) {
      field.fail_member(error->field, error->message);
    } else if (good && mount.tilt != LidarTilt{}) {
      out.scan = levelled(out.scan, mount.tilt);
    }
  }

  /// The session's lidar that the scan names.
  bool read_name(const JsonField& field, const Lidar*& lidar, std::string& name) const {
    const auto member = field.require("lidar", "the name of a lidar of the session");
    if (!member) return false;
    const auto* text = member->json().get_ptr<const std::string*>();
    const auto found = text != nullptr ? lidars_.by_name.find(*text) : lidars_.by_name.end();
    if (found == lidars_.by_name.end()) {
      std::string names;
      for (const auto& [known, unused] : lidars_.by_name)
        names += (names.empty() ? "" : ", ") + known;
      member->fail("must be a lidar of the session: " + names);
      return false;
    }
    lidar = &found->second;
    name = found->first;
    return true;
  }

  void check_order(const JsonField& field, const std::string& lidar_name, double stamp) {
    const auto last = last_stamps_.find(lidar_name);
    if (order_ == StampOrder::kIncreasing && last != last_stamps_.end() && stamp <= last->second) {
      field.fail_member("stamp", lidar_name.empty()
                                     ? "must be later than the scan's before it"
                                     : "must be later than that of the lidar's scan before it");
    }
    last_stamps_[lidar_name] = stamp;
  }

  bool read_ranges(const JsonField& field, std::size_t index, const Lidar* lidar, LaserScan& scan) {
    const auto ranges = field.require("ranges", "metres, or null for no return");
    if (!ranges) return false;
    if (!ranges->json().is_array()) {
      ranges->fail("must be an array of metres, null for no return");
      return false;
    }
    scan.ranges = std::move(document_.ranges[index]);
    if (scan.ranges.empty()) {
      ranges->fail("must have at least one value");
      return false;
    }
    const bool is_of_lidar = lidar != nullptr && !has_own_angles(field.json());
    const auto expected = is_of_lidar ? lidar->beams : std::nullopt;
    if (!expected || scan.ranges.size() == *expected) return true;
    ranges->fail(std::to_string(scan.ranges.size()) + " values, expected " +
                 std::to_string(*expected) + " (from lidar.beams)");
    return false;
  }

  Document& document_;
  ScanBatch& batch_;
  const Lidars& lidars_;
  StampOrder order_;
  MapPose map_pose_;
  std::map<std::string, double> last_stamps_;  ///< By the lidar's name.
};

/// Whether `lidar` is `known`, which may have `beams` besides.
bool same_but_beams(Lidar lidar, const Lidar& known) {
  lidar.beams = known.beams;
  return lidar == known;
}

/// The body's lidar or else that of `lidars`; false when the body's is wrong.
bool choose_lidar(const JsonField& body, const Lidars& lidars, std::optional<Lidar>& chosen) {
  const std::optional<Lidar>& known = lidars.only;
  chosen = known;
  const auto field = body.find("lidar");
  if (!field) return true;
  if (!lidars.by_name.empty()) {
    field->fail("must not be there: each scan names a lidar of the session");
    return false;
  }
  check_lidar(*field);
  chosen = read_lidar(*field);
  if (chosen && !chosen->beams && known && same_but_beams(*chosen, *known)) chosen = known;
  return chosen.has_value();
}

}  // namespace

std::optional<Lidar> read_lidar(const JsonField& field) {
  if (!field.expect_object()) return std::nullopt;
  Lidar lidar;
  LaserScan geometry;
  bool good = read_geometry(field, false, geometry);
  if (const auto beams = field.find("beams")) {
    const auto count = beams->as_count(1, kMaxLidarBeams);
    good &= count.has_value();
    if (count) lidar.beams = static_cast<std::size_t>(*count);
  }
  Mount mount;
  good &= read_mount(field, mount);
  good &= read_time_increment(field, lidar.time_increment);
  field.expect_members({"angle_min", "angle_max", "angle_increment", "time_increment", "scan_time",
                        "range_min", "range_max", "beams", "mount"});
  if (!good) return std::nullopt;
  geometry.ranges.resize(lidar.beams.value_or(0));
  cut_to_full_turn(geometry);
  if (const auto error = validate(geometry)) {
    field.fail_member(error->field == "ranges" ? "beams" : error->field, error->message);
    return std::nullopt;
  }
  lidar.angle_min = geometry.angle_min;
  lidar.angle_increment = geometry.angle_increment;
  lidar.range_min = geometry.range_min;
  lidar.range_max = geometry.range_max;
  lidar.T_base_link_laser = mount.T_base_link_laser;
  lidar.tilt = mount.tilt;
  return lidar;
}

void check_lidar(const JsonField& field) {
  if (!field.json().is_object()) return;
  check_mount(field);
  constexpr std::size_t kFewestBeams = 16;  // where it is not given
  const auto increment = field.find("time_increment");
  if (!increment || !increment->json().is_number()) return;
  const auto beams = field.find("beams");
  const bool is_given = beams && beams->json().is_number_integer() && beams->json() > 0;
  check_time_increment(field, increment->json().get<double>(),
                       is_given ? beams->json().get<std::size_t>() : kFewestBeams);
}

void check_lidars(const JsonField& session) {
  if (const auto only = session.find("lidar")) check_lidar(*only);
  const auto named = session.find("lidars");
  if (!named || !named->json().is_object()) return;
  for (const auto& [name, unused] : named->json().items()) {
    if (const auto lidar = named->find(name)) check_lidar(*lidar);
  }
}

Lidars read_lidars(const JsonField& session) {
  const auto only = session.find("lidar");
  const auto named = session.find("lidars");
  Lidars lidars;
  if (only && named) {
    named->fail("must not be there beside lidar");
  } else if (only) {
    lidars.only = read_lidar(*only);
  } else if (named && named->expect_object()) {
    const std::size_t count = named->json().size();
    if (count == 0 || count > kMaxLidars)
      named->fail("must have 1 to " + std::to_string(kMaxLidars) + " lidars by name");
    for (const auto& [name, unused] : named->json().items()) {
      if (!is_valid_name(name)) named->fail_member(name, "is no name: " + std::string(kNameRule));
      const auto field = named->require(name, "a lidar");
      if (const auto lidar = field ? read_lidar(*field) : std::nullopt)
        lidars.by_name.emplace(name, *lidar);
    }
  }
  return lidars;
}

ScanBatch read_scan_batch(Document& document, const Lidars& lidars, StampOrder order,
                          MapPose map_pose) {
  const JsonField body(document.root, "", document.errors);
  ScanBatch batch;
  if (!choose_lidar(body, lidars, batch.lidar)) return batch;
  const auto scans = body.require("scans", "1 or more scans");
  if (!scans) return batch;
  if (!scans->json().is_array() || scans->json().empty()) {
    scans->fail("must be an array of 1 or more scans");
  } else if (!batch.lidar && lidars.by_name.empty() && !has_own_angles(scans->json().front())) {
    body.fail_member("lidar", "is needed: angle_min, angle_increment, range_min, range_max");
  } else {
    BatchReader(document, batch, lidars, order, map_pose).read(*scans);
    if (!lidars.by_name.empty()) {
      std::ranges::stable_sort(batch.scans, {},
                               [](const BatchScan& scan) { return scan.scan.stamp; });
    }
    if (document.errors.empty()) straighten(batch.scans);
  }
  return batch;
}

}  // namespace cornerfix::api
