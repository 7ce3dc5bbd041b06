/// \file  The files that make a bag, as rosbag2 leaves them in a directory.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <cornerfix/result.hpp>

namespace cornerfix::evaluation {

struct BagFiles {
  std::vector<std::filesystem::path> paths;  ///< In the order of recording; not empty.
  std::vector<std::string> notes;            ///< What is missing, for people.
};

/// Of a directory, or of the metadata.yaml in it: those that metadata.yaml lists, in its order.
/// Without such a list, or when all of it is missing: all bag files, by name, where bag_2 comes
/// before bag_10. Of another file: itself.
[[nodiscard]] Result<BagFiles> find_bag_files(const std::filesystem::path& path);

}  // namespace cornerfix::evaluation
