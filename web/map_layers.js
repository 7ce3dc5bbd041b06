// Leaflet layers that draw on canvases: the grid in tiles, and marks over it. Leaflet's latitude and
// longitude are y and x in metres.
/* global L */

const TILE_PX = 256;
const PADDING = 0.25;  // Of the view's size, drawn beyond its edges, for dragging.

// A grid (grid.js) in tiles: only what is in view is drawn, whatever the map's size.
export const GridTiles = L.GridLayer.extend({
  initialize(grid, options) {
    this._grid = grid;
    const { min_x, min_y, max_x, max_y } = grid.bounds;
    L.GridLayer.prototype.initialize.call(this, {
      bounds: [[min_y, min_x], [max_y, max_x]], tileSize: TILE_PX, noWrap: true, keepBuffer: 1, minZoom: -4,
      maxZoom: 9, className: 'grid', ...options,
    });
  },

  createTile({ x, y, z }) {
    const tile = document.createElement('canvas');
    const ratio = window.devicePixelRatio || 1;
    [tile.width, tile.height] = [TILE_PX * ratio, TILE_PX * ratio];
    const scale = 2 ** z;  // Pixels per metre.
    const { bitmap, scale: own } = this._grid.level(scale * ratio);
    const context = tile.getContext('2d');
    context.imageSmoothingEnabled = own > scale * ratio;
    const { min_x, max_y } = this._grid.bounds;
    const zoom = (scale * ratio) / own;
    context.setTransform(zoom, 0, 0, zoom, (min_x * scale - x * TILE_PX) * ratio, (-max_y * scale - y * TILE_PX) * ratio);
    context.drawImage(bitmap, 0, 0);
    return tile;
  },
});

// Marks that `paint(context, view)` draws; `view` has at({x, y}) in pixels, scale [px/m] and bounds.
export const PaintedLayer = L.Layer.extend({
  initialize(paint, options) {
    this._paint = paint;
    L.setOptions(this, options);
  },

  onAdd(map) {
    this._canvas = L.DomUtil.create('canvas', 'painted', map.getPane(this.options.pane));
    this._draw();
  },

  onRemove() {
    this._canvas.remove();
  },

  getEvents() {
    return { moveend: this._draw, resize: this._draw };
  },

  redraw() {
    this._frame ??= requestAnimationFrame(() => {
      this._frame = undefined;
      if (this._map) this._draw();
    });
  },

  _draw() {
    const map = this._map;
    const ratio = window.devicePixelRatio || 1;
    const size = map.getSize();
    const offset = size.multiplyBy(PADDING).round();
    const corner = map.containerPointToLayerPoint(offset.multiplyBy(-1));
    const canvas = this._canvas;
    const whole = size.add(offset.multiplyBy(2));
    [canvas.width, canvas.height] = [whole.x * ratio, whole.y * ratio];
    [canvas.style.width, canvas.style.height] = [`${whole.x}px`, `${whole.y}px`];
    L.DomUtil.setPosition(canvas, corner);
    const scale = 2 ** map.getZoom();
    const origin = map.latLngToLayerPoint([0, 0]).subtract(corner);
    const context = canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this._paint(context, {
      at: ({ x, y }) => [origin.x + x * scale, origin.y - y * scale],
      scale,
      bounds: {
        min_x: -origin.x / scale, max_x: (whole.x - origin.x) / scale,
        min_y: (origin.y - whole.y) / scale, max_y: origin.y / scale,
      },
    });
  },
});
