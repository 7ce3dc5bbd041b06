// What is to be drawn of one answer: its candidate poses, how the scan fits the map at each, and what
// would settle which is correct. Costly parts are made when they are first asked for.
import { fitScan } from './scan_fit.js';
import { whereTheyDiffer } from './settle.js';
import { distance, transform } from './geometry.js';

const SAME_M = 0.5;

export class Scene {
  #grids;
  #mount;
  #fits = new Map();     // By pose.
  #settles = new Map();  // By the index of the pose that is compared with the best.

  // `before` is the last pose that was known, or null. It is left out when it is a candidate. `grids` has get(map), a Grid or null while it is
  // not loaded.
  constructor(answer, { mount, before = null, grids }) {
    [this.answer, this.#mount, this.#grids] = [answer, mount ?? { x: 0, y: 0 }, grids];
    this.points = answer.scan_points ?? [];
    this.candidates = answer.pose ? [answer.pose] : answer.hypotheses;
    const isKnown = before && this.candidates.some((pose) => pose.map === before.map && distance(pose, before) < SAME_M);
    this.before = answer.status === 'lost' && !isKnown ? before : null;
  }

  get isAccepted() {
    return Boolean(this.answer.pose);
  }

  gridAt({ map }) {
    return this.#grids.get(map);
  }

  // Of a pose; null while its map is not loaded, or when the scan's points are not known.
  fitAt(pose) {
    if (this.#fits.has(pose)) return this.#fits.get(pose);
    const grid = pose && this.points.length ? this.gridAt(pose) : null;
    if (!grid) return null;
    const fit = fitScan(grid, pose, this.points, this.#mount);
    this.#fits.set(pose, fit);
    return fit;
  }

  fit(index) {
    return this.fitAt(this.candidates[index]);
  }

  // What tells the chosen candidate from the best, or the best from the second: {other, place, target}.
  // `place` is in base_link, `target` in the best one's map. Undefined while it cannot be known.
  settle(chosen) {
    const other = chosen || 1;
    if (this.#settles.has(other)) return this.#settles.get(other);
    if (!this.candidates[other] || !this.points.length) return undefined;
    const [a, b] = [0, other].map((index) => ({ grid: this.gridAt(this.candidates[index]), pose: this.candidates[index] }));
    if (!a.grid || !b.grid) return undefined;
    const place = whereTheyDiffer(a, b, this.points);
    const settle = { other, place, target: place && transform(a.pose, [place.x, place.y]) };
    this.#settles.set(other, settle);
    return settle;
  }
}
