#include "api/requests.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include "api/body_reader.hpp"
#include "api/json_codec.hpp"
#include "api/json_field.hpp"
#include "api/params_codec.hpp"
#include "api/scan_batch.hpp"
#include "api/start_region_codec.hpp"

namespace cornerfix::api {
namespace {

constexpr std::size_t kMaxDescriptionBytes = 4096;
constexpr std::size_t kMaxNamedMaps = 1000;
constexpr std::size_t kMaxPageLimit = 1000;
constexpr std::size_t kMaxWaitS = 60;

/// Reads a body and hands its document to `read`, which fills the request from these members.
template <typename Request, typename Read>
Parsed<Request> parse(std::string_view body, BodyFormat format, const RequestLimits& limits,
                      std::initializer_list<std::string_view> members, Read read) {
  auto body_or_problem = read_body(body, format, limits);
  if (auto* problem = std::get_if<Problem>(&body_or_problem)) return std::move(*problem);
  auto& document = std::get<Document>(body_or_problem);
  Request request;
  const JsonField root(document.root, "", document.errors);
  read(root, document, request);
  root.expect_members(members);
  if (!document.errors.empty()) return std::move(document.errors).to_problem();
  return request;
}

RobotScan to_robot_scan(BatchScan&& scan) {
  return {.scan = std::move(scan.scan),
          .T_base_link_laser = scan.T_base_link_laser,
          .T_odom_base_link = scan.T_odom_base_link};
}

PosedScan to_posed_scan(BatchScan&& scan) {
  return {.scan = std::move(scan.scan),
          .T_base_link_laser = scan.T_base_link_laser,
          .T_map_base_link = scan.T_map_base_link.value_or(Pose2{})};
}

std::vector<RobotScan> to_robot_scans(ScanBatch&& batch) {
  std::vector<RobotScan> scans;
  scans.reserve(batch.scans.size());
  for (BatchScan& scan : batch.scans) scans.push_back(to_robot_scan(std::move(scan)));
  return scans;
}

/// Where a scan is in the body.
JsonField scan_field(const JsonField& body, std::size_t index) {
  return body.find("scans")->item(index);
}

bool expect_all_posed_or_none(const JsonField& body, const std::vector<BatchScan>& scans) {
  const auto is_posed = [](const BatchScan& scan) { return scan.T_map_base_link.has_value(); };
  if (std::ranges::all_of(scans, is_posed) || std::ranges::none_of(scans, is_posed)) return true;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!is_posed(scans[i])) {
      scan_field(body, i).fail_member(
          "pose", "is needed: base_link in map, since other scans of the batch have one");
    }
  }
  return false;
}

void expect_increasing_stamps(const JsonField& body, const std::vector<BatchScan>& scans) {
  for (std::size_t i = 1; i < scans.size(); ++i) {
    if (scans[i].scan.stamp <= scans[i - 1].scan.stamp) {
      scan_field(body, i).fail_member(
          "stamp", "must be later than the scan's before it, since scans without pose are a drive");
    }
  }
}

void read_options(const JsonField& body, LocalizerParams& params, std::string* text) {
  const auto options = body.find("options");
  if (!options) return;
  read_params(*options, params);
  if (text != nullptr) *text = options->json().dump();
}

void read_name_list(const JsonField& field, std::vector<std::string>& names) {
  const std::size_t count = field.json().size();
  if (!field.json().is_array() || count == 0 || count > kMaxNamedMaps) {
    field.fail("must be an array of 1 to " + std::to_string(kMaxNamedMaps) + " names");
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto name = field.item(i).as_name();
    if (name && std::find(names.begin(), names.end(), *name) == names.end()) {
      names.push_back(*name);
    }
  }
}

/// `map` names one, `maps` some, neither: every map.
void read_maps(const JsonField& body, std::vector<std::string>& names) {
  const auto map = body.find("map");
  const auto maps = body.find("maps");
  if (map && maps) {
    maps->fail("must not be there beside map");
  } else if (maps) {
    read_name_list(*maps, names);
  } else if (map) {
    if (const auto name = map->as_name()) names.push_back(*name);
  }
}

void read_stamped_pose(const JsonField& field, std::vector<StampedPose>& poses) {
  if (!field.expect_object()) return;
  const auto stamp_field = field.require("stamp", "seconds");
  const auto stamp = stamp_field ? stamp_field->as_stamp() : std::nullopt;
  const auto pose = field.as_pose();
  field.expect_members({"stamp", "x", "y", "yaw"});
  if (stamp && pose) poses.push_back({*stamp, *pose});
}

/// A text of the store, as a field whose errors nobody needs to see.
struct StoredText {
  explicit StoredText(std::string_view text)
      : root(nlohmann::json::parse(text, nullptr, false)), field(root, "", errors) {}
  nlohmann::json root;
  FieldErrors errors;
  JsonField field;
};

/// What is null in `from` is as if it were not there.
void merge(nlohmann::json& into, const nlohmann::json& from) {
  for (const auto& [name, value] : from.items()) {
    if (value.is_object()) {
      merge(into[name], value);
    } else if (!value.is_null()) {
      into[name] = value;
    }
  }
}

template <typename Params>
Params stored_params(std::string_view text) {
  Params params;
  const StoredText stored(text);
  if (stored.root.is_object()) read_params(stored.field, params);
  return params;
}

/// Takes a finite number from the front of `text`.
std::optional<double> take_number(std::string_view& text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

std::optional<std::array<double, 4>> parse_four_numbers(std::string_view text) {
  std::array<double, 4> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) {
      if (!text.starts_with(',')) return std::nullopt;
      text.remove_prefix(1);
    }
    const auto number = take_number(text);
    if (!number) return std::nullopt;
    numbers[i] = *number;
  }
  return text.empty() ? std::optional(numbers) : std::nullopt;
}

Problem wrong_query(const std::string& name, const std::string& expected) {
  Problem problem = make_problem(ErrorCode::kInvalidArgument, name + ": " + expected);
  problem.errors.push_back({"/" + name, expected});
  return problem;
}

Parsed<std::size_t> parse_whole_number(const char* name, std::string_view text, std::size_t least,
                                       std::size_t most) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  if (whole && number >= least && number <= most) return number;
  return wrong_query(
      name, "must be a whole number from " + std::to_string(least) + " to " + std::to_string(most));
}

/// `check` looks at the lidar besides.
Parsed<PutMapRequest> parse_map_entry(std::string_view body, BodyFormat format,
                                      void (*check)(const JsonField&)) {
  return parse<PutMapRequest>(
      body, format, {}, {"description", "lidar", "parameters"},
      [check](const JsonField& root, Document& /*document*/, PutMapRequest& request) {
        if (const auto description = root.find("description")) {
          request.description = description->as_text(kMaxDescriptionBytes);
        }
        if (const auto field = root.find("lidar")) {
          check(*field);
          request.lidar = read_lidar(*field);
        }
        if (const auto parameters = root.find("parameters")) {
          MapperParams params;
          read_params(*parameters, params);
          request.parameters_json = parameters->json().dump();
        }
      });
}

}  // namespace

Parsed<PutMapRequest> parse_put_map(std::string_view body, BodyFormat format) {
  return parse_map_entry(body, format, check_lidar);
}

Parsed<MapScansRequest> parse_map_scans(std::string_view body, BodyFormat format,
                                        const std::optional<Lidar>& lidar,
                                        const RequestLimits& limits) {
  return parse<MapScansRequest>(
      body, format, limits, {"lidar", "scans"},
      [&](const JsonField& root, Document& document, MapScansRequest& request) {
        ScanBatch batch = read_scan_batch(document, lidar, StampOrder::kAny, MapPose::kTaken);
        request.lidar = batch.lidar;
        if (!document.errors.empty()) return;
        if (!expect_all_posed_or_none(root, batch.scans)) return;
        if (!batch.scans.front().T_map_base_link) {
          expect_increasing_stamps(root, batch.scans);
          request.unposed_scans = to_robot_scans(std::move(batch));
          return;
        }
        for (BatchScan& scan : batch.scans) request.scans.push_back(to_posed_scan(std::move(scan)));
      });
}

Parsed<TrajectoryRequest> parse_trajectory(std::string_view body, BodyFormat format) {
  return parse<TrajectoryRequest>(
      body, format, {}, {"poses"},
      [](const JsonField& root, Document& /*document*/, TrajectoryRequest& request) {
        const auto poses = root.require("poses", "stamped poses of base_link in map");
        if (!poses) return;
        if (!poses->json().is_array() || poses->json().empty()) {
          poses->fail("must be an array of 1 or more poses");
          return;
        }
        for (std::size_t i = 0; i < poses->json().size(); ++i) {
          read_stamped_pose(poses->item(i), request.poses);
        }
      });
}

Parsed<RollBackRequest> parse_roll_back(std::string_view body, BodyFormat format) {
  return parse<RollBackRequest>(
      body, format, {}, {"revision"},
      [](const JsonField& root, Document& /*document*/, RollBackRequest& request) {
        constexpr std::uint64_t kMostRevision = std::uint64_t{1} << 53U;
        if (const auto revision = root.require("revision", "a kept revision of the map"))
          request.revision = revision->as_count(1, kMostRevision).value_or(0);
      });
}

Parsed<CreateSessionRequest> parse_create_session(std::string_view body, BodyFormat format) {
  return parse<CreateSessionRequest>(
      body, format, {}, {"robot", "map", "maps", "lidar", "lidars", "near", "options"},
      [](const JsonField& root, Document& /*document*/, CreateSessionRequest& request) {
        if (const auto robot = root.require("robot", "the robot's name")) {
          request.robot = robot->as_name().value_or("");
        }
        read_maps(root, request.maps);
        check_lidars(root);
        request.lidars = read_lidars(root);
        if (const auto near = root.find("near")) request.region = read_start_region(*near);
        read_options(root, request.params, &request.options_json);
      });
}

Parsed<ResetRequest> parse_reset(std::string_view body, BodyFormat format) {
  return parse<ResetRequest>(
      body, format, {}, {"near"},
      [](const JsonField& root, Document& /*document*/, ResetRequest& request) {
        if (const auto near = root.find("near")) request.region = read_start_region(*near);
      });
}

Parsed<SessionScansRequest> parse_session_scans(std::string_view body, BodyFormat format,
                                                const Lidars& lidars, const RequestLimits& limits) {
  return parse<SessionScansRequest>(
      body, format, limits, {"sequence", "lidar", "scans"},
      [&](const JsonField& root, Document& document, SessionScansRequest& request) {
        constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
        if (const auto sequence = root.require("sequence", "the batch's number, from 0")) {
          request.sequence = sequence->as_count(0, kMost).value_or(0);
        }
        request.scans = to_robot_scans(
            read_scan_batch(document, lidars, StampOrder::kIncreasing, MapPose::kRefused));
      });
}

Parsed<LocalizeRequest> parse_localize(std::string_view body, BodyFormat format,
                                       const RequestLimits& limits) {
  return parse<LocalizeRequest>(
      body, format, limits, {"lidar", "scans", "options"},
      [](const JsonField& root, Document& document, LocalizeRequest& request) {
        request.scans = to_robot_scans(
            read_scan_batch(document, Lidars(), StampOrder::kIncreasing, MapPose::kRefused));
        read_options(root, request.params, nullptr);
      });
}

std::string lidar_to_json(const Lidar& lidar) { return render_lidar(lidar).dump(); }

std::string lidars_to_json(const Lidars& lidars) {
  if (lidars.only) return lidar_to_json(*lidars.only);
  if (lidars.by_name.empty()) return "";
  nlohmann::ordered_json json;
  for (const auto& [name, lidar] : lidars.by_name) json["lidars"][name] = render_lidar(lidar);
  return json.dump();
}

Result<std::string> merged_parameters(std::string_view stored, std::string_view given) {
  StoredText merged(stored.empty() ? "{}" : stored);
  merge(merged.root, nlohmann::json::parse(given));
  MapperParams params;
  read_params(merged.field, params);
  if (merged.errors.empty()) return merged.root.dump();
  const Problem problem = std::move(merged.errors).to_problem();
  const FieldError& first = problem.errors.front();
  return Error{ErrorCode::kInvalidArgument, first.detail, "/parameters" + first.pointer};
}

bool is_put_map_request(std::string_view description, std::string_view lidar_json,
                        std::string_view parameters_json) {
  std::string body =
      R"({"description": )" +
      nlohmann::json(description).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  if (!lidar_json.empty()) body += R"(, "lidar": )" + std::string(lidar_json);
  if (!parameters_json.empty()) body += R"(, "parameters": )" + std::string(parameters_json);
  const auto parsed =
      parse_map_entry(body + "}", BodyFormat::kJson, [](const JsonField& /*lidar*/) {});
  const auto* request = std::get_if<PutMapRequest>(&parsed);
  return request != nullptr && request->description == description &&
         (request->lidar ? lidar_to_json(*request->lidar) : "") == lidar_json &&
         request->parameters_json.value_or("") == parameters_json;
}

std::optional<Lidar> lidar_from_json(std::string_view lidar_json) {
  const StoredText stored(lidar_json);
  return stored.root.is_object() ? read_lidar(stored.field) : std::nullopt;
}

std::optional<Lidars> lidars_from_json(std::string_view lidars_json) {
  if (lidars_json.empty()) return Lidars();
  const StoredText stored(lidars_json);
  if (!stored.root.is_object()) return std::nullopt;
  Lidars lidars;
  if (stored.root.contains("lidars")) {
    lidars = read_lidars(stored.field);
  } else {
    lidars.only = read_lidar(stored.field);
  }
  return stored.errors.empty() ? std::optional(std::move(lidars)) : std::nullopt;
}

LocalizerParams params_from_json(std::string_view options_json) {
  return stored_params<LocalizerParams>(options_json);
}

MapperParams mapper_params_from_json(std::string_view parameters_json) {
  return stored_params<MapperParams>(parameters_json);
}

Parsed<Bounds> parse_bbox(std::string_view text) {
  const auto numbers = parse_four_numbers(text);
  if (!numbers) return wrong_query("bbox", "must be x0,y0,x1,y1 in metres");
  const Point2 a((*numbers)[0], (*numbers)[1]);
  const Point2 b((*numbers)[2], (*numbers)[3]);
  return Bounds{.min = a.cwiseMin(b), .max = a.cwiseMax(b)};
}

Parsed<std::size_t> parse_page_limit(std::string_view text) {
  return parse_whole_number("limit", text, 1, kMaxPageLimit);
}

Parsed<std::size_t> parse_number_page_token(std::string_view text) {
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<std::int64_t>::max());
  auto token = parse_whole_number("page_token", text, 0, kMost);
  if (std::holds_alternative<std::size_t>(token)) return token;
  return wrong_query("page_token", "must be next_page_token of the page before");
}

Parsed<std::size_t> parse_wait(std::string_view text) {
  return parse_whole_number("wait", text, 0, kMaxWaitS);
}

bool is_valid_name(std::string_view name) {
  const auto is_alphanumeric = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
  };
  return !name.empty() && name.size() <= 128 && is_alphanumeric(name.front()) &&
         std::all_of(name.begin(), name.end(), [&](char c) {
           return is_alphanumeric(c) || c == '.' || c == '_' || c == '-';
         });
}

}  // namespace cornerfix::api
