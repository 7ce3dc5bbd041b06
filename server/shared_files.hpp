/// \file  Where the files are that come with the program.
#pragma once

#include <filesystem>

namespace cornerfix::server {

/// The directory of the inspector's files: of an installation ("share" beside the program's "bin"),
/// or else of the source tree that the program was built in. Empty when there is neither.
[[nodiscard]] std::filesystem::path find_web_root();

}  // namespace cornerfix::server
