// Poses in the plane: {x, y, yaw}, metres and radians. Points of a scan are [x, y] in base_link.

export const transform = (pose, [x, y]) => ({
  x: pose.x + x * Math.cos(pose.yaw) - y * Math.sin(pose.yaw),
  y: pose.y + x * Math.sin(pose.yaw) + y * Math.cos(pose.yaw),
});

// The point in base_link, as [x, y], of a place in the frame of the pose.
export const inverseTransform = (pose, { x, y }) => {
  const [cos, sin, dx, dy] = [Math.cos(pose.yaw), Math.sin(pose.yaw), x - pose.x, y - pose.y];
  return [cos * dx + sin * dy, -sin * dx + cos * dy];
};

export const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

// The place that is nearest to a point, at most `reach_m` away, or null.
export function nearest(places, point, reach_m) {
  let best = null;
  for (const place of places) {
    const away = distance(place, point);
    if (away <= reach_m && (!best || away < best.away)) best = { place, away };
  }
  return best?.place ?? null;
}

// Half axes [m] and direction [rad] of the ellipse at `sigmas` standard deviations, out of a
// row-major covariance of x, y, yaw.
export function covarianceEllipse(covariance, sigmas) {
  const [xx, xy, , , yy] = covariance;
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major: sigmas * Math.sqrt(Math.max(0, mean + spread)),
    minor: sigmas * Math.sqrt(Math.max(0, mean - spread)),
    yaw: 0.5 * Math.atan2(2 * xy, xx - yy),
  };
}
