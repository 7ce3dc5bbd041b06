// A pose's surroundings as the robot sees them, forward is up: the map cut out and turned, with the
// scan on it. So two candidate poses can be compared side by side.
import { color, paintHits } from './paint.js';

const SIDE_PX = 160;
const ROBOT_PX = 7;

// `reach_m` is from the robot to the edge. `fit` is that of fitScan() at `pose`.
export function drawPlace(canvas, grid, pose, fit, reach_m) {
  const ratio = window.devicePixelRatio || 1;
  [canvas.width, canvas.height] = [SIDE_PX * ratio, SIDE_PX * ratio];
  const scale = SIDE_PX / (2 * reach_m);  // [px/m]
  const context = canvas.getContext('2d');
  const turn = Math.PI / 2 - pose.yaw;  // Forward is up.
  const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
  const at = ({ x, y }) => {
    const [dx, dy] = [x - pose.x, y - pose.y];
    return [SIDE_PX / 2 + scale * (cos * dx - sin * dy), SIDE_PX / 2 - scale * (sin * dx + cos * dy)];
  };
  if (grid) drawGrid(context, grid, at, { cos, sin, scale, ratio });
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  paintHits(context, { at, scale }, fit.hits);
  drawRobot(context);
}

function drawGrid(context, grid, at, { cos, sin, scale, ratio }) {
  const { bitmap, scale: own } = grid.level(scale * ratio);
  const [x, y] = at({ x: grid.bounds.min_x, y: grid.bounds.max_y });
  const zoom = scale / own;
  context.setTransform(ratio * zoom * cos, -ratio * zoom * sin, ratio * zoom * sin, ratio * zoom * cos, ratio * x, ratio * y);
  context.filter = color('grid-filter');
  context.drawImage(bitmap, 0, 0);
  context.filter = 'none';
}

function drawRobot(context) {
  const middle = SIDE_PX / 2;
  context.fillStyle = color('robot');
  context.beginPath();
  context.moveTo(middle, middle - ROBOT_PX * 1.5);
  context.lineTo(middle - ROBOT_PX, middle + ROBOT_PX);
  context.lineTo(middle + ROBOT_PX, middle + ROBOT_PX);
  context.fill();
}
