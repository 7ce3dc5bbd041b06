// Where the robot should drive to settle which of two candidate poses is correct: the nearest place
// where the map around one has a wall and the map around the other is free.
import { CELL } from './grid.js';
import { distance, transform } from './geometry.js';

const STEP_M = 0.25;
const FIRST_M = 1;
const REACH_M = 25;
const CLUSTER_M = 1;
const MIN_SAMPLES = 4;  // In a cluster: about a metre of wall.
const SEEN_M = 0.5;     // What is so near to a hit of the last scan has been seen already.

function differ(a, b, point) {
  const [at_a, at_b] = [transform(a.pose, point), transform(b.pose, point)];
  const isOnlyWall = (one, at_one, other, at_other) => one.grid.cellAt(at_one) === CELL.wall
    && other.grid.cellAt(at_other) === CELL.free && !other.grid.isWallNear(at_other, 0.35);
  return isOnlyWall(a, at_a, b, at_b) || isOnlyWall(b, at_b, a, at_a);
}

// Hits by cells of SEEN_M, to ask quickly whether a place was seen.
function seenPlaces(points) {
  const key = (x, y) => `${Math.round(x / SEEN_M)},${Math.round(y / SEEN_M)}`;
  const keys = new Set(points.map(([x, y]) => key(x, y)));
  const near = [-1, 0, 1];
  return ([x, y]) => near.some((i) => near.some((j) => keys.has(key(x + i * SEEN_M, y + j * SEEN_M))));
}

// `a` and `b` are {grid, pose}, `points` the last scan in base_link. Null when the maps agree up to
// REACH_M; otherwise the place in base_link, with its distance and bearing.
export function whereTheyDiffer(a, b, points) {
  const isSeen = seenPlaces(points);
  const clusters = new Map();
  for (let radius = FIRST_M; radius <= REACH_M; radius += STEP_M) {
    const steps = Math.ceil((2 * Math.PI * radius) / STEP_M);
    for (let i = 0; i < steps; ++i) {
      const angle = (2 * Math.PI * i) / steps;
      const point = [radius * Math.cos(angle), radius * Math.sin(angle)];
      if (!differ(a, b, point) || isSeen(point)) continue;
      const key = point.map((value) => Math.floor(value / CLUSTER_M)).join();
      const count = (clusters.get(key) ?? 0) + 1;
      clusters.set(key, count);
      if (count >= MIN_SAMPLES) {
        const [x, y] = point;
        return { x, y, distance_m: distance({ x: 0, y: 0 }, { x, y }), bearing: Math.atan2(y, x) };
      }
    }
  }
  return null;
}
