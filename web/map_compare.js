// What differs between two maps of one frame: walls that came and walls that went. A wall counts only
// where the other map is free, since nothing is known elsewhere.
import { CELL } from './grid.js';

const TOLERANCE_M = 0.2;  // Walls that are drawn this far apart are the same.
const PLACE_M = 2;
const MIN_CELLS = 4;  // Of a place; fewer are noise.
const MAX_PLACES = 8;

function wallsWithout(one, other) {
  const found = [];
  one.eachWall((point) => {
    if (other.cellAt(point) === CELL.free && !other.isWallNear(point, TOLERANCE_M)) found.push(point);
  });
  return found;
}

// Squares of PLACE_M with their cells of either kind.
function gather(came, went) {
  const places = new Map();
  for (const [kind, points] of [['came', came], ['went', went]]) {
    for (const { x, y } of points) {
      const key = `${Math.floor(x / PLACE_M)},${Math.floor(y / PLACE_M)}`;
      const place = places.get(key) ?? { x: 0, y: 0, came: 0, went: 0 };
      places.set(key, place);
      ++place[kind];
      place.x += x;
      place.y += y;
    }
  }
  return [...places.values()].map(({ x, y, came: c, went: w }) => ({ x: x / (c + w), y: y / (c + w), came: c, went: w }))
    .filter((place) => place.came + place.went >= MIN_CELLS);
}

// `shown` and `other` are Grids: {came, went, places, count}. The points are cells [m], the places the
// largest ones first.
export function compareGrids(shown, other) {
  const [came, went] = [wallsWithout(shown, other), wallsWithout(other, shown)];
  const places = gather(came, went).sort((a, b) => b.came + b.went - a.came - a.went);
  return { came, went, places: places.slice(0, MAX_PLACES), count: places.length };
}
