// Draws a grid, features, a scan at a pose, hypotheses and a path. Takes metres in `map` (x right, y up);
// what Leaflet calls latitude and longitude is y and x, and only this file knows.
/* global L */

const at = ({ x, y }) => L.latLng(y, x);

export const place = (pose, [x, y]) => ({
  x: pose.x + x * Math.cos(pose.yaw) - y * Math.sin(pose.yaw),
  y: pose.y + x * Math.sin(pose.yaw) + y * Math.cos(pose.yaw),
});

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// The robot as a triangle that points where it looks [m].
const ROBOT_OUTLINE = [[0.45, 0], [-0.3, 0.28], [-0.15, 0], [-0.3, -0.28]];
const MAX_PAIRS = 8;  // That look alike.
const WAY_COLORS = [[0.5, 'way-none'], [3, 'way-short'], [8, 'way-long'], [Infinity, 'way-hard']];  // Up to metres.
const BEST_ZOOM = 5;  // 32 pixels a metre.

export class MapView {
  #map;
  #grid = null;
  #features;
  #report;
  #live;
  #liveRenderer;

  constructor(element, { interactive = true } = {}) {
    this.#map = L.map(element, {
      crs: L.CRS.Simple, preferCanvas: true, minZoom: -3, maxZoom: 8, zoomSnap: 0.25, zoomAnimation: false,
      attributionControl: false, zoomControl: interactive, dragging: interactive, keyboard: interactive,
      scrollWheelZoom: interactive, doubleClickZoom: interactive, boxZoom: interactive, touchZoom: interactive,
    });
    this.#map.setView([0, 0], 2);
    // What changes with every scan has a canvas of its own, so that the map's features are not drawn again.
    this.#map.createPane('live').style.zIndex = 450;
    this.#liveRenderer = L.canvas({ pane: 'live', padding: 0.2 });
    this.#report = L.layerGroup().addTo(this.#map);
    this.#features = L.layerGroup().addTo(this.#map);
    this.#live = L.layerGroup().addTo(this.#map);
    if (interactive) L.control.scale({ imperial: false }).addTo(this.#map);
    new ResizeObserver(() => this.#map.invalidateSize({ animate: false })).observe(element);
  }

  // `grid` is {image, width, height, resolution, origin}, the image a blob, or null for none.
  setGrid(grid, { moveView }) {
    if (this.#grid) {
      URL.revokeObjectURL(this.#grid.getElement().src);
      this.#grid.remove();
      this.#grid = null;
    }
    if (!grid) return;
    const corner = { x: grid.origin.x + grid.width * grid.resolution, y: grid.origin.y + grid.height * grid.resolution };
    const bounds = L.latLngBounds(at(grid.origin), at(corner));
    this.#grid = L.imageOverlay(URL.createObjectURL(grid.image), bounds, { className: 'grid' }).addTo(this.#map);
    if (moveView) this.#map.fitBounds(bounds, { animate: false });
    this.#map.setMaxBounds(bounds.pad(1));  // Now, or it would move the view away again.
  }

  setFeatures(features) {
    this.#features.clearLayers();
    for (const feature of features) {
      L.circleMarker(at(feature), {
        radius: 3, weight: 1, color: color('feature'), fillOpacity: 0.25, interactive: false,
      }).addTo(this.#features);
    }
  }

  // Places of the localizability report in colours by the way that robots drive, and the pairs that look alike.
  setReport(report) {
    this.#report.clearLayers();
    if (!report) return;
    for (const { a, b } of report.look_alikes.slice(0, MAX_PAIRS)) {
      L.polyline([at(a), at(b)], {
        color: color('hypothesis'), weight: 1.5, dashArray: '6 6', interactive: false,
      }).addTo(this.#report);
    }
    for (const spot of report.places) {
      const shade = color(WAY_COLORS.find(([limit]) => spot.way_m < limit)[1]);
      L.circle(at(spot), {
        radius: Math.min(0.8, 0.35 * report.lattice_m), weight: 1, color: shade, fillColor: shade, fillOpacity: 0.6,
      }).bindTooltip(`${spot.way_m.toFixed(1)} m to the fix`).addTo(this.#report);
    }
  }

  clearLive() {
    this.#live.clearLayers();
  }

  drawPath(pieces) {
    this.#add(L.polyline(pieces.map((piece) => piece.map(at)), {
      color: color('path'), weight: 3, smoothFactor: 0, noClip: true, ...this.#liveOptions(),
    }));
  }

  // Points and features are in base_link, `pose` is base_link in the map. What is not confirmed looks so.
  drawRobot(pose, { scanPoints, featurePoints, confirmed }) {
    const scanColor = color(confirmed ? 'scan' : 'unconfirmed');
    this.#dots(pose, scanPoints, { radius: 1.5, stroke: false, fillColor: scanColor, fillOpacity: 1 });
    this.#dots(pose, featurePoints, { radius: 5, weight: 2, color: color('local-feature'), fill: false });
    this.#add(L.polygon(ROBOT_OUTLINE.map((point) => at(place(pose, point))), {
      color: color('robot'), weight: 2, fillColor: color('robot'), fillOpacity: confirmed ? 1 : 0.3,
      dashArray: confirmed ? null : '4 4', ...this.#liveOptions(),
    }));
    this.#add(L.circleMarker(at(pose), {
      radius: 10, weight: 2, color: color('robot'), fill: false, dashArray: confirmed ? null : '4 4', ...this.#liveOptions(),
    }));
  }

  // Ranked places, best first: numbered, with the heading as a line.
  drawHypotheses(hypotheses) {
    hypotheses.forEach((hypothesis, index) => {
      this.#add(L.polyline([at(hypothesis), at(place(hypothesis, [1.2, 0]))], {
        color: color('hypothesis'), weight: 3, ...this.#liveOptions(),
      }));
      const icon = L.divIcon({ className: 'hypothesis', html: String(index + 1), iconSize: [22, 22] });
      this.#add(L.marker(at(hypothesis), { icon, interactive: false, keyboard: false }));
    });
  }

  // Moves the view only when the robot is about to leave it.
  follow(pose) {
    if (!this.#map.getBounds().pad(-0.15).contains(at(pose))) {
      this.#map.setView(at(pose), this.#map.getZoom(), { animate: false });
    }
  }

  // Goes close to a place that was not known before.
  focus(pose) {
    this.#map.setView(at(pose), Math.max(this.#map.getZoom(), BEST_ZOOM), { animate: false });
  }

  // Shows the whole square around the origin that holds the points.
  fitAround(pose, points) {
    const reach = Math.max(2, ...points.map(([x, y]) => Math.hypot(x, y)));
    const corners = [-reach, reach].map((d) => at({ x: pose.x + d, y: pose.y + d }));
    this.#map.fitBounds(L.latLngBounds(corners), { animate: false });
  }

  #dots(pose, points, style) {
    for (const point of points) {
      this.#add(L.circleMarker(at(place(pose, point)), { ...style, ...this.#liveOptions() }));
    }
  }

  #liveOptions() {
    return { interactive: false, renderer: this.#liveRenderer };
  }

  #add(layer) {
    layer.addTo(this.#live);
  }
}
