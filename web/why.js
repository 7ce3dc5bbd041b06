// Why a robot is in its state, in one sentence, and what to do about it.
import { durationText, metres, percent, plural } from './words.js';

export const SILENT_S = 60;

// A session's state as people see it: {status, silent, age_s}. `now` is the server's time [ms].
export function stateOf(session, now) {
  const age_s = Math.max(0, (now - Date.parse(session.last_seen)) / 1000);
  const answer = session.last_answer;
  return {
    // After a reset the last answer is one of before.
    status: answer ? (session.status === 'collecting' ? 'collecting' : answer.status) : 'waiting',
    silent: session.stale || age_s > SILENT_S,
    age_s,
  };
}

// Robots that need somebody come first.
const URGENCY = { lost: 0, ambiguous: 1, collecting: 2, waiting: 3, localized: 4 };
export const urgencyOf = ({ status, silent }) => (silent && status === 'localized' ? 3.5 : URGENCY[status] ?? 2);

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
  few_features: (answer) => ({
    why: `${plural(answer.local.scans, 'scan')} showed ${plural(answer.local.features, 'corner')}: too few to search for the pose.`,
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

// {why, todo} of a robot; `answer` is null before its first scan.
export function explain(answer, state) {
  if (!answer) return { why: 'The session is open, but no scan has come.', todo: 'Check that the robot posts its scans.' };
  const found = explainAnswer(answer);
  if (!state.silent) return found;
  const before = answer.pose ? 'It was localized then; where it is now is not known.' : found.why;
  return {
    why: `No scan has come for ${durationText(state.age_s)}. ${before}`,
    todo: 'Check the robot and its network; delete the session when the robot is gone.',
  };
}

// What would settle which candidate is correct; `place` is that of whereTheyDiffer().
export function settleText(place, direction) {
  if (!place) return 'Within 25 m the map looks the same from both poses: driving further helps only beyond that.';
  return `Drive about ${metres(place.distance_m, 0)} ${direction}: there the map differs between poses 1 and 2.`;
}
