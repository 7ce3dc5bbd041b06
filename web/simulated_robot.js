// A robot with a lidar that drives by itself in a map's grid, to try the map without one. Its noise
// comes from a seed: the same start gives the same run.
import { CELL } from './grid.js';

const RANGE_SIGMA_M = 0.01;
const ODOM_SIGMA = 0.01;  // Of the distance, and of the turn.
const STEP_M = 0.1;
const STEP_S = 0.2;
const TURN_RAD = 0.25;
const CLEAR_M = 0.7;
const RADIUS_M = 0.3;

export const LIDARS = {
  half: { beams: 181, fov: Math.PI, range_max: 30 },
  wide: { beams: 541, fov: 1.5 * Math.PI, range_max: 30 },
  full: { beams: 360, fov: 2 * Math.PI, range_max: 12 },
};

export function geometryOf({ beams, fov, range_max }) {
  const angle_increment = fov >= 2 * Math.PI ? fov / beams : fov / (beams - 1);
  return { angle_min: -fov / 2, angle_increment, range_min: 0.05, range_max, beams };
}

// mulberry32: small, seeded, good enough for noise.
function randomFrom(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

export const canStandAt = (grid, point) => grid.cellAt(point) === CELL.free && !grid.isWallNear(point, RADIUS_M);

export class SimulatedRobot {
  #grid;
  #random;
  #stamp = 0;
  #odom = { x: 0, y: 0, yaw: 0 };

  constructor(grid, start, lidar, seed = 1) {
    [this.#grid, this.pose, this.lidar, this.#random] = [grid, { ...start }, lidar, randomFrom(seed)];
    this.distance_m = 0;
  }

  // The next scan with its odometry, as the server takes it; then the robot drives on.
  next() {
    const { angle_min, angle_increment, range_min, range_max, beams } = this.lidar;
    const ranges = Array.from({ length: beams }, (_, beam) => {
      const length = this.#clear(angle_min + beam * angle_increment, range_max);
      const range = length === null ? null : length + RANGE_SIGMA_M * this.#gauss();
      return range !== null && range >= range_min && range < range_max ? Number(range.toFixed(4)) : null;
    });
    const scan = { stamp: this.#stamp, ranges, odom: { ...this.#odom } };
    this.truth = { ...this.pose };
    this.#stamp = Number((this.#stamp + STEP_S).toFixed(3));
    this.#drive();
    return scan;
  }

  #clear(bearing, reach_m) {
    return this.#grid.rayLength(this.pose, this.pose.yaw + bearing, reach_m);
  }

  // Straight on while there is room, with a bend towards the wider side; otherwise a turn on the spot.
  #drive() {
    const room = (bearing) => this.#clear(bearing, 6) ?? 6;
    const ahead = Math.min(...[-0.5, -0.25, 0, 0.25, 0.5].map(room));
    const side = room(0.8) > room(-0.8) ? 1 : -1;
    if (ahead < CLEAR_M) this.#move(0, TURN_RAD * (this.#turning ||= side));
    else {
      this.#turning = 0;
      this.#move(STEP_M, 0.06 * side);
    }
  }

  #turning = 0;  // The side to which it turns until the way is clear.

  #move(forward, turn) {
    const measured_m = forward * (1 + ODOM_SIGMA * this.#gauss());
    const measured_rad = turn * (1 + ODOM_SIGMA * this.#gauss());
    this.pose = moved(this.pose, forward, turn);
    this.#odom = moved(this.#odom, measured_m, measured_rad);
    this.distance_m += forward;
  }

  // Sum of uniform numbers: close enough to a normal distribution.
  #gauss() {
    let sum = -6;
    for (let i = 0; i < 12; ++i) sum += this.#random();
    return sum;
  }
}

function moved({ x, y, yaw }, forward, turn) {
  const heading = yaw + turn / 2;
  const next = yaw + turn;
  return {
    x: x + forward * Math.cos(heading), y: y + forward * Math.sin(heading), yaw: Math.atan2(Math.sin(next), Math.cos(next)),
  };
}
