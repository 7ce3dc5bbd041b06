// How a scan fits a map at a pose: each hit explained, contradicted, hidden or not judged. The limits
// are those of the server's evidence model (docs/algorithm.md), applied to the last scan only.
import { CELL } from './grid.js';
import { distance, transform } from './geometry.js';

const ON_WALL_M = 0.15;
const FREE_OF_WALLS_M = 0.3;

export const HIT = { explained: 0, contradicted: 1, hidden: 2, unjudged: 3 };
export const HIT_NAMES = ['explained', 'contradicted', 'hidden', 'unjudged'];

function classOf(grid, laser, hit) {
  if (grid.isWallNear(hit, ON_WALL_M)) return HIT.explained;
  if (isBehindWall(grid, laser, hit)) return HIT.hidden;
  if (grid.cellAt(hit) !== CELL.free || grid.isWallNear(hit, FREE_OF_WALLS_M)) return HIT.unjudged;
  return HIT.contradicted;
}

// Neither the wall that the beam ends in nor one that it grazes at its start counts.
function isBehindWall(grid, laser, hit) {
  const yaw = Math.atan2(hit.y - laser.y, hit.x - laser.x);
  const reach = distance(laser, hit) - FREE_OF_WALLS_M;
  const from = { x: laser.x + FREE_OF_WALLS_M * Math.cos(yaw), y: laser.y + FREE_OF_WALLS_M * Math.sin(yaw) };
  return reach > FREE_OF_WALLS_M && grid.rayLength(from, yaw, reach - FREE_OF_WALLS_M) !== null;
}

// `points` and `mount` are in base_link. The hits keep the order of the points.
export function fitScan(grid, pose, points, mount = { x: 0, y: 0 }) {
  const laser = transform(pose, [mount.x, mount.y]);
  const hits = points.map((point) => {
    const hit = transform(pose, point);
    return { ...hit, kind: classOf(grid, laser, hit) };
  });
  const counts = [0, 0, 0, 0];
  for (const { kind } of hits) ++counts[kind];
  return { hits, counts };
}
