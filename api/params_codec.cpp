#include "api/params_codec.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace cornerfix::api {
namespace {

// The tables: a line a setting, by the name it has in its struct. The seeds of stages are left out:
// they are drawn from the one seed.

template <typename Visitor>
void visit_members(SampledMatchParams& params, Visitor&& visit) {
  visit("success_probability", params.success_probability);
  visit("overlap", params.overlap);
}

template <typename Visitor>
void visit_members(PoseEstimatorParams& params, Visitor&& visit) {
  visit("inlier_distance_m", params.inlier_distance_m);
  visit("min_inliers", params.min_inliers);
  visit("max_iterations", params.max_iterations);
}

template <typename Visitor>
void visit_members(AcceptanceParams& params, Visitor&& visit) {
  visit("min_probability", params.min_probability);
  visit("min_gap", params.min_gap);
  visit("min_mean_gap", params.min_mean_gap);
}

template <typename Visitor>
void visit_members(LocalizerParams& params, Visitor&& visit) {
  visit("method", params.method);
  visit("extractor", params.extractor);
  visit("seed", params.seed);
  visit("min_features", params.paper.min_features);
  visit("min_votes", params.paper.min_votes);
  visit("max_matches", params.paper.max_matches);
  visit("sampling", params.paper.sampling);
  visit("estimator", params.paper.estimator);
  visit("search_budget_ms", params.search_budget_ms);
  visit("acceptance", params.acceptance);
}

template <typename Visitor>
void visit_members(OccupancyMappingParams& params, Visitor&& visit) {
  visit("resolution_m", params.resolution_m);
  visit("max_range_m", params.max_range_m);
  visit("min_peak_share", params.min_peak_share);
  visit("min_hit_share", params.min_hit_share);
}

template <typename Visitor>
void visit_members(FeatureMapParams& params, Visitor&& visit) {
  visit("suppression_radius_m", params.suppression_radius_m);
}

template <typename Visitor>
void visit_members(DescriptorParams& params, Visitor&& visit) {
  visit("distance_resolution_m", params.distance_resolution_m);
  visit("angle_resolution_rad", params.angle_resolution_rad);
  visit("max_distance_m", params.max_distance_m);
}

template <typename Visitor>
void visit_members(MapperParams& params, Visitor&& visit) {
  visit("key_frame_distance_m", params.key_frame_distance_m);
  visit("key_frame_angle_rad", params.key_frame_angle_rad);
  visit("min_feature_count", params.min_feature_count);
  visit("extractor", params.extractor);
  visit("grid", params.grid);
  visit("features", params.features);
  visit("descriptors", params.descriptors);
}

class Reader {
 public:
  explicit Reader(const JsonField& object) : object_(object) {}

  template <typename T>
  void operator()(const char* name, T& member) {
    known_.emplace_back(name);
    if (const auto field = object_.find(name)) read(*field, member);
  }

  void tell_unknown() const { object_.expect_members(known_); }

 private:
  static void read(const JsonField& field, double& member) {
    if (const auto number = field.as_number()) member = *number;
  }
  static void read(const JsonField& field, int& member) {
    constexpr double kMost = std::numeric_limits<int>::max();
    const double number =
        field.json().is_number() ? field.json().get<double>() : std::numeric_limits<double>::max();
    if (number == std::trunc(number) && std::abs(number) <= kMost) {
      member = static_cast<int>(number);  // validate() checks its range.
    } else {
      field.fail("must be a whole number of at most 2147483647");
    }
  }
  static void read(const JsonField& field, std::uint64_t& member) {
    constexpr auto kMost = std::numeric_limits<std::uint64_t>::max();
    if (const auto count = field.as_count(0, kMost)) member = *count;
  }
  static void read(const JsonField& field, Method& member) {
    read_name(field, member, method_from_string, "must be indexed, rma or nma");
  }
  static void read(const JsonField& field, CornerExtractor& member) {
    read_name(field, member, corner_extractor_from_string, "must be two_arm or vfp");
  }
  template <typename Enum, typename FromString>
  static void read_name(const JsonField& field, Enum& member, FromString from_string,
                        const char* expected) {
    const auto* name = field.json().get_ptr<const std::string*>();
    if (const std::optional<Enum> known = name != nullptr ? from_string(*name) : std::nullopt) {
      member = *known;
    } else {
      field.fail(expected);
    }
  }
  template <typename Nested>
  static void read(const JsonField& field, Nested& member) {
    if (!field.expect_object()) return;
    Reader reader(field);
    visit_members(member, reader);
    reader.tell_unknown();
  }

  const JsonField& object_;
  std::vector<std::string_view> known_;
};

class Writer {
 public:
  template <typename T>
  void operator()(const char* name, T& member) {
    object_[name] = write(member);
  }
  [[nodiscard]] const nlohmann::ordered_json& object() const { return object_; }

 private:
  static nlohmann::ordered_json write(double member) { return member; }
  static nlohmann::ordered_json write(int member) { return member; }
  static nlohmann::ordered_json write(std::uint64_t member) { return member; }
  static nlohmann::ordered_json write(Method member) { return to_string(member); }
  static nlohmann::ordered_json write(CornerExtractor member) { return to_string(member); }
  template <typename Nested>
  static nlohmann::ordered_json write(Nested& member) {
    Writer writer;
    visit_members(member, writer);
    return writer.object();
  }

  nlohmann::ordered_json object_ = nlohmann::ordered_json::object();
};

template <typename Params>
void read_and_validate(const JsonField& object, Params& params) {
  if (!object.expect_object()) return;
  Reader reader(object);
  visit_members(params, reader);
  reader.tell_unknown();
  if (const auto error = validate(params)) {
    std::string path = error->field;
    std::replace(path.begin(), path.end(), '.', '/');
    object.fail_path(path, error->message);
  }
}

template <typename Params>
nlohmann::ordered_json write_all(Params params) {
  Writer writer;
  visit_members(params, writer);
  return writer.object();
}

}  // namespace

void read_params(const JsonField& object, LocalizerParams& params) {
  read_and_validate(object, params);
}
void read_params(const JsonField& object, MapperParams& params) {
  read_and_validate(object, params);
}

nlohmann::ordered_json params_to_json(const LocalizerParams& params) { return write_all(params); }
nlohmann::ordered_json params_to_json(const MapperParams& params) { return write_all(params); }

}  // namespace cornerfix::api
