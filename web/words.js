// What the wire says, in a person's words and units. The only place with degrees.

const STATUS = {
  collecting: 'Looking around',
  ambiguous: 'More than one place fits',
  localized: 'Localized',
  lost: 'Lost, searching again',
};

const REASONS = {
  no_returns: 'The scans show nothing: no beam came back.',
  few_features: 'Too few corners seen so far to look for the place.',
  no_motion: 'Standing still shows nothing new: drive on.',
  no_match: 'No place in the maps fits what was seen.',
  few_evidence: 'A place fits, but too little was seen to be sure.',
  contradicted: 'The best place is contradicted by what was seen.',
  odometry_contradicts_scans: 'The scans contradict the odometry and the best place: check the odometry.',
  searching: 'The search of the maps continues with the next scan.',
};

export const statusText = (status) => STATUS[status] ?? status;
export const reasonText = (reason) => (reason ? REASONS[reason] ?? reason.replaceAll('_', ' ') : '');

export const metres = (value) => `${value.toFixed(2)} m`;
export const degrees = (radians, digits = 1) => `${((radians * 180) / Math.PI).toFixed(digits)}°`;
export const percent = (share) => `${(share * 100).toFixed(share > 0.99 && share < 1 ? 1 : 0)} %`;
export const milliseconds = (value) => `${value.toFixed(value < 10 ? 2 : 0)} ms`;
export const poseText = ({ x, y, yaw }) => `x ${metres(x)}, y ${metres(y)}, heading ${degrees(yaw)}`;

// Standard deviations out of a row-major covariance of x, y, yaw.
export function spreadText(covariance) {
  const position = Math.sqrt(Math.max(0, covariance[0] + covariance[4]));
  const heading = Math.sqrt(Math.max(0, covariance[8]));
  return `± ${position.toFixed(3)} m, ± ${degrees(heading, 2)}`;
}
