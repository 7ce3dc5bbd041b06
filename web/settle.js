// Where the robot should drive to settle which of two candidate poses is correct: the nearest place
// where the map around one has a wall and the map around the other is free.
import { CELL } from './grid.js';
import { inverseTransform, transform } from './geometry.js';

const FIRST_M = 1;
const REACH_M = 25;
const CLUSTER_M = 1;
const MIN_WALL_M = 0.5;   // In a cluster; less is noise.
const APART_M = 0.35;     // From the other map's walls.
const SEEN_M = 0.5;       // What is so near to a hit of the last scan has been seen already.
const BEFORE_WALL_M = 0.5;

// Hits by cells of SEEN_M, to ask quickly whether a place was seen.
function seenPlaces(points) {
  const key = (x, y) => `${Math.round(x / SEEN_M)},${Math.round(y / SEEN_M)}`;
  const keys = new Set(points.map(([x, y]) => key(x, y)));
  const near = [-1, 0, 1];
  return ([x, y]) => near.some((i) => near.some((j) => keys.has(key(x + i * SEEN_M, y + j * SEEN_M))));
}

// Walls around one pose that are free around the other, in base_link.
function wallsOnlyAt(one, other, isSeen) {
  const found = [];
  one.grid.eachWallNear(one.pose, REACH_M, (wall) => {
    const point = inverseTransform(one.pose, wall);
    const twin = transform(other.pose, point);
    if (other.grid.cellAt(twin) !== CELL.free || Math.hypot(...point) < FIRST_M) return;
    if (!isSeen(point) && !other.grid.isWallNear(twin, APART_M)) found.push(point);
  });
  return found;
}

// The middles of clusters that are large enough, the nearest first.
function clustersOf(points, min_count) {
  const clusters = new Map();
  for (const [x, y] of points) {
    const key = `${Math.floor(x / CLUSTER_M)},${Math.floor(y / CLUSTER_M)}`;
    const cluster = clusters.get(key) ?? { x: 0, y: 0, count: 0 };
    clusters.set(key, cluster);
    cluster.x += x;
    cluster.y += y;
    ++cluster.count;
  }
  return [...clusters.values()].filter(({ count }) => count >= min_count)
    .map(({ x, y, count }) => ({ x: x / count, y: y / count, distance_m: Math.hypot(x, y) / count, bearing: Math.atan2(y, x) }))
    .sort((a, b) => a.distance_m - b.distance_m);
}

// `a` and `b` are {grid, pose}, `points` the last scan in base_link. Null when the maps agree up to
// REACH_M; otherwise the place in base_link, with its distance, its bearing, and whether a wall of `a`
// hides it. A place in sight is preferred.
export function whereTheyDiffer(a, b, points) {
  const isSeen = seenPlaces(points);
  const walls = [...wallsOnlyAt(a, b, isSeen), ...wallsOnlyAt(b, a, isSeen)];
  const places = clustersOf(walls, MIN_WALL_M / a.grid.resolution);
  const isHidden = ({ bearing, distance_m }) => a.grid.rayLength(a.pose, a.pose.yaw + bearing, distance_m - BEFORE_WALL_M) !== null;
  const inSight = places.find((place) => !isHidden(place));
  if (inSight) return { ...inSight, hidden: false };
  return places.length ? { ...places[0], hidden: true } : null;
}
