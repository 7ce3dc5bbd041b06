// The map that can be dragged and zoomed: a grid and painted marks. Takes metres in `map` (x right,
// y up); what Leaflet calls latitude and longitude is y and x.
/* global L */
import { GridTiles, PaintedLayer } from './map_layers.js';

const at = ({ x, y }) => L.latLng(y, x);
const point = ({ lat, lng }) => ({ x: lng, y: lat });
const BEST_ZOOM = 5;  // 32 pixels per metre.

export class MapView {
  #map;
  #tiles = null;
  #layers = [];

  // `on` has move(view, byHand), pointer(point or null) and click(point).
  constructor(element, on) {
    this.#map = L.map(element, {
      crs: L.CRS.Simple, minZoom: -3, maxZoom: 8, zoomSnap: 0.25, zoomAnimation: false, fadeAnimation: false,
      attributionControl: false, doubleClickZoom: false,
    });
    this.#map.setView([0, 0], 2);
    L.control.scale({ imperial: false, maxWidth: 160 }).addTo(this.#map);
    new ResizeObserver(() => this.#map.invalidateSize({ animate: false })).observe(element);
    this.#listen(on);
  }

  #listen(on) {
    let byHand = false;
    const hand = () => { byHand = true; };
    this.#map.on('dragstart', hand);
    for (const event of ['wheel', 'keydown']) this.#map.getContainer().addEventListener(event, hand, { passive: true });
    this.#map.zoomControl.getContainer().addEventListener('click', hand, { capture: true });
    this.#map.on('moveend', () => {
      on.move(this.view, byHand);
      byHand = false;
    });
    this.#map.on('mousemove', ({ latlng }) => on.pointer(point(latlng)));
    this.#map.on('mouseout', () => on.pointer(null));
    this.#map.on('click', ({ latlng }) => on.click(point(latlng)));
  }

  // Layers draw over the grid in the order in which they are added. Returns what draws one again.
  addLayer(name, paint) {
    const pane = this.#map.createPane(name);
    pane.style.zIndex = 400 + this.#layers.length;
    pane.style.pointerEvents = 'none';
    const layer = new PaintedLayer(paint, { pane: name });
    layer.addTo(this.#map);
    this.#layers.push(layer);
    return () => layer.redraw();
  }

  redrawAll() {
    for (const layer of this.#layers) layer.redraw();
  }

  // A Grid, or null for none. `look` moves the view, before it is kept near the grid: afterwards Leaflet
  // would move it there, slowly.
  setGrid(grid, look = () => {}) {
    this.#tiles?.remove();
    this.#tiles = null;
    this.#map.setMaxBounds(null);
    if (!grid) return;
    this.#tiles = new GridTiles(grid).addTo(this.#map);
    look();
    this.#map.setMaxBounds(L.latLngBounds(this.#corners(grid.bounds)).pad(1));
  }

  get view() {
    return { ...point(this.#map.getCenter()), z: this.#map.getZoom() };
  }

  setView({ x, y, z }) {
    this.#map.setView(at({ x, y }), z, { animate: false });
  }

  fit(bounds) {
    this.#map.fitBounds(this.#corners(bounds), { animate: false, padding: [10, 10] });
  }

  // Shows all of these places, but not closer than a pose is shown.
  fitPlaces(places) {
    const bounds = L.latLngBounds(places.map(at)).pad(0.25);
    const zoom = Math.min(this.#map.getBoundsZoom(bounds), BEST_ZOOM);
    this.#map.setView(bounds.getCenter(), zoom, { animate: false });
  }

  // Pixels per metre.
  get scale() {
    return 2 ** this.#map.getZoom();
  }

  // Moves the view only when the pose is about to leave it.
  follow(pose) {
    if (!this.#map.getBounds().pad(-0.15).contains(at(pose))) {
      this.#map.setView(at(pose), this.#map.getZoom(), { animate: false });
    }
  }

  // Goes close to a pose that was not known before.
  focus(pose) {
    this.#map.setView(at(pose), Math.max(this.#map.getZoom(), BEST_ZOOM), { animate: false });
  }

  openPopup(place, content) {
    L.popup({ maxWidth: 320, autoPanPadding: [20, 20] }).setLatLng(at(place)).setContent(content).openOn(this.#map);
  }

  #corners({ min_x, min_y, max_x, max_y }) {
    return [[min_y, min_x], [max_y, max_x]];
  }
}
