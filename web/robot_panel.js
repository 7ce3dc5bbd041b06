// The chosen robot in the details: its state and why, candidate poses and facts.
import { showCandidates } from './candidates.js';
import { element, part, show } from './dom.js';
import { badge } from './robot_list.js';
import { explain, settleText, termsOf } from './why.js';
import * as words from './words.js';

const pairs = (rows) => element('dl', {}, ...rows.flatMap(([name, value]) => [
  element('dt', {}, name), element('dd', {}, value)]));

// The terms of the probability, in words.
function probabilityRows(answer) {
  const terms = termsOf(answer);
  if (!terms) return answer.pose ? [['Probability that the pose is correct', words.percent(answer.confidence)]] : [];
  return [['Probability that the pose is correct', words.percent(answer.confidence)],
    ['… that it does not fit by chance', words.percent(terms.probability_explained)],
    ['… that no other pose is the correct one', words.percent(terms.probability_best)],
    ['Hits of the local map on walls', words.percent(terms.explained_share)]];
}

function answerRows(answer) {
  const rows = [];
  if (answer.pose) {
    rows.push(['Map', `${answer.pose.map}, revision ${answer.pose.revision}`], ['Pose', words.poseText(answer.pose)]);
    if (answer.pose.covariance) rows.push(['Standard deviation', words.spreadText(answer.pose.covariance)]);
  }
  rows.push(...probabilityRows(answer));
  const { local, odometry, sequence, timing_ms: timing } = answer;
  if (local) rows.push(['Local map', `${words.plural(local.scans, 'scan')}, ${words.plural(local.features, 'corner')}`]);
  if (odometry) rows.push(['Odometry', odometry.replaceAll('_', ' ')]);
  rows.push(['Answer', String(sequence)], ['Time', words.milliseconds(timing.total)]);
  return rows;
}

function showWhy(answer, state, scene, chosen) {
  const { why, todo, silence = '' } = explain(answer, state);
  const settle = scene && !scene.isAccepted && answer.status !== 'lost' && !state.silent ? scene.settle(chosen) : undefined;
  const advice = settle ? settleText(settle) : todo;
  show(part('robot-why'), element('p', { class: 'why' }, `${silence} ${why}`.trim()), advice && element('p', { class: 'todo' }, advice));
}

function showNone() {
  show(part('robot-head'), element('p', { class: 'hint' }, 'Choose a robot to see where it is, and why not.'));
  for (const id of ['robot-why', 'robot-candidates', 'robot-facts']) show(part(id));
  part('robot-fit').hidden = part('robot-history').hidden = true;
}

// `session` is null when no robot is chosen; `scene` is null before the first answer. `time` says when
// the answer came.
export function showRobot({ session, state, scene, chosen, time }) {
  part('robot-buttons').hidden = !session?.id;
  if (!session) {
    showNone();
    return;
  }
  const answer = scene?.answer ?? null;
  show(part('robot-head'), element('h2', { 'data-silent': state.silent }, session.robot, ' ', badge(answer?.status ?? state.status)),
    element('p', { class: 'hint' }, time));
  showWhy(answer, state, scene, chosen);
  showCandidates(scene, chosen);
  show(part('robot-facts'), answer ? pairs(answerRows(answer)) : '');
}
