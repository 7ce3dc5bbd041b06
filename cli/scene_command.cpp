#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "evaluation/simulation/scene_files.hpp"
#include "evaluation/simulation/scenes.hpp"

namespace cornerfix::cli {

namespace {

struct SceneArguments {
  std::string kind;
  std::filesystem::path out;
  std::uint64_t layout_seed = 1;
  std::uint64_t change_seed = 1;
};

int run_scene(const SceneArguments& arguments) {
  const auto kind = evaluation::scene_kind_from_string(arguments.kind);
  const OccupancyGrid grid =
      evaluation::make_scene(*kind, arguments.layout_seed, arguments.change_seed);
  const Result<void> written = evaluation::write_scene(arguments.out, grid);
  if (!written) return fail(written.error());
  const auto free = std::ranges::count(grid.cells, Cell::kFree);
  std::printf("%s: %.1f x %.1f m, %.0f m2 free\n", arguments.out.c_str(),
              grid.width * grid.resolution, grid.height * grid.resolution,
              static_cast<double>(free) * grid.resolution * grid.resolution);
  return kDone;
}

}  // namespace

void add_scene_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SceneArguments>();
  CLI::App* command = app.add_subcommand(
      "scene", "Generate the occupancy map of a warehouse, yard, office or the like, by seeds");
  command->option_defaults()->always_capture_default();
  command->add_option("KIND", arguments->kind, "What to generate")
      ->required()
      ->check(CLI::IsMember(evaluation::scene_kind_names()))
      ->capture_default_str();
  command->add_option("OUT", arguments->out, "Writes OUT.yaml and OUT.png")->required();
  command->add_option("--layout-seed", arguments->layout_seed,
                      "Draws what lasts: walls, racks, trees");
  command->add_option("--change-seed", arguments->change_seed,
                      "Draws what does not last: stock, parked cars, furniture");
  command->callback([arguments, &exit_code] { exit_code = run_scene(*arguments); });
}

}  // namespace cornerfix::cli
