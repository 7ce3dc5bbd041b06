#include "core/src/slam/drive_submap.hpp"

#include <algorithm>
#include <cmath>

#include "core/src/map/field_stamp.hpp"
#include "core/src/map/occupancy_mapping.hpp"

namespace cornerfix {
namespace {

constexpr double kPieceLength = 8.0;  // way of a submap: rigid, but enough to know a place by [m]
constexpr double kFieldResolution = 0.1;
constexpr double kStampRadius = 0.5;  // how far from a wall a scan is drawn to it [m]

std::vector<double> ways_along(std::span<const PosedScan> drive) {
  std::vector<double> ways(drive.size(), 0.0);
  for (std::size_t i = 1; i < drive.size(); ++i)
    ways[i] = ways[i - 1] + distance(drive[i - 1].T_map_base_link, drive[i].T_map_base_link);
  return ways;
}

/// The piece's scans in frame `submap`.
std::vector<PosedScan> scans_in_submap(std::span<const PosedScan> scans,
                                       const Pose2& T_drive_submap) {
  const Pose2 T_submap_drive = inverse(T_drive_submap);
  std::vector<PosedScan> moved(scans.begin(), scans.end());
  for (PosedScan& scan : moved) scan.T_map_base_link = T_submap_drive * scan.T_map_base_link;
  return moved;
}

DistanceField field_of(std::span<const PosedScan> scans, const OccupancyGrid& grid) {
  const double scale = grid.resolution / kFieldResolution;
  const auto cells = [scale](int fine) { return static_cast<int>(std::ceil(fine * scale)); };
  DistanceField field(grid.T_map_grid, kFieldResolution, cells(grid.width), cells(grid.height));
  for (const PosedScan& scan : scans) {
    stamp_scan(field, scan.scan, scan.T_map_base_link * scan.T_base_link_laser, kStampRadius,
               kSubmapRange);
  }
  return field;
}

/// Of hits near the path: the drift of the heading moves farther ones, in each submap differently.
Evidence evidence_of(std::span<const PosedScan> scans) {
  EvidenceGrid grid({0.0, 0.0}, {.max_range_m = 15.0, .extent_m = 60.0});
  for (const PosedScan& scan : scans)
    grid.add(scan.scan, scan.T_map_base_link * scan.T_base_link_laser);
  return grid.collect();
}

void take_cells(const OccupancyGrid& grid, DriveSubmap& submap) {
  const int step = static_cast<int>(std::lround(kFloorSpacing / grid.resolution));
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const Cell cell = grid.at({column, row});
      if (cell == Cell::kOccupied) {
        submap.walls.push_back(grid.T_map_grid * grid.center({column, row}));
      } else if (cell == Cell::kFree && row % step == 0 && column % step == 0) {
        submap.floor.push_back(grid.T_map_grid * grid.center({column, row}));
      }
    }
  }
}

}  // namespace

std::vector<DrivePiece> cut_drive(std::span<const PosedScan> drive) {
  std::vector<DrivePiece> pieces;
  if (drive.empty()) return pieces;
  const std::vector<double> ways = ways_along(drive);
  const auto first_from = [&ways](double way) {
    return static_cast<std::size_t>(std::ranges::lower_bound(ways, way) - ways.begin());
  };
  for (double begin = 0.0;; begin += 0.5 * kPieceLength) {
    const DrivePiece piece{first_from(begin), first_from(begin + kPieceLength)};
    if (piece.first < piece.end) pieces.push_back(piece);
    if (piece.end == drive.size()) return pieces;
  }
}

DriveSubmap make_drive_submap(std::span<const PosedScan> drive, DrivePiece piece) {
  DriveSubmap submap;
  submap.piece = piece;
  submap.T_drive_submap = drive[(piece.first + piece.end) / 2].T_map_base_link;
  const std::vector<PosedScan> scans =
      scans_in_submap(drive.subspan(piece.first, piece.end - piece.first), submap.T_drive_submap);
  for (const PosedScan& scan : scans) {
    submap.way.push_back(scan.T_map_base_link.translation());
    submap.reach_m = std::max(submap.reach_m, submap.way.back().norm());
  }
  const OccupancyGrid grid =
      build_occupancy_grid(scans, {.resolution_m = kSubmapResolution, .max_range_m = kSubmapRange});
  submap.field = field_of(scans, grid);
  submap.evidence = evidence_of(scans);
  take_cells(grid, submap);
  return submap;
}

}  // namespace cornerfix
