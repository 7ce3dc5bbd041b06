// Why a robot is in its state, in one sentence, and what to do about it.
import { directionText, durationText, metres, percent, plural } from './words.js';

export const SILENT_S = 60;

// A session's state as people see it: {status, silent, replaced, age_s}. It is replaced when its robot
// has a newer session. `now` is the server's time [ms].
export function stateOf(session, now) {
  const age_s = Math.max(0, (now - Date.parse(session.last_seen)) / 1000);
  const answer = session.last_answer;
  return {
    // After a reset the last answer is one of before.
    status: answer ? (session.status === 'collecting' ? 'collecting' : answer.status) : 'waiting',
    silent: session.stale || age_s > SILENT_S,
    replaced: Boolean(session.superseded_by),
    age_s,
  };
}

// The terms that make up `confidence`, or null when they do not belong to it: a robot that is lost
// has those of before, and poses that are equally good are not judged.
export function termsOf({ explanation, confidence }) {
  if (!explanation?.probability_explained) return null;
  const { probability_explained: explained, probability_best: best } = explanation;
  return Math.abs(explained * best - confidence) < 0.02 ? explanation : null;
}

// Robots that need somebody come first.
const URGENCY = { lost: 0, ambiguous: 1, collecting: 2, waiting: 3, localized: 4 };
export function urgencyOf({ status, silent, replaced }) {
  if (replaced) return 5;
  return silent && status === 'localized' ? 3.5 : URGENCY[status] ?? 2;
}

const chance = (answer) => `correct with a probability of ${percent(answer.confidence)}`;

function candidates(answer) {
  const count = answer.hypotheses.length;
  if (count > 1 && answer.confidence < 0.5) {
    return `${plural(count, 'pose')} explain the scans about equally well, so none of them is used.`;
  }
  return count === 1 ? `One pose is left; it is ${chance(answer)}, too little to use it.`
    : `${plural(count, 'pose')} may be the robot's; the best is ${chance(answer)}, too little to use it.`;
}

const REASONS = {
  no_returns: () => ({
    why: 'The last scan has no usable return, so nothing can be compared with the map.',
    todo: 'Check the lidar, its range_min and range_max, and that nothing covers it.',
  }),
  few_features: ({ local }) => ({
    why: local ? `${plural(local.scans, 'scan')} showed ${plural(local.features, 'corner')}: too few to search for the pose.`
      : 'Too few corners were seen to search for the pose.',
    todo: 'Drive on, towards walls, doors or furniture.',
  }),
  searching: () => ({
    why: 'The search of the maps takes longer than one scan and continues at the next.',
    todo: 'Send more scans, also while the robot stands.',
  }),
  no_motion: (answer) => ({
    why: answer.hypotheses.length ? candidates(answer) : 'The scans so far fit no single pose.',
    todo: 'The robot stands still, which shows nothing new: drive on.',
  }),
  no_match: () => ({
    why: 'No pose in the map explains the scans.',
    todo: 'Check that this is the map of the building and floor, and that the lidar’s mount and angles are right.',
  }),
  few_evidence: (answer) => ({
    why: answer.hypotheses.length ? candidates(answer) : 'Too little of the building was seen so far.',
    todo: 'Drive on: each new wall rules out wrong poses.',
  }),
  contradicted: () => ({
    why: 'Even at the best pose, hits lie where the map is free.',
    todo: 'The robot may be outside the map, or the building has changed. Drive on, or map the building again.',
  }),
  odometry_contradicts_scans: () => ({
    why: 'The odometry contradicts the scans, and the best pose contradicts the map.',
    todo: 'Check the odometry: its frame, its unit, and that its stamps are those of the scans.',
  }),
  prior_contradicted: () => ({
    why: 'No pose near the place that was given explains the scans.',
    todo: 'Check the given place, or reset the session without one.',
  }),
  mirrored_scans: () => ({
    why: 'The scans fit the map only when they are mirrored.',
    todo: 'The lidar is mounted upside down: set roll in its mount, or the sign of angle_increment.',
  }),
};

function explainSearch(answer) {
  if (!answer.local && answer.status === 'ambiguous') return { why: 'More than one pose explained the scans.', todo: '' };
  const known = REASONS[answer.reason];
  if (known) return known(answer);
  if (answer.hypotheses.length) return { why: candidates(answer), todo: 'Drive on: each new wall rules out wrong poses.' };
  return { why: 'No pose is known yet.', todo: 'Drive on.' };
}

function explainLocalized(answer) {
  if (answer.pose.confirmed) return { why: 'The pose may be used, and new ground has confirmed it.', todo: '' };
  return {
    why: 'The pose may be used; new ground has not confirmed it yet.',
    todo: 'It counts as confirmed after 3 m of new ground that agree.',
  };
}

function explainAnswer(answer) {
  if (answer.pose) return explainLocalized(answer);
  const search = explainSearch(answer);
  if (answer.status !== 'lost') return search;
  return { ...search, why: `The scans no longer fit the pose that was known. ${search.why}` };
}

// {why, todo} of a robot, and `silence` when it sends no scans; `answer` is null before its first scan.
export function explain(answer, state) {
  if (!answer) return { why: 'The session is open, but no scan has come.', todo: 'Check that the robot posts its scans.' };
  const found = explainAnswer(answer);
  if (state.replaced) return { why: 'The robot has a newer session.', todo: 'Look at that one, and delete this one.' };
  if (!state.silent) return found;
  const before = answer.pose ? 'It was localized then; where it is now is not known.' : found.why;
  return {
    why: before,
    silence: `No scan has come for ${durationText(state.age_s)}.`,
    todo: 'Check the robot and its network; delete the session when the robot is gone.',
  };
}

// What would settle which candidate is correct, of Scene.settle().
export function settleText({ place, other }) {
  const both = `poses 1 and ${other + 1}`;
  if (!place) return `Within 25 m the map looks the same from ${both}. Drive further, or open the session near a known place.`;
  return `Drive about ${metres(place.distance_m, 0)} ${directionText(place.bearing)}${place.hidden ? ', around the wall' : ''}: there the map differs between ${both}.`;
}
