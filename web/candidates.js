// Candidate poses in the details: a table, and the last scan laid on the best and on the chosen one.
import { element, part, setText, show } from './dom.js';
import { drawPlace } from './place_picture.js';
import { HIT } from './scan_fit.js';
import * as words from './words.js';

const PICTURE_REACH_M = 12;

const total = (counts) => counts.reduce((sum, count) => sum + count, 0);
const share = (value) => (Number.isFinite(value) ? words.percent(value) : '–');

// Columns of the table: {name, of(pose, index)}. What is the same in all rows has none.
function columnsOf(scene) {
  const onWalls = (_, index) => {
    const fit = scene.fit(index);
    return fit ? share(fit.counts[HIT.explained] / total(fit.counts)) : '–';
  };
  const hasMaps = new Set(scene.candidates.map(({ map }) => map)).size > 1;
  const isLost = scene.answer.status === 'lost';
  return [
    ...(hasMaps ? [{ name: 'map', of: ({ map }) => map }] : []),
    { name: 'x', of: ({ x }) => x.toFixed(2) },
    { name: 'y', of: ({ y }) => y.toFixed(2) },
    { name: 'heading', of: ({ yaw }) => words.degrees(yaw, 0) },
    // A lost robot's share is that of before it was lost.
    ...(isLost ? [] : [{ name: 'local map', of: ({ score }) => share(score) }]),
    { name: 'last scan', of: onWalls },
  ];
}

function row(scene, columns, pose, index, chosen) {
  const button = element('button', {
    type: 'button', class: 'candidate', 'data-action': 'choose-candidate', 'data-index': index,
    'data-key': `candidate-${index}`, 'aria-pressed': String(index === chosen),
    'aria-label': `Lay the scan on pose ${index + 1}`,
  }, String(index + 1));
  return element('tr', { 'aria-current': index === chosen ? 'true' : undefined }, element('td', {}, button),
    ...columns.map(({ of }) => element('td', {}, of(pose, index))));
}

function tableOf(scene, chosen) {
  const columns = columnsOf(scene);
  const [first] = scene.candidates;
  const what = scene.answer.status === 'lost' ? 'Poses that were tracked or searched last' : 'Candidate poses';
  return element('table', {},
    element('caption', {}, `${what} in ${first.map}, best first, with the share of hits on walls. Choose one to lay the last scan on it.`),
    element('thead', {}, element('tr', {}, ...['pose', ...columns.map(({ name }) => name)].map((name) => (
      element('th', { scope: 'col' }, name))))),
    element('tbody', {}, ...scene.candidates.map((pose, index) => row(scene, columns, pose, index, chosen))));
}

function legend({ counts }) {
  const parts = [[HIT.explained, 'explained', 'on walls'], [HIT.contradicted, 'contradicted', 'in free space'],
    [HIT.hidden, 'hidden', 'behind walls'], [HIT.unjudged, 'unjudged', 'not judged']];
  return element('p', { class: 'legend hits' }, ...parts.map(([kind, name, text]) => (
    element('span', { class: `hit-${name}` }, `${counts[kind].toLocaleString('en')} ${text}`))),
  element('span', { class: 'total' }, `of ${words.plural(total(counts), 'hit')}`));
}

// Pictures of the scan: {pose, fit, text}.
function picturesOf(scene, chosen) {
  if (scene.isAccepted) return [{ pose: scene.candidates[0], text: 'At the pose' }];
  const at = (index) => ({ pose: scene.candidates[index], text: `At pose ${index + 1}${index ? '' : ', the best'}` });
  const indices = scene.candidates.length ? [0, ...(chosen ? [chosen] : [])] : [];
  if (indices.length) return indices.map(at);
  return scene.before ? [{ pose: scene.before, text: 'At the last known pose' }] : [];
}

// A scan that no map is laid under: hits that nothing judges.
const bareFit = (points) => ({ hits: points.map(([x, y]) => ({ x, y, kind: HIT.unjudged })) });

function showPictures(pictures) {
  const figures = pictures.map(({ text, fit }) => element('div', {}, element('canvas', {
    role: 'img', 'aria-label': `The last scan, ${text.toLowerCase()}; forward is up`,
  }), element('div', {}, element('p', {}, text), fit.counts && legend(fit))));
  part('fit-pictures').replaceChildren(...figures);
  pictures.forEach(({ grid, pose, fit }, i) => drawPlace(figures[i].querySelector('canvas'), grid, pose, fit, PICTURE_REACH_M));
}

function showFit(scene, chosen) {
  const wanted = picturesOf(scene, chosen);
  const pictures = wanted.map((each) => ({ ...each, grid: scene.gridAt(each.pose), fit: scene.fitAt(each.pose) }))
    .filter(({ fit }) => fit);  // The others' maps are not loaded yet.
  const isBare = !wanted.length && scene.points.length > 0;
  if (isBare) pictures.push({ text: 'No pose is known', grid: null, pose: { x: 0, y: 0, yaw: 0 }, fit: bareFit(scene.points) });
  part('robot-fit').hidden = !pictures.length;
  if (!pictures.length) return;
  showPictures(pictures);
  setText(part('fit-caption'), `The last scan${isBare ? '' : ' on the map'}, ${PICTURE_REACH_M} m around the robot; forward is up.`);
}

// `scene` is null before the first answer.
export function showCandidates(scene, chosen) {
  const hasTable = scene && !scene.isAccepted && scene.candidates.length;
  show(part('robot-candidates'), hasTable ? tableOf(scene, chosen) : '');
  part('robot-fit').hidden = !scene;
  if (scene) showFit(scene, chosen);
}
