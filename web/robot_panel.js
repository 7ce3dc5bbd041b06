// The chosen robot in the details: its state and why, candidate poses, facts, history.
import { element, part, setText, show } from './dom.js';
import { drawPlace } from './place_picture.js';
import { badge } from './robot_list.js';
import { TimesChart, timesText } from './times_chart.js';
import { HIT } from './scan_fit.js';
import { explain, settleText } from './why.js';
import * as words from './words.js';

const PICTURE_REACH_M = 12;
const MAX_GROW = 40;  // Of a segment of the timeline: a long one leaves room for the others.

const pairs = (rows) => element('dl', {}, ...rows.flatMap(([name, value]) => [
  element('dt', {}, name), element('dd', {}, value)]));

const share = (value) => (Number.isFinite(value) ? words.percent(value) : '–');

function candidatesTable(hypotheses, chosen) {
  const head = ['pose', 'map', 'x', 'y', 'heading', 'explained'];
  const cell = (value) => element('td', {}, value);
  const rows = hypotheses.map((each, index) => element('tr', { 'aria-current': index === chosen ? 'true' : undefined },
    element('td', {}, element('button', {
      type: 'button', class: 'candidate', 'data-action': 'choose-candidate', 'data-index': index, 'data-key': `candidate-${index}`,
      'aria-pressed': String(index === chosen), 'aria-label': `Lay the scan on pose ${index + 1}`,
    }, String(index + 1))),
    ...[each.map, each.x.toFixed(2), each.y.toFixed(2), words.degrees(each.yaw, 0), share(each.score)].map(cell)));
  return element('table', {},
    element('caption', {}, 'Candidate poses, best first. Choose one to lay the last scan on it. Explained: share of the local map.'),
    element('thead', {}, element('tr', {}, ...head.map((name) => element('th', { scope: 'col' }, name)))),
    element('tbody', {}, ...rows));
}

// The terms of the probability, in words; servers before them leave them out.
function probabilityRows({ explanation, confidence }) {
  const rows = [['Probability that the pose is correct', words.percent(confidence)]];
  if (!explanation) return rows;
  rows.push(['… that it does not fit by chance', words.percent(explanation.probability_explained)],
    ['… that no other pose is the correct one', words.percent(explanation.probability_best)]);
  return rows;
}

function answerRows(answer) {
  const rows = [];
  if (answer.pose) {
    rows.push(['Map', `${answer.pose.map}, revision ${answer.pose.revision}`], ['Pose', words.poseText(answer.pose)],
      ['Standard deviation', words.spreadText(answer.pose.covariance)]);
  }
  rows.push(...probabilityRows(answer),
    ['Local map', `${words.plural(answer.local.scans, 'scan')}, ${words.plural(answer.local.features, 'corner')}`]);
  if (answer.odometry) rows.push(['Odometry', answer.odometry.replaceAll('_', ' ')]);
  rows.push(['Answer', String(answer.sequence)], ['Time', words.milliseconds(answer.timing_ms.total)]);
  return rows;
}

function fitText({ counts }) {
  const all = counts.reduce((sum, count) => sum + count, 0);
  const parts = [[HIT.explained, 'explained', 'on walls'], [HIT.contradicted, 'contradicted', 'in free space'],
    [HIT.hidden, 'hidden', 'behind walls'], [HIT.unjudged, 'unjudged', 'not judged']];
  return parts.map(([kind, name, text]) => element('span', { class: `hit-${name}` }, `${counts[kind]} ${text}`))
    .concat(element('span', { class: 'total' }, `of ${words.plural(all, 'hit')} of the last scan`));
}

export class RobotPanel {
  #chart = new TimesChart(part('times-chart'));

  // `session` is null when no robot is chosen; `scene` is null before the first answer.
  show({ session, state, scene, chosen }) {
    part('robot-buttons').hidden = !session;
    if (!session) {
      show(part('robot-head'), element('p', { class: 'hint' }, 'Choose a robot to see where it is, and why not.'));
      for (const id of ['robot-why', 'robot-candidates', 'robot-facts']) show(part(id));
      part('robot-fit').hidden = part('robot-history').hidden = true;
      return;
    }
    const answer = scene?.answer ?? null;
    show(part('robot-head'), element('h2', { 'data-silent': state.silent }, session.robot, ' ', badge(answer?.status ?? state.status)),
      element('p', { class: 'hint' }, `Last scan ${words.agoText(state.age_s)}`));
    this.#showWhy(answer, state, scene);
    const hypotheses = answer && !answer.pose ? answer.hypotheses : [];
    show(part('robot-candidates'), hypotheses.length ? candidatesTable(hypotheses, chosen) : '');
    show(part('robot-facts'), answer ? pairs(answerRows(answer)) : '');
    this.#showFit(scene, chosen);
  }

  #showWhy(answer, state, scene) {
    const { why, todo } = explain(answer, state);
    const settle = scene && !scene.isAccepted && !state.silent ? scene.settle() : undefined;
    const advice = settle ? settleText(settle.place, settle.place && words.directionText(settle.place.bearing)) : todo;
    show(part('robot-why'), element('p', { class: 'why' }, why), advice && element('p', { class: 'todo' }, advice));
  }

  // The scan on the best pose, and beside it on the chosen one.
  #showFit(scene, chosen) {
    const shown = scene ? [0, ...(chosen ? [chosen] : [])].filter((index) => scene.fit(index)) : [];
    part('robot-fit').hidden = !shown.length;
    if (!shown.length) return;
    const figures = shown.map((index) => element('div', {}, element('canvas', { role: 'img',
      'aria-label': `The last scan on the map at pose ${index + 1}, forward is up` }),
    element('p', {}, scene.isAccepted ? 'At the pose' : `At pose ${index + 1}${index ? '' : ', the best'}`),
    element('p', { class: 'legend hits' }, ...fitText(scene.fit(index)))));
    part('fit-pictures').replaceChildren(...figures);
    shown.forEach((index, i) => drawPlace(figures[i].querySelector('canvas'), scene.grid(index), scene.candidates[index],
      scene.fit(index), PICTURE_REACH_M));
    setText(part('fit-caption'), `The last scan on the map, ${PICTURE_REACH_M} m around the robot; forward is up.`);
  }

  // `step` is the entry that is looked at, or null for the last.
  showHistory(history, step) {
    const { entries } = history;
    part('robot-history').hidden = entries.length < 2;
    if (entries.length < 2) return;
    this.#showTimeline(history, step);
    const slider = part('history-step');
    slider.max = String(entries.length - 1);
    slider.value = String(step ?? entries.length - 1);
    const entry = entries[step ?? entries.length - 1];
    slider.setAttribute('aria-valuetext', `answer ${entry.sequence}, ${words.statusText(entry.status)}`);
    show(part('history-entry'), step === null ? '' : this.#entry(entry));
    this.#chart.show(entries);
    setText(part('times-text'), timesText(entries));
  }

  #showTimeline(history, step) {
    const { entries } = history;
    show(part('timeline'), ...history.segments().map(({ status, reason, first, last }) => {
      const count = last - first + 1;
      const text = `${words.statusText(status)}${reason ? `, ${reason.replaceAll('_', ' ')}` : ''}, ${words.plural(count, 'answer')}`;
      const button = element('button', {
        type: 'button', 'data-action': 'step-to', 'data-index': last, 'data-status': status,
        'data-key': `step-${entries[first].sequence}`, 'aria-label': text, title: text,
        'aria-current': step !== null && step >= first && step <= last ? 'true' : undefined,
      });
      button.style.flexGrow = Math.min(MAX_GROW, count);
      return button;
    }));
  }

  #entry({ sequence, status, reason, pose, confidence, received }) {
    const rows = [['Answer', `${sequence}, at ${words.timeText(new Date(received))}`], ['Status', words.statusText(status)]];
    if (reason) rows.push(['Reason', reason.replaceAll('_', ' ')]);
    if (pose) rows.push(['Pose', words.poseText(pose)]);
    rows.push(['Probability', words.percent(confidence)]);
    return element('div', {}, pairs(rows), element('p', { class: 'buttons' },
      element('button', { type: 'button', id: 'step-live', 'data-action': 'step-live' }, 'Back to the last answer')));
  }
}
