// The lists and the selected robot as elements. Knows no server and no map.
import * as words from './words.js';

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== false) made.setAttribute(name, value === true ? '' : value);
  }
  made.append(...children);
  return made;
}

// Replaces what `container` shows, only when it differs, and leaves the keyboard where it was.
function show(container, ...children) {
  const fresh = element('div', {}, ...children);
  if (container.innerHTML === fresh.innerHTML) return;
  const focused = container.contains(document.activeElement) ? document.activeElement.getAttribute('href') : null;
  container.replaceChildren(...fresh.childNodes);
  if (focused) container.querySelector(`a[href="${CSS.escape(focused)}"]`)?.focus();
}

const plural = (count, noun) => `${count} ${noun}${count === 1 ? '' : 's'}`;
const badge = (status) => element('span', { class: 'badge', 'data-status': status }, words.statusText(status));
const hint = (text, command) => element('p', { class: 'hint' }, text, ' ', element('code', {}, command));

export const linkTo = ({ map, session }) => {
  const query = new URLSearchParams();
  if (map) query.set('map', map);
  if (session) query.set('session', session);
  return `#${query}`;
};

function entry({ href, current, title, details }) {
  return element('li', {}, element('a', { href, 'aria-current': current ? 'true' : undefined },
    element('strong', {}, title), ...details));
}

function sizeText({ min_x, min_y, max_x, max_y }) {
  return `${(max_x - min_x).toFixed(0)} × ${(max_y - min_y).toFixed(0)} m`;
}

export function showMaps(container, maps, { map: current, session }) {
  if (!maps.length) {
    show(container, hint('There is no map yet. Make one from a drive with known poses:', 'cornerfix map build NAME LOG'));
    return;
  }
  show(container, element('ul', {}, ...maps.map((map) => entry({
    href: linkTo({ map: map.name, session }),
    current: map.name === current,
    title: map.name,
    details: [element('small', {}, [plural(map.features, 'feature'), map.bounds ? sizeText(map.bounds) : 'empty',
      `revision ${map.revision}`].join(' · '))],
  }))));
}

export function showSessions(container, sessions, { map, session: current }) {
  if (!sessions.length) {
    show(container, hint('No robot is connected. Replay one:', 'cornerfix replay LOG --map NAME'));
    return;
  }
  show(container, element('ul', {}, ...sessions.map((session) => entry({
    href: linkTo({ map: session.map ?? map, session: session.id }),
    current: session.id === current,
    title: session.robot,
    details: [badge(session.last_answer?.status ?? 'collecting'),
      element('small', {}, words.reasonText(session.last_answer?.reason))],
  }))));
}

const pairs = (rows) => element('dl', {}, ...rows.flatMap(([name, value]) => [
  element('dt', {}, name), element('dd', {}, value)]));

function hypothesesTable(hypotheses) {
  const cells = (tag, values) => element('tr', {}, ...values.map((value) => element(tag, {}, String(value))));
  return element('table', {},
    element('caption', {}, 'Places that fit, best first'),
    element('thead', {}, cells('th', ['', 'map', 'x', 'y', 'heading', 'votes', 'inliers', 'score'])),
    element('tbody', {}, ...hypotheses.map((each, index) => cells('td', [index + 1, each.map, each.x.toFixed(2),
      each.y.toFixed(2), words.degrees(each.yaw, 0), each.votes, each.inliers, each.score.toFixed(2)]))));
}

function timingText({ total, ...steps }) {
  const parts = Object.entries(steps).filter(([, value]) => value > 0)
    .map(([step, value]) => `${step} ${words.milliseconds(value)}`);
  return `${words.milliseconds(total)}${parts.length ? ` (${parts.join(', ')})` : ''}`;
}

function answerRows({ pose, confidence, local, sequence, timing_ms: timing }) {
  const rows = [];
  if (pose) rows.push(['Place', `${pose.map}, revision ${pose.revision}`], ['Pose', words.poseText(pose)],
    ['Spread', words.spreadText(pose.covariance)]);
  rows.push(['Confidence', words.percent(confidence)],
    ['Seen', `${plural(local.scans, 'scan')}, ${plural(local.features, 'feature')}`],
    ['Batch', String(sequence)], ['Time', timingText(timing)]);
  return rows;
}

const swatch = (name, text) => element('span', { class: name }, text);

// `report` is null when it is not asked for, or not there yet.
export function showReport(container, report) {
  if (!report) {
    show(container);
    return;
  }
  if (report.state !== 'done') {
    show(container, element('p', { class: 'hint' }, `Simulating robots all over the map: ${words.percent(report.progress)}`));
    return;
  }
  show(container, element('p', {}, report.summary),
    element('div', { class: 'legend' }, swatch('way-none', 'at once'), swatch('way-short', 'within 3 m'),
      swatch('way-long', 'within 8 m'), swatch('way-hard', '8 m and more')),
    element('ul', { class: 'advice' }, ...report.advice.map((sentence) => element('li', {}, sentence))));
}

// `session` is the list's entry, `answer` its last answer or null before the first.
export function showSession(container, session, answer) {
  if (!session) {
    show(container, element('p', { class: 'hint' }, 'Choose a robot to watch it find itself.'));
    return;
  }
  const parts = [element('h3', {}, session.robot, ' ', badge(answer?.status ?? 'collecting'))];
  if (!answer) parts.push(element('p', {}, 'Waiting for its first scans.'));
  if (answer?.reason) parts.push(element('p', { class: 'reason' }, words.reasonText(answer.reason)));
  if (answer) parts.push(pairs(answerRows(answer)));
  if (answer && !answer.pose && answer.hypotheses.length) parts.push(hypothesesTable(answer.hypotheses));
  show(container, ...parts);
}
