// Draws marks on a canvas. `view` has at({x, y}) in pixels and scale [px/m]; colours come from the
// style sheet, so that dark and light both work.
import { HIT, HIT_NAMES } from './scan_fit.js';
import { covarianceEllipse, nearest, transform } from './geometry.js';

const SIGMAS = 3;
const MIN_ELLIPSE_PX = 4;
// The robot as an arrow that points where it looks [m].
const ROBOT_OUTLINE = [[0.45, 0], [-0.3, 0.28], [-0.15, 0], [-0.3, -0.28]];
const MIN_ROBOT_SCALE = 26;  // [px/m]: the arrow stays visible in a view of the whole building.
const MAX_PAIRS = 8;
const MATCH_M = 0.5;  // Between a corner of the local map and the map's.
const CLOSE_SCALE = 24;  // [px/m]
const FAR_SCALE = 12;    // [px/m]: below, rings would hide the walls.
const MAX_RINGS = 3000;
const WAY_COLORS = [[0.5, 'way-none'], [3, 'way-short'], [8, 'way-long'], [Infinity, 'way-hard']];  // Up to metres.

export const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

function trace(context, points) {
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
}

export function paintPath(context, view, pieces) {
  context.strokeStyle = color('path');
  context.lineWidth = 2.5;
  context.lineJoin = 'round';
  for (const piece of pieces) {
    trace(context, piece.map(view.at));
    context.stroke();
  }
}

// Hits as fitScan() made them; what contradicts the map is drawn last and larger.
export function paintHits(context, view, hits) {
  const size = Math.min(5, Math.max(2.5, view.scale * 0.08));
  for (const kind of [HIT.unjudged, HIT.hidden, HIT.explained, HIT.contradicted]) {
    context.fillStyle = color(`hit-${HIT_NAMES[kind]}`);
    const wide = kind === HIT.contradicted ? size + 1.5 : size;
    for (const hit of hits) {
      if (hit.kind !== kind) continue;
      const [x, y] = view.at(hit);
      context.fillRect(x - wide / 2, y - wide / 2, wide, wide);
    }
  }
}

// An arrow of the robot's size, but never too small to see. What is not accepted is dashed.
export function paintRobot(context, view, pose, { accepted, label, strong = true, faded = false }) {
  const grow = Math.max(1, MIN_ROBOT_SCALE / view.scale);
  const outline = ROBOT_OUTLINE.map(([x, y]) => view.at(transform(pose, [x * grow, y * grow])));
  const shade = color(accepted ? (faded ? 'silent' : 'robot') : 'candidate');
  context.save();
  context.globalAlpha = strong ? 1 : 0.75;
  context.setLineDash(accepted ? [] : [4, 3]);
  context.lineWidth = strong ? 2.5 : 1.5;
  context.strokeStyle = shade;
  context.fillStyle = shade;
  trace(context, outline);
  context.closePath();
  context.stroke();
  context.globalAlpha = accepted ? 0.9 : 0.3;
  context.fill();
  context.restore();
  if (label) paintLabel(context, view.at(pose), label, shade, strong);
}

function paintLabel(context, [x, y], text, shade, strong) {
  const radius = strong ? 11 : 9;
  context.fillStyle = shade;
  context.beginPath();
  context.arc(x, y - 22, radius, 0, 2 * Math.PI);
  context.fill();
  context.fillStyle = color('card');
  context.font = '600 13px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText(text, x, y - 21.5);
}

export function paintEllipse(context, view, pose) {
  if (!pose.covariance) return;  // A past answer has none.
  const { major, minor, yaw } = covarianceEllipse(pose.covariance, SIGMAS);
  const [x, y] = view.at(pose);
  const [a, b] = [major, minor].map((half) => Math.max(MIN_ELLIPSE_PX, half * view.scale));
  context.strokeStyle = color('robot');
  context.lineWidth = 1.5;
  context.beginPath();
  context.ellipse(x, y, a, b, -yaw, 0, 2 * Math.PI);
  context.stroke();
}

// The true pose of a simulated robot: a cross with a line to where it looks.
export function paintTruth(context, view, pose) {
  const size = 9 / view.scale;
  const arm = (bearing) => view.at(transform({ ...pose, yaw: pose.yaw + bearing }, [size, 0]));
  context.strokeStyle = color('ink');
  context.lineWidth = 1.5;
  for (const bearing of [Math.PI / 4, -Math.PI / 4]) {
    trace(context, [arm(bearing), arm(bearing + Math.PI)]);
    context.stroke();
  }
  trace(context, [view.at(pose), view.at(transform(pose, [2.5 * size, 0]))]);
  context.stroke();
}

// Where the robot should drive to settle which candidate is correct: a line and a ring.
export function paintTarget(context, view, from, to) {
  context.save();
  context.strokeStyle = color('accent');
  context.lineWidth = 2;
  context.setLineDash([2, 5]);
  trace(context, [view.at(from), view.at(to)]);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  context.arc(...view.at(to), 9, 0, 2 * Math.PI);
  context.stroke();
  context.restore();
}

// Corners of the robot's local map.
export function paintLocalCorners(context, view, pose, points) {
  context.strokeStyle = color('local-corner');
  context.lineWidth = 2;
  for (const point of points) {
    context.beginPath();
    context.arc(...view.at(transform(pose, point)), 5, 0, 2 * Math.PI);
    context.stroke();
  }
}

const inView = ({ min_x, max_x, min_y, max_y }) => ({ x, y }) => x >= min_x && x <= max_x && y >= min_y && y <= max_y;

// Rings with the direction of each, in one path: too slow for many thousands.
function paintRings(context, view, corners, radius) {
  const length = view.scale > CLOSE_SCALE ? 2.2 * radius : 0;
  context.lineWidth = 1.2;
  context.beginPath();
  for (const corner of corners) {
    const [x, y] = view.at(corner);
    context.moveTo(x + radius, y);
    context.arc(x, y, radius, 0, 2 * Math.PI);
    if (!length) continue;
    context.moveTo(x, y);
    context.lineTo(x + length * Math.cos(corner.bisector), y - length * Math.sin(corner.bisector));
  }
  context.stroke();
}

function paintDots(context, view, corners, side) {
  for (const corner of corners) {
    const [x, y] = view.at(corner);
    context.fillRect(x - side / 2, y - side / 2, side, side);
  }
}

// Corners of the map: rings, or dots where there are many in view.
export function paintCorners(context, view, corners, chosen) {
  const radius = Math.min(6, Math.max(1.2, view.scale * 0.12));
  const shown = corners.filter(inView(view.bounds));
  context.strokeStyle = context.fillStyle = color('corner');
  if (shown.length > MAX_RINGS || view.scale < FAR_SCALE) paintDots(context, view, shown, Math.min(2, radius));
  else paintRings(context, view, shown, radius);
  if (!chosen) return;
  context.lineWidth = 3;
  context.beginPath();
  context.arc(...view.at(chosen), radius + 4, 0, 2 * Math.PI);
  context.stroke();
}

// Corners of the robot's local map, each joined to the map's corner that it lies on.
export function paintMatches(context, view, pose, points, corners) {
  context.strokeStyle = color('local-corner');
  context.lineWidth = 3;
  for (const point of points) {
    const at = transform(pose, point);
    const match = nearest(corners, at, MATCH_M);
    if (!match) continue;
    trace(context, [view.at(at), view.at(match)]);
    context.stroke();
  }
}

// Walls of compareGrids().
export function paintDifferences(context, view, { came, went }, resolution) {
  const side = Math.max(3, resolution * view.scale);
  const isShown = inView(view.bounds);
  for (const [name, points] of [['came', came], ['went', went]]) {
    context.fillStyle = color(name);
    for (const point of points) {
      if (!isShown(point)) continue;
      const [x, y] = view.at(point);
      context.fillRect(x - side / 2, y - side / 2, side, side);
    }
  }
}

// Places of the localizability report in colours by the metres that robots drive, and pairs of
// places that look alike.
export function paintReport(context, view, report) {
  context.save();
  context.strokeStyle = color('candidate');
  context.setLineDash([6, 6]);
  context.lineWidth = 1.5;
  for (const { a, b } of report.look_alikes.slice(0, MAX_PAIRS)) {
    trace(context, [view.at(a), view.at(b)]);
    context.stroke();
  }
  context.setLineDash([]);
  context.globalAlpha = 0.7;
  const radius = Math.min(0.8, 0.35 * report.lattice_m) * view.scale;
  for (const place of report.places) {
    context.fillStyle = color(WAY_COLORS.find(([limit]) => place.way_m < limit)[1]);
    context.beginPath();
    context.arc(...view.at(place), radius, 0, 2 * Math.PI);
    context.fill();
  }
  context.restore();
}

// The map's origin with its axes, one metre long or more.
export function paintAxes(context, view) {
  const length = Math.max(1, 30 / view.scale);
  const origin = { x: 0, y: 0 };
  context.lineWidth = 2;
  context.font = '12px system-ui, sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  for (const [name, tip] of [['x', { x: length, y: 0 }], ['y', { x: 0, y: length }]]) {
    context.strokeStyle = color(`axis-${name}`);
    context.fillStyle = context.strokeStyle;
    trace(context, [view.at(origin), view.at(tip)]);
    context.stroke();
    const [x, y] = view.at({ x: tip.x * 1.25, y: tip.y * 1.25 });
    context.fillText(name, x, y);
  }
}

// A measured line; `to` is null while only its first end is chosen.
export function paintMeasure(context, view, from, to) {
  context.strokeStyle = color('accent');
  context.fillStyle = color('accent');
  context.lineWidth = 2;
  for (const end of [from, to]) {
    if (!end) continue;
    context.beginPath();
    context.arc(...view.at(end), 4, 0, 2 * Math.PI);
    context.fill();
  }
  if (!to) return;
  trace(context, [view.at(from), view.at(to)]);
  context.stroke();
}
