// Corners whose surroundings look like those of a given one, so that scans may confuse them.
import { distance } from './geometry.js';

const REACH_M = 6;
const SAME_M = 0.3;
const MIN_SHARE = 0.5;
const MIN_NEIGHBOURS = 4;
const MAX_ALIASES = 3;

// Positions of the other corners within REACH_M, in the corner's own frame.
function surroundings(corners, corner) {
  const [cos, sin] = [Math.cos(corner.bisector), Math.sin(corner.bisector)];
  return corners.filter((other) => other !== corner && distance(other, corner) <= REACH_M).map((other) => {
    const [dx, dy] = [other.x - corner.x, other.y - corner.y];
    return { x: cos * dx + sin * dy, y: -sin * dx + cos * dy };
  });
}

// Share of the larger neighbourhood that is in both.
function agreement(one, other) {
  const common = one.filter((point) => other.some((twin) => distance(point, twin) <= SAME_M)).length;
  return common / Math.max(one.length, other.length);
}

// The corners that look most like `corner`: {corner, share}, best first.
export function aliasesOf(corners, corner) {
  const own = surroundings(corners, corner);
  if (own.length < MIN_NEIGHBOURS) return [];
  return corners.filter((other) => other !== corner && other.convex === corner.convex)
    .map((other) => ({ corner: other, share: agreement(own, surroundings(corners, other)) }))
    .filter(({ share }) => share >= MIN_SHARE)
    .sort((a, b) => b.share - a.share).slice(0, MAX_ALIASES);
}
