// The inspector: what is chosen (kept in the address, so it can be sent to others), and what is drawn of it.
import * as api from './api_client.js';
import { MapView } from './map_view.js';
import { linkTo, showMaps, showReport, showSession, showSessions } from './panels.js';
import { uprightGrid } from './upright_grid.js';

const REFRESH_MS = 2000;
const REPORT_MS = 1000;
const MAX_PATH_POINTS = 5000;
const LOCAL_POSE = { x: 0, y: 0, yaw: Math.PI / 2 };  // Forward is up.

const part = (id) => document.getElementById(id);
const options = part('view-options').elements;

class Inspector {
  #mapView = new MapView(part('map'));
  #localView = null;
  #maps = [];
  #sessions = [];
  #chosen = { map: null, session: null };
  #drawn = { map: null, revision: null };
  #answer = null;
  #path = [];  // Pieces of way driven while localized, each an array of places.
  #stopWatching = () => {};
  #notices = new Map();

  start() {
    window.addEventListener('hashchange', () => this.#choose());
    document.addEventListener('visibilitychange', () => this.#refresh());
    part('view-options').addEventListener('change', () => this.#redrawAll());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.#redrawAll());
    part('token-form').addEventListener('submit', (event) => {
      event.preventDefault();
      api.useToken(event.target.elements.token.value);
      this.#watch(this.#chosen.session);
      this.#refresh();
    });
    this.#choose();
    const again = async () => {
      await this.#refresh();
      setTimeout(again, REFRESH_MS);
    };
    again();
  }

  // What the address asks for.
  #choose() {
    const asked = new URLSearchParams(location.hash.slice(1));
    const session = asked.get('session');
    const changed = session !== this.#chosen.session;
    this.#chosen = { map: asked.get('map'), session };
    if (changed) this.#watch(session);
    this.#render();
    this.#drawMap();
  }

  #goTo(chosen) {
    history.replaceState(null, '', linkTo({ ...this.#chosen, ...chosen }));
    this.#choose();
  }

  #watch(id) {
    this.#stopWatching();
    this.#stopWatching = () => {};
    this.#answer = null;
    this.#path = [];
    this.#notice('watch', '');
    this.#mapView.clearLive();
    part('local-figure').hidden = true;
    if (!id) return;
    this.#stopWatching = api.watchSession(id, {
      onAnswer: (answer) => this.#take(answer),
      onState: (state) => this.#notice('watch', {
        live: '', retrying: 'The connection was lost; trying again.',
        closed: 'This robot cannot be watched: its session is gone, or too many watch already.',
      }[state]),
    });
  }

  async #refresh() {
    if (document.hidden) return;
    try {
      [this.#maps, this.#sessions] = await Promise.all([api.listMaps(), api.listSessions()]);
      this.#notice('server', '');
      part('token-form').hidden = true;
    } catch (error) {
      part('token-form').hidden = ![401, 403].includes(error.status);
      this.#notice('server', error instanceof api.ApiError ? `The server refuses: ${error.message}`
        : 'The server does not answer.');
      return;
    }
    // With one robot there is nothing to choose.
    if (!this.#chosen.session && this.#sessions.length === 1) this.#goTo({ session: this.#sessions[0].id });
    const session = this.#session();
    if (!this.#answer && session?.last_answer) this.#take(session.last_answer);
    if (!this.#chosen.map && this.#maps.length) this.#goTo({ map: session?.map ?? this.#maps[0].name });
    this.#render();
    this.#drawMap();
  }

  #session() {
    return this.#sessions.find(({ id }) => id === this.#chosen.session);
  }

  // A live answer carries points; the last answer of a robot that is silent does not.
  #take(answer) {
    const before = this.#answer;
    this.#answer = answer;
    const session = this.#session();
    if (session) session.last_answer = answer;
    if (answer.pose) this.#growPath(before, answer.pose);
    const moved = answer.pose && options.follow.checked && answer.pose.map !== this.#chosen.map;
    if (moved) this.#goTo({ map: answer.pose.map });
    this.#render();
    this.#drawAnswer();
    if (!answer.pose || !options.follow.checked) return;
    if (before?.pose) this.#mapView.follow(answer.pose);
    else this.#mapView.focus(answer.pose);
  }

  #growPath(before, pose) {
    if (before?.pose?.map !== pose.map) this.#path.push({ map: pose.map, places: [] });
    const piece = this.#path.at(-1);
    piece.places.push({ x: pose.x, y: pose.y });
    if (piece.places.length > MAX_PATH_POINTS) piece.places.shift();
  }

  #render() {
    showMaps(part('maps'), this.#maps, this.#chosen);
    showSessions(part('sessions'), this.#sessions, this.#chosen);
    showSession(part('session'), this.#session(), this.#answer);
    part('map-caption').textContent = this.#caption();
  }

  #caption() {
    if (!this.#answer || this.#answer.pose) return '';
    const guess = this.#answer.hypotheses.some(({ map }) => map === this.#chosen.map);
    return guess ? 'Dashed: the best guess so far, not confirmed.' : 'No place is known yet.';
  }

  // Grid and features of the chosen map, when they are not drawn already.
  async #drawMap() {
    const entry = this.#maps.find(({ name }) => name === this.#chosen.map);
    const wanted = { map: entry?.name ?? null, revision: entry?.revision ?? null };
    if (wanted.map === this.#drawn.map && wanted.revision === this.#drawn.revision) return;
    const sameMap = wanted.map === this.#drawn.map;
    this.#drawn = wanted;
    this.#notice('map', this.#maps.length && this.#chosen.map && !entry ? `There is no map ${this.#chosen.map}.` : '');
    try {
      const grid = entry?.bounds ? await this.#loadGrid(entry.name) : null;
      if (this.#drawn !== wanted) return;
      this.#mapView.setGrid(grid, { moveView: !sameMap });
      this.#drawReport();
      await this.#drawFeatures();
    } catch (error) {
      this.#notice('map', `The map ${wanted.map} cannot be shown: ${error.message}`);
    }
    this.#drawAnswer();
  }

  async #loadGrid(name) {
    const grid = await api.mapGrid(name);
    const bitmap = await createImageBitmap(grid.image);
    const { width, height } = bitmap;
    bitmap.close();
    return grid.origin.yaw === 0 ? { ...grid, width, height } : uprightGrid(grid);
  }

  async #drawFeatures() {
    const wanted = this.#drawn;
    const features = wanted.map && options.features.checked ? await api.mapFeatures(wanted.map) : [];
    if (this.#drawn === wanted) this.#mapView.setFeatures(features);
  }

  // Asks again until the report is made, unless another map is drawn by then.
  async #drawReport() {
    const wanted = this.#drawn;
    const isWanted = () => this.#drawn === wanted && options.report.checked;
    this.#showReport(null);
    this.#notice('report', '');
    try {
      while (wanted.map && isWanted()) {
        const report = await api.mapReport(wanted.map);
        if (!isWanted()) return;
        this.#showReport(report);
        if (report.state === 'done') return;
        await new Promise((resume) => setTimeout(resume, REPORT_MS));
      }
    } catch (error) {
      this.#notice('report', `There is no report of ${wanted.map}: ${error.message}`);
    }
  }

  #showReport(report) {
    part('report-panel').hidden = !report;
    showReport(part('report'), report);
    this.#mapView.setReport(report?.state === 'done' ? report : null);
  }

  #drawAnswer() {
    this.#mapView.clearLive();
    if (!this.#answer) return;
    const { pose, hypotheses, scan_points: scanPoints = [], feature_points: featurePoints = [] } = this.#answer;
    const here = ({ map }) => map === this.#chosen.map;
    this.#mapView.drawPath(this.#path.filter(here).map(({ places }) => places));
    if (!pose) this.#mapView.drawHypotheses(hypotheses.filter(here));
    const best = pose ?? hypotheses[0];
    if (best && here(best)) {
      this.#mapView.drawRobot(best, { scanPoints, featurePoints, confirmed: Boolean(pose) });
    }
    this.#drawLocal(scanPoints, featurePoints);
  }

  #drawLocal(scanPoints, featurePoints) {
    part('local-figure').hidden = !scanPoints.length;
    if (!scanPoints.length) return;
    this.#localView ??= new MapView(part('local-map'), { interactive: false });
    this.#localView.clearLive();
    this.#localView.fitAround(LOCAL_POSE, scanPoints);
    this.#localView.drawRobot(LOCAL_POSE, { scanPoints, featurePoints, confirmed: Boolean(this.#answer.pose) });
  }

  #redrawAll() {
    this.#drawReport();
    this.#drawFeatures().catch((error) => this.#notice('map', error.message));
    this.#drawAnswer();
  }

  // One notice a topic; an empty text takes it away.
  #notice(topic, text) {
    this.#notices.set(topic, text);
    const all = [...this.#notices.values()].filter(Boolean).join(' ');
    if (part('notice').textContent !== all) part('notice').textContent = all;
  }
}

if (window.L) {
  new Inspector().start();
} else {
  part('notice').textContent = 'Leaflet is missing on the server (Debian package libjs-leaflet), so there is no map.';
}
