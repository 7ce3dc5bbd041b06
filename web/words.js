// Units and names in plain words. The only place with degrees.

const STATUS = {
  waiting: 'No scan yet',
  collecting: 'Searching',
  ambiguous: 'Ambiguous',
  localized: 'Localized',
  lost: 'Lost',
};

export const statusText = (status) => STATUS[status] ?? status;
export const plural = (count, noun) => `${count.toLocaleString('en')} ${noun}${count === 1 ? '' : 's'}`;

export const metres = (value, digits = 2) => `${value.toFixed(digits)} m`;
export const degrees = (radians, digits = 1) => `${((radians * 180) / Math.PI).toFixed(digits)}°`;
export const milliseconds = (value) => `${value.toFixed(value < 10 ? 1 : 0)} ms`;
export const poseText = ({ x, y, yaw }) => `x ${metres(x)}, y ${metres(y)}, heading ${degrees(yaw)}`;

// Close to 0 and to 1 the digits that matter are kept.
export function percent(share) {
  const digits = share > 0.99 && share < 1 ? 1 : 0;
  if (share < 0.01) return 'below 1 %';
  return `${(Math.floor(share * 100 * 10 ** digits) / 10 ** digits).toFixed(digits)} %`;
}

// Standard deviations out of a row-major covariance of x, y, yaw.
export function spreadText(covariance) {
  const position = Math.sqrt(Math.max(0, covariance[0] + covariance[4]));
  const heading = Math.sqrt(Math.max(0, covariance[8]));
  return `± ${position.toFixed(3)} m, ± ${degrees(heading, 2)}`;
}

export function sizeText({ min_x, min_y, max_x, max_y }) {
  return `${(max_x - min_x).toFixed(0)} × ${(max_y - min_y).toFixed(0)} m`;
}

export function bytesText(bytes) {
  if (bytes < 1e6) return `${Math.max(1, Math.round(bytes / 1e3))} kB`;
  return `${(bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0)} MB`;
}

const SPANS = [[86400 * 2, 86400, 'days'], [3600 * 2, 3600, 'h'], [120, 60, 'min'], [0, 1, 's']];

export function durationText(seconds) {
  const [, unit, name] = SPANS.find(([from]) => seconds >= from) ?? SPANS.at(-1);
  return `${Math.max(0, Math.floor(seconds / unit))} ${name}`;
}

export const agoText = (seconds) => (seconds < 3 ? 'now' : `${durationText(seconds)} ago`);

// A direction as seen by the robot, from its bearing [rad], left positive.
export function directionText(bearing) {
  const side = bearing > 0 ? 'left' : 'right';
  const turn = Math.abs(bearing);
  if (turn < Math.PI / 8) return 'ahead';
  if (turn < (3 * Math.PI) / 8) return `ahead and to the ${side}`;
  if (turn < (5 * Math.PI) / 8) return `to the ${side}`;
  return turn < (7 * Math.PI) / 8 ? `back and to the ${side}` : 'back';
}

export const timeText = (date) => date.toLocaleTimeString('en-GB');
