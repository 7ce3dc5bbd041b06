// The shown map in the details: what it is, what can be done with it, and its localizability report.
import { element, part, show } from './dom.js';
import { agoText, metres, percent, plural, sizeText } from './words.js';

function lidarText(lidar) {
  if (!lidar) return 'none stated';
  const beams = lidar.beams ? `${lidar.beams} beams, ` : '';
  const reach = lidar.range_max === null ? 'no limit' : `up to ${metres(lidar.range_max, 0)}`;
  return `${beams}${reach}`;
}

function rows(map, robots, now) {
  const age = (time) => agoText((now - Date.parse(time)) / 1000);
  return [
    ['Size', map.bounds ? sizeText(map.bounds) : 'empty: it has no scan yet'],
    ['Made from', map.floor_map ? 'an occupancy map' : plural(map.keyframes, 'keyframe')],
    ['Corners', String(map.features)],
    ['Cells', metres(map.parameters.grid.resolution_m)],
    ['Revision', `${map.revision}, ${age(map.updated)}`],
    ['Created', age(map.created)],
    ['Lidar', lidarText(map.lidar)],
    ['Robots', String(robots)],
    ['Digest', map.digest.slice(0, 12)],
  ];
}

export function showMap(map, robots, now) {
  part('map-buttons').hidden = !map;
  part('trial-form').hidden = !map?.bounds;
  if (!map) {
    show(part('map-facts'), element('p', { class: 'hint' }, 'Choose a map, or add one.'));
    return;
  }
  show(part('map-facts'), element('h2', {}, map.name),
    map.description && element('p', {}, map.description),
    element('dl', {}, ...rows(map, robots, now).flatMap(([name, value]) => [
      element('dt', {}, name), element('dd', {}, value)])));
}

// What differs from another map, of compareGrids(); `other` is its name.
export function showComparison(maps, shown, other, differences) {
  const names = maps.filter(({ name, bounds }) => bounds && name !== shown).map(({ name }) => name);
  showChoices(part('compare-with'), names, other);
  part('compare-form').hidden = !shown || !names.length;
  show(part('comparison'), ...(other ? comparisonTexts(other, differences) : []));
}

let shownChoices = '';  // Names of maps; there may be a thousand.

function showChoices(select, names, chosen) {
  if (shownChoices !== names.join()) {
    shownChoices = names.join();
    const options = ['', ...names].map((name) => element('option', { value: name }, name || 'no other map'));
    select.replaceChildren(...options);
    select.value = chosen ?? '';
  }
  if (document.activeElement !== select) select.value = chosen ?? '';
}

function comparisonTexts(other, differences) {
  if (!differences) return [element('p', { class: 'hint' }, `Loading ${other} …`)];
  const { places, count } = differences;
  if (!count) return [element('p', {}, `The walls are those of ${other}.`)];
  const what = ({ came, went }) => (came && went ? 'walls came and went' : came ? 'walls came' : 'walls went');
  return [element('p', {}, `${plural(count, 'place')} of 2 × 2 m differ${count === 1 ? 's' : ''} from ${other}:`),
    element('div', { class: 'legend' }, swatch('came', 'came'), swatch('went', 'went')),
    element('ul', { class: 'advice' }, ...places.map((place) => (
      element('li', {}, placeLink(place, `Around ${placeText(place)}`), ` ${what(place)}.`))))];
}

const swatch = (name, text) => element('span', { class: name }, text);

// Whether the map will work, in one sentence.
function verdict({ success, success_at_once: at_once, wrong }) {
  const share = `${percent(success)} of the simulated robots found their pose, ${percent(at_once)} before they moved`;
  const errors = wrong ? `; ${plural(wrong, 'pose')} were wrong` : '; no pose was wrong';
  const judgement = success >= 0.95 && !wrong ? 'This map works well' : success >= 0.7 ? 'This map works in most places'
    : 'This map will often leave robots without a pose';
  return `${judgement}: ${share}${errors}.`;
}

const placeLink = (place, text) => element('button', {
  type: 'button', class: 'link', 'data-action': 'show-place', 'data-x': place.x, 'data-y': place.y,
  'data-key': `place-${place.x}-${place.y}`,
}, text);

const placeText = ({ x, y }) => `(${x.toFixed(1)}, ${y.toFixed(1)})`;

function areaItem(area) {
  const parts = [placeLink(area, `Around ${placeText(area)}`), ` robots drive ${metres(area.way_m, 1)} before they find their pose.`];
  if (area.looks_like) parts.push(' It looks like ', placeLink(area.looks_like, placeText(area.looks_like)), '.');
  if (area.better_start) parts.push(' A better start is ', placeLink(area.better_start, placeText(area.better_start)), '.');
  return element('li', {}, ...parts);
}

// `report` is null when it is not asked for, or not there yet.
export function showReport(report) {
  part('report-panel').hidden = !report;
  if (!report) return;
  if (report.state !== 'done') {
    show(part('report'), element('p', { class: 'hint' }, `Simulating robots all over the map: ${percent(report.progress)}`));
    return;
  }
  show(part('report'), element('p', { class: 'verdict' }, verdict(report)),
    element('div', { class: 'legend' }, swatch('way-none', 'at once'), swatch('way-short', 'within 3 m'),
      swatch('way-long', 'within 8 m'), swatch('way-hard', '8 m and more')),
    element('ul', { class: 'advice' }, ...report.advice.map((sentence) => element('li', {}, sentence)),
      ...report.areas.map(areaItem)));
}
