/// \file  A service with a map of one room, and the scans of a robot that drives there.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "unit/server/service_fixture.hpp"

namespace cornerfix::server {

class LocalizationServiceTest : public ServiceTest {
 protected:
  LocalizationServiceTest() { make_map(process_, "office"); }

  api::CreateSessionRequest session_of(const std::string& robot,
                                       std::vector<std::string> maps = {"office"}) const {
    const LaserScan& scan = drive_.scans[0].scan;
    api::CreateSessionRequest request;
    request.robot = robot;
    request.maps = std::move(maps);
    request.lidars.only = api::Lidar{.angle_min = scan.angle_min,
                                     .angle_increment = scan.angle_increment,
                                     .range_min = scan.range_min,
                                     .range_max = scan.range_max,
                                     .beams = {},
                                     .T_base_link_laser = {}};
    return request;
  }

  std::string create(Process& process, std::vector<std::string> maps = {"office"}) {
    const auto created = process.localization.create(session_of("cart-7", std::move(maps)));
    EXPECT_TRUE(created) << created.error().message;
    return created.value().value().id;
  }

  /// The batch of `count` scans that has `sequence`, when all batches have so many.
  api::SessionScansRequest batch(std::uint64_t sequence, std::size_t count = 3) const {
    const auto begin = drive_.scans.begin() + static_cast<std::ptrdiff_t>(sequence * count);
    return {sequence, {begin, begin + static_cast<std::ptrdiff_t>(count)}};
  }

  static std::string answer(Process& process, const std::string& id,
                            const api::SessionScansRequest& request) {
    const auto outcome = process.localization.post_scans(id, request);
    EXPECT_TRUE(outcome) << outcome.error().message;
    if (!outcome) return {};
    EXPECT_FALSE(outcome->expected_sequence.has_value());
    return outcome->answer;
  }

  testing::RobotDrive drive_ = testing::robot_drive();
  Process process_{file()};
  LocalizationService& service_ = process_.localization;
};

}  // namespace cornerfix::server
