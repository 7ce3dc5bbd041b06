#include "ros2/topic_names.hpp"

#include <algorithm>
#include <array>

namespace cornerfix::ros2 {

namespace {

/// The names that ROS 2 programs use; those of tf and diagnostics are in no namespace.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kTopics = {{
    {"scan", "scan"},
    {"odom", "odom"},
    {"tf", "/tf"},
    {"tf_static", "/tf_static"},
    {"initialpose", "initialpose"},
    {"diagnostics", "/diagnostics"},
}};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

const auto* find_topic(std::string_view name) {
  const auto* found = std::ranges::find(kTopics, name, &decltype(kTopics)::value_type::first);
  return found == kTopics.end() ? nullptr : found;
}

}  // namespace

bool is_ros_name(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  bool begins_part = true;
  for (const char c : name) {
    if (c == '/' ? begins_part : !is_letter(c) && (begins_part || !is_digit(c))) return false;
    begins_part = c == '/';
  }
  return !begins_part;
}

Result<void> Remappings::add(std::string_view text) {
  const std::size_t middle = text.find(":=");
  const std::string_view from = text.substr(0, middle);
  if (middle == std::string_view::npos || find_topic(from) == nullptr) {
    return Error{ErrorCode::kInvalidArgument,
                 "expected FROM:=TO, with FROM one of scan, odom, tf, tf_static, initialpose and "
                 "diagnostics",
                 std::string(text)};
  }
  const std::string_view to = text.substr(middle + 2);
  if (!is_ros_name(to)) {
    return Error{ErrorCode::kInvalidArgument,
                 "expected a name of a ROS topic after :=", std::string(text)};
  }
  names_.insert_or_assign(std::string(from), std::string(to));
  return {};
}

std::string Remappings::resolve(const std::string& topic, const std::string& ns) const {
  const auto own = names_.find(topic);
  const auto* known = find_topic(topic);
  std::string name = topic;
  if (known != nullptr) name = known->second;
  if (own != names_.end()) name = own->second;
  if (name.starts_with('/')) return name;
  if (ns.empty() || ns == "/") return "/" + name;
  return (ns.starts_with('/') ? ns : "/" + ns) + "/" + name;
}

std::string dds_topic(const std::string& full_name) { return "rt" + full_name; }

std::string lidar_name(const std::string& full_name) {
  std::string name = full_name.substr(full_name.find_first_not_of("/_"));
  std::ranges::replace(name, '/', '.');
  return name;
}

}  // namespace cornerfix::ros2
