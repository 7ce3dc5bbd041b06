// "Try it here": a simulated robot is switched on at a clicked pose and drives until the server has
// localized it. It is a robot like any other: its session is in the list.
import { createSession, postScans } from './api_client.js';
import { part, setText } from './dom.js';
import { distance } from './geometry.js';
import { LIDARS, SimulatedRobot, canStandAt, geometryOf } from './simulated_robot.js';
import { degrees, metres } from './words.js';

const BATCH = 5;
const LIMIT_M = 20;
const MAX_BATCHES = 120;

export class Trial {
  #page;
  #place = null;
  #waiting = false;
  #running = 0;  // Counts runs, so that an older one stops.

  // `page` has grid(), map(), watch(session) and setTruth(pose).
  constructor(page) {
    this.#page = page;
  }

  ask() {
    [this.#waiting, this.#place] = [true, null];
    this.#say('Click on the map where the robot is switched on.');
  }

  // Takes a click while it waits for one.
  take(point) {
    if (!this.#waiting) return false;
    if (!this.#place) {
      if (!canStandAt(this.#page.grid(), point)) {
        this.#say('A robot cannot stand there. Click in free space, 0.3 m from walls.');
        return true;
      }
      this.#place = point;
      this.#say('Click where the robot looks.');
      return true;
    }
    this.#waiting = false;
    const yaw = Math.atan2(point.y - this.#place.y, point.x - this.#place.x);
    this.#run({ ...this.#place, yaw }).catch((error) => this.#say(`The trial ended: ${error.message}`));
    return true;
  }

  stop() {
    this.#waiting = false;
    ++this.#running;
    this.#say('');
  }

  async #run(start) {
    const run = ++this.#running;
    const lidar = geometryOf(LIDARS[part('trial-lidar').value]);
    const robot = new SimulatedRobot(this.#page.grid(), start, lidar);
    const session = await createSession({ robot: 'trial', map: this.#page.map().name, lidar });
    await this.#page.watch(session.id);
    this.#say('The robot is switched on.');
    for (let sequence = 0; sequence < MAX_BATCHES && run === this.#running; ++sequence) {
      const scans = Array.from({ length: BATCH }, () => robot.next());
      const answer = await postScans(session.id, { sequence, scans });
      this.#page.setTruth(robot.truth);
      if (this.#report(answer, robot)) return;
    }
  }

  // Returns whether the trial is over.
  #report({ status, pose }, robot) {
    const driven = metres(robot.distance_m, 1);
    if (status === 'localized') {
      const turn = pose.yaw - robot.truth.yaw;
      const off = Math.abs(Math.atan2(Math.sin(turn), Math.cos(turn)));
      this.#say(`Localized after ${driven}; the pose is ${metres(distance(pose, robot.truth))} and ${degrees(off)} off the true one.`);
      return true;
    }
    const isOver = robot.distance_m >= LIMIT_M;
    this.#say(isOver ? `Not localized after ${driven}.` : `Driven ${driven}, not localized yet.`);
    return isOver;
  }

  #say(text) {
    setText(part('trial-state'), text);
  }
}
