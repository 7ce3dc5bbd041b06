// The map in the middle: the chosen map with its corners and report, and the chosen robot in it.
import { cornerDescriptor, mapCorners, mapReport } from './api_client.js';
import { aliasesOf } from './corner_aliases.js';
import { cornerPopup } from './corner_popup.js';
import { part, setText } from './dom.js';
import { distance, nearest } from './geometry.js';
import { compareGrids } from './map_compare.js';
import { MapView } from './map_view.js';
import * as paint from './paint.js';
import { metres } from './words.js';

const DENSE_CORNERS = 1500;  // Above, they are shown only when they are asked for.
const REPORT_MS = 1000;
const REACH_PX = 12;  // Of the pointer.

const options = part('view-options').elements;

export class MapScreen {
  #on;
  #view;
  #redraw;
  #entry = null;
  #grid = null;
  #corners = [];
  #report = null;
  #differences = null;
  #compared = [];  // The two grids that the differences are of.
  #robot = { session: null, scene: null, path: [], chosen: 0, hovered: null, past: '', silent: false };
  #corner = { hovered: null, chosen: null };
  #measure = [];

  // `on` has moved(view), candidate(index or null), chooseCandidate(index), report(report),
  // notice(topic, text) and place(point), which may take a click.
  constructor(on) {
    this.#on = on;
    this.#view = new MapView(part('map'), {
      move: (view, byHand) => this.#moved(view, byHand),
      pointer: (point) => this.#pointTo(point),
      click: (point) => this.#click(point),
    });
    this.#redraw = {
      report: this.#view.addLayer('report', (context, view) => this.#report && paint.paintReport(context, view, this.#report)),
      differences: this.#view.addLayer('differences', (context, view) => this.#differences
        && paint.paintDifferences(context, view, this.#differences, this.#grid.resolution)),
      corners: this.#view.addLayer('corners', (context, view) => this.#paintCorners(context, view)),
      live: this.#view.addLayer('live', (context, view) => this.#paintLive(context, view)),
    };
    part('view-options').addEventListener('change', (event) => this.#changed(event.target.name));
    part('view-options').addEventListener('submit', (event) => event.preventDefault());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.#view.redrawAll());
  }

  get shownMap() {
    return this.#entry?.name ?? null;
  }

  // Another map, or another revision of it; `entry` is null for none. `view` is where to look first.
  showMap(entry, view) {
    const isOther = entry?.name !== this.#entry?.name;
    const isNewer = isOther || entry?.revision !== this.#entry?.revision;
    this.#entry = entry;
    if (!isNewer) return;
    if (isOther) {
      this.#corner = { hovered: null, chosen: null };
      this.#measure = [];
      this.#wantedView = view;
      options.corners.checked = Boolean(entry) && entry.features <= DENSE_CORNERS;
      this.setGrid(null);
    }
    this.#loadCorners();
    this.#loadReport();
  }

  // The grid of the shown map, or null while it is not loaded.
  setGrid(grid) {
    if (grid === this.#grid) return;
    const isFirst = !this.#grid;
    this.#grid = grid;
    this.#view.setGrid(grid, () => isFirst && this.#lookFirst(grid));
  }

  // Where the address says, else at the robot, else at the whole map.
  #lookFirst(grid) {
    if (this.#wantedView) this.#view.setView(this.#wantedView);
    else this.#view.fit(grid.bounds);
    if (!this.#wantedView && options.follow.checked) this.#lookAtRobot();
    this.#wantedView = null;
  }

  // `robot` is {session, scene, path, chosen, past, silent, truth}; `past` names an answer of the past
  // that is looked at, `truth` is the pose of a simulated robot.
  showRobot(robot) {
    const before = this.#robot;
    this.#robot = { hovered: before.hovered, ...robot };
    this.#redraw.live();
    this.#caption();
    if (!options.follow.checked || !this.#grid) return;
    const isOther = before.session !== robot.session || before.scene?.answer.status !== robot.scene?.answer.status;
    const pose = robot.scene?.answer.pose;
    if (pose?.map === this.shownMap && before.scene?.answer.pose && before.session === robot.session) this.#view.follow(pose);
    else if (isOther) this.#lookAtRobot();
  }

  // At its pose, or at all poses that may be the robot's.
  #lookAtRobot() {
    const { scene } = this.#robot;
    const places = [...scene?.candidates ?? [], scene?.before].filter((pose) => pose?.map === this.shownMap);
    if (scene?.isAccepted && places.length) this.#view.focus(places[0]);
    else if (places.length) this.#view.fitPlaces(places);
  }

  // Another map to compare the shown one with: its Grid, or null for none. Returns what differs, or null.
  compareWith(other) {
    const pair = this.#grid && other ? [this.#grid, other] : [];
    if (pair.length !== this.#compared.length || pair.some((grid, i) => grid !== this.#compared[i])) {
      this.#compared = pair;
      this.#differences = pair.length ? compareGrids(...pair) : null;
      this.#redraw.differences();
    }
    return this.#differences;
  }

  hover(index) {
    this.#robot.hovered = index;
    this.#redraw.live();
  }

  lookAt(point) {
    this.stopFollowing();
    this.#view.focus(point);
  }

  wholeMap() {
    this.stopFollowing();
    if (this.#grid) this.#view.fit(this.#grid.bounds);
  }

  stopFollowing() {
    options.follow.checked = false;
  }

  get isFollowing() {
    return options.follow.checked;
  }

  #wantedView = null;

  #moved(view, byHand) {
    if (byHand) options.follow.checked = false;
    this.#on.moved(view);
  }

  #changed(name) {
    if (name === 'corners') this.#loadCorners();
    if (name === 'report') this.#loadReport();
    if (name === 'measure') this.#measure = [];
    if (name === 'follow') this.showRobot(this.#robot);
    this.#redraw.live();
    this.#caption();
  }

  #caption() {
    const { scene, past, chosen } = this.#robot;
    let text = '';
    if (options.measure.checked) text = this.#measureText();
    else if (scene && !scene.isAccepted) text = this.#candidatesText(scene, chosen);
    setText(part('map-caption'), [options.measure.checked ? '' : past, text].filter(Boolean).join(' '));
  }

  #candidatesText({ answer, candidates, before }, chosen) {
    if (!answer.local) return '';  // A past answer whose candidate poses were not kept.
    const grey = before?.map === this.shownMap ? ' Grey: the last known pose.' : '';
    const isHere = candidates.some(({ map }) => map === this.shownMap);
    if (isHere && candidates.length === 1) return `Dashed: the best pose so far, with the scan on it.${grey}`;
    if (isHere) return `Dashed: poses that may be the robot's. The scan lies on pose ${chosen + 1}.${grey}`;
    return candidates.length ? `The poses that may be the robot's are on the map ${candidates[0].map}.` : `No pose is known.${grey}`;
  }

  #measureText() {
    const [from, to] = this.#measure;
    if (!from) return 'Click the first point.';
    if (!to) return 'Click the second point.';
    const yaw = (Math.atan2(to.y - from.y, to.x - from.x) * 180) / Math.PI;
    return `${metres(distance(from, to))}, direction ${yaw.toFixed(1)}°. Click for another line.`;
  }

  async #loadCorners() {
    const wanted = this.#entry;
    try {
      const corners = wanted?.bounds && options.corners.checked ? await mapCorners(wanted.name) : [];
      if (this.#entry !== wanted && this.#entry?.name !== wanted?.name) return;
      this.#corners = options.corners.checked ? corners : [];
      this.#on.notice('corners', '');
    } catch (error) {
      this.#on.notice('corners', `The corners of ${wanted.name} could not be loaded: ${error.message}`);
    }
    this.#redraw.corners();
    this.#redraw.live();
  }

  // Asks again until the report is made, unless another map is shown by then.
  async #loadReport() {
    const wanted = this.#entry;
    const isWanted = () => this.#entry?.name === wanted?.name && this.#entry?.revision === wanted?.revision
      && options.report.checked;
    this.#showReport(null);
    this.#on.notice('report', '');
    try {
      while (wanted?.bounds && isWanted()) {
        const report = await mapReport(wanted.name);
        if (!isWanted()) return;
        this.#showReport(report);
        if (report.state === 'done') return;
        await new Promise((resume) => setTimeout(resume, REPORT_MS));
      }
    } catch (error) {
      this.#on.notice('report', `There is no report of ${wanted.name}: ${error.message}`);
    }
  }

  #showReport(report) {
    this.#report = report?.state === 'done' ? report : null;
    this.#redraw.report();
    this.#on.report(report);
  }

  #nearest(places, point, reach_px = REACH_PX) {
    return nearest(places, point, reach_px / this.#view.scale);
  }

  #candidateAt(point) {
    const { scene } = this.#robot;
    if (!scene || scene.isAccepted) return null;
    const here = scene.candidates.filter(({ map }) => map === this.shownMap);
    const found = this.#nearest(here, point, 2 * REACH_PX);
    return found ? scene.candidates.indexOf(found) : null;
  }

  #pointTo(point) {
    const corner = point ? this.#nearest(this.#corners, point) : null;
    if (corner !== this.#corner.hovered) this.#redraw.corners();
    this.#corner.hovered = corner;
    const isPlace = point && this.#entry?.bounds;
    setText(part('pointer'), isPlace ? `x ${point.x.toFixed(2)}, y ${point.y.toFixed(2)} m${this.#hint(point)}` : '');
    const candidate = point ? this.#candidateAt(point) : null;
    if (candidate !== this.#robot.hovered) this.#on.candidate(candidate);
  }

  #hint(point) {
    const place = this.#report && nearest(this.#report.places, point, 0.5 * this.#report.lattice_m);
    if (place) return ` · a robot drives ${metres(place.way_m, 1)} here until it is localized`;
    return this.#corner.hovered ? ` · corner ${this.#corner.hovered.id}` : '';
  }

  #click(point) {
    if (this.#on.place(point)) return;
    if (options.measure.checked) {
      this.#measure = this.#measure.length === 1 ? [...this.#measure, point] : [point];
      this.#redraw.live();
      this.#caption();
      return;
    }
    const candidate = this.#candidateAt(point);
    if (candidate !== null) {
      this.#on.chooseCandidate(candidate);
      return;
    }
    const corner = this.#nearest(this.#corners, point);
    this.#corner.chosen = corner;
    this.#redraw.corners();
    if (corner) this.#openPopup(corner);
  }

  #openPopup(corner) {
    const descriptor = cornerDescriptor(this.#entry.name, corner.id);
    this.#view.openPopup(corner, cornerPopup(corner, descriptor, aliasesOf(this.#corners, corner)));
  }

  #paintCorners(context, view) {
    if (this.#entry?.bounds) paint.paintAxes(context, view);
    paint.paintCorners(context, view, this.#corners, this.#corner.chosen ?? this.#corner.hovered);
  }

  #paintLive(context, view) {
    const { scene, path, silent, truth } = this.#robot;
    paint.paintPath(context, view, path);
    if (truth) paint.paintTruth(context, view, truth);
    if (scene?.isAccepted) this.#paintAccepted(context, view, scene, silent);
    else if (scene) this.#paintCandidates(context, view, scene);
    if (this.#measure.length) paint.paintMeasure(context, view, this.#measure[0], this.#measure[1] ?? null);
  }

  #paintAccepted(context, view, scene, silent) {
    const { pose, feature_points: corners = [] } = scene.answer;
    if (pose.map !== this.shownMap) return;
    paint.paintHits(context, view, scene.fit(0)?.hits ?? []);
    this.#paintLocalCorners(context, view, pose, corners);
    paint.paintEllipse(context, view, pose);
    paint.paintRobot(context, view, pose, { accepted: true, faded: silent });
  }

  #paintLocalCorners(context, view, pose, points) {
    paint.paintLocalCorners(context, view, pose, points);
    paint.paintMatches(context, view, pose, points, this.#corners);
  }

  #paintCandidates(context, view, scene) {
    const shown = this.#robot.hovered ?? this.#robot.chosen;
    const isHere = (index) => scene.candidates[index]?.map === this.shownMap;
    if (isHere(shown)) {
      paint.paintHits(context, view, scene.fit(shown)?.hits ?? []);
      this.#paintLocalCorners(context, view, scene.candidates[shown], scene.answer.feature_points ?? []);
    }
    if (scene.before?.map === this.shownMap) paint.paintRobot(context, view, scene.before, { accepted: true, faded: true });
    scene.candidates.forEach((pose, index) => isHere(index) && paint.paintRobot(context, view, pose, {
      accepted: false, label: String(index + 1), strong: index === shown,
    }));
    const settle = isHere(0) && scene.answer.status !== 'lost' ? scene.settle(shown) : undefined;
    if (settle?.target) paint.paintTarget(context, view, scene.candidates[0], settle.target);
  }
}
