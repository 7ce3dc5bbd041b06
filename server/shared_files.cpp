#include "server/shared_files.hpp"

namespace cornerfix::server {

namespace fs = std::filesystem;

fs::path find_web_root() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  const fs::path bin = program.parent_path();
  fs::path installed = bin.parent_path() / "share" / "cornerfix" / "web";
  if (fs::exists(installed, error)) return installed;
  // build/PRESET/bin/PROGRAM, three levels below the source tree.
  const fs::path source = bin.parent_path().parent_path().parent_path() / "web";
  return fs::exists(source, error) ? source : fs::path{};
}

}  // namespace cornerfix::server
