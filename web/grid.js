// An occupancy grid as the page needs it: pictures to draw at several scales, and classes to look up.
import { distance } from './geometry.js';

const STRIP_ROWS = 256;
const SMALLEST_LEVEL = 512;  // [px]

export const CELL = { free: 0, unknown: 1, wall: 2 };

// map_server's yaml is flat: `key: value` lines, the origin as [x, y, yaw].
export function parseGridYaml(text) {
  const value = (key) => text.match(new RegExp(`^${key}:\\s*(.+)$`, 'm'))?.[1] ?? '';
  const [x, y, yaw] = value('origin').replace(/[[\]]/g, '').split(',').map(Number);
  return {
    resolution: Number(value('resolution')),
    origin: { x, y, yaw },
    negate: /^(1|true)/i.test(value('negate')),
    occupied: Number(value('occupied_thresh')),
    free: Number(value('free_thresh')),
  };
}

export class Grid {
  #levels;  // Each half of the one before.
  #cells = null;

  // Use load(). `x` and `y` are the lower left corner in `map` [m].
  constructor({ levels, resolution, x, y, thresholds }) {
    this.#levels = levels;
    this.resolution = resolution;
    this.thresholds = thresholds;
    [this.width, this.height] = [levels[0].width, levels[0].height];
    this.bounds = { min_x: x, min_y: y, max_x: x + this.width * resolution, max_y: y + this.height * resolution };
  }

  // `image` is a blob, `description` that of parseGridYaml().
  static async load(image, description) {
    const upright = await uprightBitmap(await createImageBitmap(image), description);
    const { occupied, free, negate } = description;
    return new Grid({
      levels: await halvings(upright.bitmap), resolution: description.resolution, x: upright.x, y: upright.y,
      thresholds: { occupied, free, negate },
    });
  }

  close() {
    for (const level of this.#levels) level.close();
  }

  // The picture to draw at so many pixels per metre, and its own pixels per metre.
  level(scale) {
    const wanted = Math.floor(Math.log2(Math.max(1, 1 / (this.resolution * scale))));
    const index = Math.min(this.#levels.length - 1, wanted);
    const bitmap = this.#levels[index];
    return { bitmap, scale: bitmap.width / (this.bounds.max_x - this.bounds.min_x) };
  }

  cellAt(point) {
    return this.#cell(...this.#indices(point));
  }

  isWallNear(point, radius_m) {
    const [column, row] = this.#indices(point);
    const reach = Math.ceil(radius_m / this.resolution);
    const limit = (radius_m / this.resolution) ** 2;
    for (let dy = -reach; dy <= reach; ++dy) {
      for (let dx = -reach; dx <= reach; ++dx) {
        if (dx * dx + dy * dy <= limit && this.#cell(column + dx, row + dy) === CELL.wall) return true;
      }
    }
    return false;
  }

  // Calls back with the middle of each wall cell [m].
  eachWall(found) {
    this.#eachWallIn(0, 0, this.width, this.height, found);
  }

  // The same for cells at most `reach_m` away from a point.
  eachWallNear(point, reach_m, found) {
    const [column, row] = this.#indices(point);
    const reach = Math.ceil(reach_m / this.resolution);
    this.#eachWallIn(Math.max(0, column - reach), Math.max(0, row - reach), Math.min(this.width, column + reach),
      Math.min(this.height, row + reach), (wall) => distance(wall, point) <= reach_m && found(wall));
  }

  #eachWallIn(left, top, right, bottom, found) {
    for (let row = top; row < bottom; ++row) {
      for (let column = left; column < right; ++column) {
        if (this.#cell(column, row) !== CELL.wall) continue;
        found({ x: this.bounds.min_x + (column + 0.5) * this.resolution, y: this.bounds.max_y - (row + 0.5) * this.resolution });
      }
    }
  }

  // Where a ray from `from` first meets a wall, at most `reach_m` away; null when it meets none.
  rayLength(from, yaw, reach_m) {
    const step = this.resolution / 2;
    for (let length = 0; length <= reach_m; length += step) {
      const at = { x: from.x + length * Math.cos(yaw), y: from.y + length * Math.sin(yaw) };
      if (this.cellAt(at) === CELL.wall) return length;
    }
    return null;
  }

  // Decoded at the first look-up: a third of the pages need no cell.
  #cell(column, row) {
    if (column < 0 || row < 0 || column >= this.width || row >= this.height) return CELL.unknown;
    this.#cells ??= classify(this.#levels[0], this.thresholds);
    return this.#cells[row * this.width + column];
  }

  #indices({ x, y }) {
    return [Math.floor((x - this.bounds.min_x) / this.resolution),
      this.height - 1 - Math.floor((y - this.bounds.min_y) / this.resolution)];
  }
}

async function halvings(bitmap) {
  const levels = [bitmap];
  for (let last = bitmap; Math.max(last.width, last.height) > SMALLEST_LEVEL; levels.push(last)) {
    last = await createImageBitmap(last, {
      resizeWidth: Math.ceil(last.width / 2), resizeHeight: Math.ceil(last.height / 2), resizeQuality: 'medium',
    });
  }
  return levels;
}

// In strips, so that a large map needs no second copy in full colour.
function classify(bitmap, { occupied, free, negate }) {
  const classOf = Uint8Array.from({ length: 256 }, (_, gray) => {
    const occupancy = negate ? gray / 255 : (255 - gray) / 255;
    if (occupancy > occupied) return CELL.wall;
    return occupancy < free ? CELL.free : CELL.unknown;
  });
  const { width, height } = bitmap;
  const cells = new Uint8Array(width * height);
  const strip = new OffscreenCanvas(width, Math.min(STRIP_ROWS, height));
  const context = strip.getContext('2d', { willReadFrequently: true });
  for (let top = 0; top < height; top += strip.height) {
    const rows = Math.min(strip.height, height - top);
    context.clearRect(0, 0, width, rows);
    context.drawImage(bitmap, 0, top, width, rows, 0, 0, width, rows);
    const pixels = context.getImageData(0, 0, width, rows).data;
    for (let i = 0; i < width * rows; ++i) {
      cells[top * width + i] = pixels[4 * i + 3] < 128 ? CELL.unknown : classOf[pixels[4 * i]];
    }
  }
  return cells;
}

// An occupancy map may be turned in its map frame, and tiles lie along the axes: the picture that
// covers the box around it, with that box's lower left corner. What is not the grid's is transparent.
async function uprightBitmap(bitmap, { resolution, origin: { x, y, yaw } }) {
  if (yaw === 0) return { bitmap, x, y };
  const { width, height } = bitmap;
  const cos = Math.cos(yaw);
  const sin = Math.sin(yaw);
  // The grid's corners, in cells from its origin, y up.
  const xs = [0, width * cos, -height * sin, width * cos - height * sin];
  const ys = [0, width * sin, height * cos, width * sin + height * cos];
  const left = Math.min(...xs);
  const bottom = Math.min(...ys);
  const canvas = new OffscreenCanvas(Math.ceil(Math.max(...xs) - left), Math.ceil(Math.max(...ys) - bottom));
  const context = canvas.getContext('2d');
  context.imageSmoothingEnabled = false;
  // Pixels count from the upper left corner, y down, in the image as on the canvas.
  context.setTransform(cos, -sin, sin, cos, -height * sin - left, canvas.height + bottom - height * cos);
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return { bitmap: canvas.transferToImageBitmap(), x: x + left * resolution, y: y + bottom * resolution };
}
