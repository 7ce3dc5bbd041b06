// What is to be drawn of one answer: its candidate poses, how the scan fits the map at each, and what
// would settle which is correct. Costly parts are made when they are first asked for.
import { fitScan } from './scan_fit.js';
import { whereTheyDiffer } from './settle.js';
import { transform } from './geometry.js';

export class Scene {
  #grids;
  #mount;
  #fits = new Map();
  #settle;

  // `grids` has get(map), a Grid or null while it is not loaded.
  constructor(answer, mount, grids) {
    [this.answer, this.#mount, this.#grids] = [answer, mount ?? { x: 0, y: 0 }, grids];
    this.points = answer.scan_points ?? [];
    this.candidates = answer.pose ? [answer.pose] : answer.hypotheses;
  }

  get isAccepted() {
    return Boolean(this.answer.pose);
  }

  grid(index) {
    return this.#grids.get(this.candidates[index].map);
  }

  // Null while the map is not loaded, or when the scan's points are not known.
  fit(index) {
    if (this.#fits.has(index)) return this.#fits.get(index);
    const grid = this.candidates[index] && this.points.length ? this.grid(index) : null;
    if (!grid) return null;
    const fit = fitScan(grid, this.candidates[index], this.points, this.#mount);
    this.#fits.set(index, fit);
    return fit;
  }

  // {place, target}: in base_link, and in the map of the best; undefined while it cannot be known.
  settle() {
    if (this.#settle || this.candidates.length < 2 || !this.points.length) return this.#settle;
    const [a, b] = [0, 1].map((index) => ({ grid: this.grid(index), pose: this.candidates[index] }));
    if (!a.grid || !b.grid) return undefined;
    const place = whereTheyDiffer(a, b, this.points);
    this.#settle = { place, target: place && transform(a.pose, [place.x, place.y]) };
    return this.#settle;
  }
}
