// A session as one file: what GET /v1/sessions/{id}/history answers, with the robot's name and its
// lidars beside it, and with scans and candidate poses as far as they are known.

const STATUSES = ['collecting', 'ambiguous', 'localized', 'lost'];

// The file of a session's history.
export function recordingOf(session, entries) {
  const { id, robot, maps = null, lidar = null, lidars = null } = session;
  const answers = entries.map((entry) => ({ ...entry, received: new Date(entry.received).toISOString() }));
  return new Blob([JSON.stringify({ session: id, robot, maps, lidar, lidars, answers })], { type: 'application/json' });
}

export const recordingName = ({ robot }) => `${robot}.recording.json`;

function faultOf(recording) {
  if (!Array.isArray(recording?.answers) || !recording.answers.length) return 'it has no "answers"';
  const wrong = recording.answers.findIndex((answer) => !Number.isInteger(answer?.sequence)
    || !STATUSES.includes(answer.status) || Number.isNaN(Date.parse(answer.received)) || !answer.timing_ms);
  return wrong < 0 ? '' : `answer ${wrong + 1} of ${recording.answers.length} has no sequence, status, time or timing`;
}

// {robot, lidar, maps, answers} of a file; throws what is wrong with it.
export async function readRecording(file) {
  let recording = null;
  try {
    recording = JSON.parse(await file.text());
  } catch {
    throw new Error(`${file.name} is no JSON file.`);
  }
  const fault = faultOf(recording);
  if (fault) throw new Error(`${file.name} is no recording: ${fault}.`);
  const { robot = file.name, lidar = null, maps = null, answers } = recording;
  return { robot, lidar, maps, answers };
}
