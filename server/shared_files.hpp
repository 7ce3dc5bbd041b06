/// \file  Files that come with the program: where they are, and the API's description.
#pragma once

#include <filesystem>
#include <string>

#include <cornerfix/result.hpp>

namespace cornerfix::server {

/// The directory of the inspector's files: of an installation ("share" beside the program's "bin"),
/// or else of the source tree that the program was built in. Empty when there is neither.
[[nodiscard]] std::filesystem::path find_web_root();

/// openapi.yaml, found likewise.
[[nodiscard]] std::filesystem::path find_openapi_file();

/// A YAML document (JSON's types only) as JSON text.
[[nodiscard]] Result<std::string> yaml_file_as_json(const std::filesystem::path& path);

}  // namespace cornerfix::server
