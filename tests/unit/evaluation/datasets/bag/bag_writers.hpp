/// \file  Small bags of each kind, made in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "unit/evaluation/datasets/bag/wire_writer.hpp"

namespace cornerfix::evaluation {

struct WrittenMessage {
  double received = 0.0;
  std::string topic;
  std::string type;  ///< "sensor_msgs/LaserScan", in bags of ROS 2 "sensor_msgs/msg/LaserScan".
  std::string bytes;
};

/// `chunks` is how the messages lie in the bag: a chunk a list. `compression` is none, bz2 or lz4.
[[nodiscard]] std::string ros1_bag(const std::vector<std::vector<WrittenMessage>>& chunks,
                                   const std::string& compression);

/// What stands in front of the entries of a chunk's index in a bag of ROS 1.
[[nodiscard]] std::string index_record(std::uint32_t entries, std::uint32_t claimed_bytes);

/// The same for MCAP with none (as ""), lz4 or zstd. All messages are CDR.
[[nodiscard]] std::string mcap(const std::vector<std::vector<WrittenMessage>>& chunks,
                               const std::string& compression);

/// A text as a frame of zstd.
[[nodiscard]] std::string zstd_packed(const std::string& text);

/// A .db3 file.
void write_sqlite_bag(const std::filesystem::path& path,
                      const std::vector<WrittenMessage>& messages);

}  // namespace cornerfix::evaluation
