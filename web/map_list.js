// The list of maps: found, sorted, with a thumbnail each.
import { KeyedList, bringIntoSight, element, part, setText, show } from './dom.js';
import { addressOf } from './address.js';
import { Thumbnails } from './thumbnails.js';
import { agoText, plural, sizeText } from './words.js';

const area = ({ bounds }) => (bounds ? (bounds.max_x - bounds.min_x) * (bounds.max_y - bounds.min_y) : 0);

const ORDERS = {
  name: (a, b) => a.map.name.localeCompare(b.map.name, 'en', { numeric: true }),
  updated: (a, b) => b.map.updated.localeCompare(a.map.updated),
  area: (a, b) => area(b.map) - area(a.map),
  robots: (a, b) => b.robots - a.robots,
};

export class MapList {
  #form = part('map-filter');
  #thumbnails = new Thumbnails();
  #list = new KeyedList(part('maps'), {
    key: ({ map }) => map.name,
    version: ({ map, robots, current, href }) => JSON.stringify([map.name, map.digest, map.revision, map.features,
      map.description, robots, current, href]),
    make: (row) => this.#makeRow(row),
  });
  #maps = [];
  #robots = new Map();
  #chosen = {};
  #now = 0;
  #seen = null;  // The chosen map that was scrolled to.

  constructor() {
    this.#form.addEventListener('input', () => this.#draw());
    this.#form.addEventListener('submit', (event) => event.preventDefault());
  }

  // `robots` counts sessions by map name.
  show(maps, robots, chosen, now) {
    [this.#maps, this.#robots, this.#chosen, this.#now] = [maps, robots, chosen, now];
    if (part('maps-pane').hidden) return;
    this.#draw();
    if (this.#seen !== chosen.map && this.#list.node(chosen.map)) this.#scrollToChosen();
  }

  #draw() {
    const text = this.#form.elements.text.value.trim().toLowerCase();
    const rows = this.#maps
      .filter(({ name, description }) => !text || `${name}\n${description}`.toLowerCase().includes(text))
      .map((map) => ({
        map,
        robots: this.#robots.get(map.name) ?? 0,
        current: map.name === this.#chosen.map,
        href: addressOf({ map: map.name, session: this.#chosen.session, tab: 'maps' }),
      }));
    rows.sort((a, b) => ORDERS[this.#form.elements.order.value](a, b) || ORDERS.name(a, b));
    this.#list.show(rows);
    for (const { map } of rows) {
      setText(this.#list.node(map.name).querySelector('.age'), agoText((this.#now - Date.parse(map.updated)) / 1000));
    }
    this.#hint(rows.length);
  }

  // Once: afterwards the list stays where the reader scrolls it.
  #scrollToChosen() {
    this.#seen = this.#chosen.map;
    bringIntoSight(this.#list.node(this.#seen));
  }

  #makeRow({ map, robots, current, href }) {
    const facts = [map.bounds ? sizeText(map.bounds) : 'empty', plural(map.features, 'corner'), `revision ${map.revision}`];
    if (robots) facts.push(plural(robots, 'robot'));
    return element('li', {}, element('a', {
      href, class: 'map-row', 'data-key': `map-${map.name}`, 'aria-current': current ? 'true' : undefined,
    }, element('span', { class: 'thumb' }, this.#thumbnails.of(map)), element('span', { class: 'text' },
      element('strong', {}, map.name), element('small', { class: 'age' }), element('small', {}, facts.join(' · ')),
      map.description && element('small', { class: 'description' }, map.description))));
  }

  #hint(shown) {
    if (this.#maps.length) {
      show(part('maps-hint'), shown === this.#maps.length ? '' : `${plural(shown, 'map')} of ${this.#maps.length}`);
      return;
    }
    show(part('maps-hint'), element('p', {}, 'There is no map yet. Add one here, or build one from a recorded run:'),
      element('code', {}, 'cornerfix map build NAME LOG'),
      element('p', {}, 'An occupancy map of map_server is imported by:'),
      element('code', {}, 'cornerfix map import NAME MAP.yaml'),
      element('p', {}, element('button', { type: 'button', id: 'demo', 'data-action': 'demo' },
        'Load the demo map (Willow Garage)')));
  }
}
