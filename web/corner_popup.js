// What is known of one corner of the map: its members, and which corners are seen around it.
/* global Chart */
import { element } from './dom.js';
import { color } from './paint.js';
import { degrees, metres, percent, plural } from './words.js';

function facts(corner) {
  const rows = [
    ['Position', `x ${metres(corner.x)}, y ${metres(corner.y)}`],
    ['Direction', `${degrees(corner.bisector, 0)}, ${corner.convex ? 'convex' : 'concave'}`],
    ['Angle of the walls', degrees(corner.angle, 0)],
    ['Seen in', plural(corner.count, 'keyframe')],
  ];
  if (corner.sigma) rows.push(['Standard deviation', metres(corner.sigma, 3)]);
  return element('dl', {}, ...rows.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]));
}

// The descriptor's entries as points around the corner [m].
export function descriptorPoints({ entries, distance_resolution_m: step, angle_resolution_rad: turn }) {
  return entries.map(({ distance_bin: distance, angle_bin: angle }) => {
    const [radius, direction] = [(distance + 0.5) * step, (angle + 0.5) * turn];
    return { x: radius * Math.cos(direction), y: radius * Math.sin(direction) };
  });
}

function plot(canvas, points) {
  const reach = Math.ceil(Math.max(1, ...points.map(({ x, y }) => Math.max(Math.abs(x), Math.abs(y)))));
  const axis = (text) => ({
    min: -reach, max: reach, title: { display: true, text, color: color('faint') },
    ticks: { maxTicksLimit: 5, color: color('faint') }, grid: { color: color('line') },
  });
  return new Chart(canvas, {
    type: 'scatter',
    data: { datasets: [{ data: points, pointRadius: 2, backgroundColor: color('corner') },
      { data: [{ x: 0, y: 0 }], pointRadius: 5, backgroundColor: color('local-corner') }] },
    options: {
      animation: false, aspectRatio: 1, plugins: { legend: { display: false }, tooltip: { enabled: false } },
      scales: { x: axis('m, along its direction'), y: axis('m') },
    },
  });
}

function aliasesText(aliases) {
  if (!aliases.length) return 'No other corner of the map has surroundings like it.';
  return element('span', {}, 'Surroundings like it: ', ...aliases.flatMap(({ corner, share }, i) => [i ? ', ' : '',
    element('button', { type: 'button', class: 'link', 'data-action': 'show-place', 'data-x': corner.x, 'data-y': corner.y },
      `corner ${corner.id}`), ` (${percent(share)})`]), '.');
}

// `descriptor` is a promise of the server's answer, `aliases` those of aliasesOf().
export function cornerPopup(corner, descriptor, aliases) {
  const figure = element('figure', { class: 'descriptor' });
  const content = element('div', { class: 'corner-popup' }, element('h3', {}, `Corner ${corner.id}`), facts(corner), element('p', { class: 'aliases' }, aliasesText(aliases)), figure);
  descriptor.then((known) => {
    const text = `Its descriptor has ${plural(known.entries.length, 'other corner')}, by distance and angle.`;
    const canvas = element('canvas', { role: 'img', 'aria-label': text, width: 190, height: 190 });
    figure.append(...(window.Chart ? [canvas] : []), element('figcaption', {}, text));
    if (window.Chart) plot(canvas, descriptorPoints(known));
  }).catch((error) => figure.append(`The descriptor could not be loaded: ${error.message}`));
  return content;
}
