// Grids of maps, loaded when they are first asked for. A load that fails is tried again.
import { ApiError, mapGrid } from './api_client.js';
import { Grid } from './grid.js';

const MAX_KEPT = 4;
const RETRY_MS = [1000, 2000, 5000, 10000];

export class GridCache {
  #maps = new Map();     // The server's entries by name.
  #grids = new Map();    // Loaded ones by name, the last used last: {revision, grid}.
  #loading = new Map();  // Revisions by name.
  #on;

  // `on` has loaded(name) and failed(name, error, retry_ms).
  constructor(on) {
    this.#on = on;
  }

  know(maps) {
    this.#maps = new Map(maps.map((map) => [map.name, map]));
  }

  // The grid of the map as far as it is loaded, perhaps of the revision before; else null.
  get(name) {
    const entry = this.#maps.get(name);
    if (!entry?.bounds) return null;
    const known = this.#grids.get(name);
    if (known?.revision !== entry.revision) this.#load(entry, 0);
    if (!known) return null;
    this.#grids.delete(name);
    this.#grids.set(name, known);
    return known.grid;
  }

  async #load({ name, revision }, attempt) {
    if (this.#loading.get(name) === revision && attempt === 0) return;
    this.#loading.set(name, revision);
    try {
      const { image, description } = await mapGrid(name);
      this.#keep(name, revision, await Grid.load(image, description));
      this.#loading.delete(name);
      this.#on.loaded(name);
    } catch (error) {
      if (error instanceof ApiError && error.status === 404) {
        this.#loading.delete(name);
        return;
      }
      const retry_ms = RETRY_MS[Math.min(attempt, RETRY_MS.length - 1)];
      this.#on.failed(name, error, retry_ms);
      setTimeout(() => this.#retry(name, attempt + 1), retry_ms);
    }
  }

  #retry(name, attempt) {
    const entry = this.#maps.get(name);
    if (entry) this.#load(entry, attempt);
    else this.#loading.delete(name);
  }

  #keep(name, revision, grid) {
    this.#grids.get(name)?.grid.close();
    this.#grids.delete(name);
    this.#grids.set(name, { revision, grid });
    if (this.#grids.size <= MAX_KEPT) return;
    const [oldest, { grid: old }] = this.#grids.entries().next().value;
    this.#grids.delete(oldest);
    old.close();
  }
}
