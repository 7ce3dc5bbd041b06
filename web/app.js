// The page: what is chosen (kept in the address, so that it can be sent to others), what the server
// knows, and who draws it.
import * as actions from './actions.js';
import { addressOf, readAddress } from './address.js';
import * as api from './api_client.js';
import { part, setText } from './dom.js';
import { GridCache } from './grid_cache.js';
import { History } from './history.js';
import { MapList } from './map_list.js';
import { showMap, showReport } from './map_panel.js';
import { MapScreen } from './map_screen.js';
import { RobotList } from './robot_list.js';
import { RobotPanel } from './robot_panel.js';
import { Scene } from './scene.js';
import { setUpUploads } from './upload_dialog.js';
import { durationText } from './words.js';
import { Trial } from './trial.js';
import { stateOf } from './why.js';

const REFRESH_MS = 2000;
const MANY_MAPS = 100;
const MANY_MAPS_REFRESH_MS = 10000;

class Inspector {
  #grids = new GridCache({
    loaded: () => this.#gridLoaded(),
    failed: (name, error, retry_ms) => this.#notice('map', `The map ${name} could not be loaded (${error.message}). `
      + `Next try in ${durationText(retry_ms / 1000)}.`),
  });
  #screen = new MapScreen({
    moved: (view) => this.#viewMoved(view),
    candidate: (index) => this.#screen.hover(index),
    chooseCandidate: (index) => this.chooseCandidate(index),
    report: (report) => showReport(report),
    notice: (topic, text) => this.#notice(topic, text),
    place: (point) => this.#trial.take(point),
  });
  #trial = new Trial({
    grid: () => this.#grids.get(this.#chosen.map),
    map: () => this.map,
    watch: (session) => this.#watchTrial(session),
    setTruth: (pose) => { this.#truth = { ...pose, session: this.#chosen.session }; },
  });
  #truth = null;  // Of the simulated robot, with its session.
  #robotList = new RobotList();
  #mapList = new MapList();
  #robotPanel = new RobotPanel();
  #maps = [];
  #maps_read_ms = 0;
  #sessions = [];
  #chosen = { map: null, session: null, tab: 'robots', view: null };
  #scene = null;
  #history = new History();
  #candidate = 0;
  #step = null;  // Index into the history, or null for the last answer.
  #stopWatching = () => {};
  #notices = new Map();

  start() {
    window.addEventListener('hashchange', () => this.#choose());
    document.addEventListener('visibilitychange', () => this.#visibilityChanged());
    window.addEventListener('pagehide', () => this.#stopWatching());
    document.addEventListener('click', (event) => this.#act(event));
    for (const event of ['mouseover', 'focusin']) part('robot-candidates').addEventListener(event, (e) => this.#hoverRow(e));
    part('robot-candidates').addEventListener('mouseleave', () => this.#screen.hover(null));
    part('history-step').addEventListener('input', (event) => this.stepTo(Number(event.target.value)));
    part('token-form').addEventListener('submit', (event) => this.#signIn(event));
    for (const tab of ['robots', 'maps']) {
      part(`tab-${tab}`).addEventListener('click', () => this.goTo({ tab }));
      part(`tab-${tab}`).addEventListener('keydown', (event) => this.#otherTab(event, tab));
    }
    setUpUploads({ maps: () => this.#maps, done: (map) => this.#mapAdded(map) });
    this.#choose();
    const again = async () => {
      await this.refresh();
      setTimeout(again, REFRESH_MS);
    };
    again();
  }

  get session() {
    return this.#sessions.find(({ id }) => id === this.#chosen.session) ?? null;
  }

  get map() {
    return this.#maps.find(({ name }) => name === this.#chosen.map) ?? null;
  }

  goTo(chosen) {
    history.replaceState(null, '', addressOf({ ...this.#chosen, ...chosen }));
    this.#choose();
  }

  chooseCandidate(index) {
    this.#candidate = index;
    const map = this.#scene?.candidates[index]?.map;
    if (map && map !== this.#chosen.map) this.goTo({ map, view: null });
    this.#render();
  }

  stepTo(index) {
    this.#step = index >= this.#history.entries.length - 1 ? null : index;
    this.#render();
  }

  tryHere() {
    this.#trial.ask();
  }

  stopTrial() {
    this.#trial.stop();
  }

  wholeMap() {
    this.#screen.wholeMap();
  }

  lookAt(point) {
    this.#screen.lookAt(point);
  }

  // After a change that is known to have happened.
  async reload() {
    this.#maps_read_ms = 0;
    await this.refresh();
  }

  signOut() {
    api.useToken(null);
    location.reload();
  }

  async refresh() {
    if (document.hidden) return;
    try {
      await this.#read();
      this.#notice('server', '');
      part('token-form').hidden = true;
      part('sign-out').hidden = !api.hasToken();
    } catch (error) {
      this.#readFailed(error);
      return;
    }
    this.#chooseForThem();
    this.#render();
  }

  async #read() {
    const wait_ms = this.#maps.length > MANY_MAPS ? MANY_MAPS_REFRESH_MS : 0;
    const areMapsDue = performance.now() - this.#maps_read_ms >= wait_ms || !this.#maps_read_ms;
    const [maps, sessions] = await Promise.all([areMapsDue ? api.listMaps() : this.#maps, api.listSessions()]);
    if (areMapsDue) this.#maps_read_ms = performance.now();
    [this.#maps, this.#sessions] = [maps, sessions];
    this.#grids.know(maps);
    const answer = this.session?.last_answer;
    if (answer && answer.sequence > (this.#scene?.answer.sequence ?? -1)) this.#take(answer);
  }

  #readFailed(error) {
    const asksForToken = [401, 403].includes(error.status);
    part('token-form').hidden = !asksForToken;
    if (asksForToken) this.#notice('server', api.hasToken() ? 'The server does not accept this token.' : '');
    else if (error instanceof api.ApiError) this.#notice('server', `The server refuses: ${error.message}`);
    else this.#notice('server', 'The server does not answer. Trying again.');
  }

  #signIn(event) {
    event.preventDefault();
    api.useToken(event.target.elements.token.value);
    event.target.reset();
    this.#watch(this.#chosen.session);
    this.refresh();
  }

  // What nobody has to choose: the only robot, a robot's map, the first map.
  #chooseForThem() {
    if (!this.#chosen.session && this.#sessions.length === 1) this.goTo({ session: this.#sessions[0].id });
    if (this.#chosen.map || !this.#maps.length) return;
    this.goTo({ map: this.session?.last_answer?.pose?.map ?? this.session?.map ?? this.#maps[0].name });
  }

  // What the address asks for.
  #choose() {
    const asked = readAddress(location.hash);
    const isOther = asked.session !== this.#chosen.session;
    this.#chosen = asked;
    if (asked.view) this.#screen.stopFollowing();
    if (isOther) this.#watch(asked.session);
    this.#showTab(asked.tab);
    this.#render();
  }

  #showTab(chosen) {
    for (const tab of ['robots', 'maps']) {
      part(`tab-${tab}`).setAttribute('aria-selected', String(tab === chosen));
      part(`tab-${tab}`).tabIndex = tab === chosen ? 0 : -1;
      part(`${tab}-pane`).hidden = tab !== chosen;
    }
    part('robot-panel').hidden = chosen === 'maps';
  }

  #otherTab(event, tab) {
    if (!['ArrowLeft', 'ArrowRight'].includes(event.key)) return;
    const other = tab === 'robots' ? 'maps' : 'robots';
    this.goTo({ tab: other });
    part(`tab-${other}`).focus();
  }

  #act(event) {
    const target = event.target.closest('[data-action]');
    if (target) actions.run(target.dataset, this);
  }

  #hoverRow(event) {
    const button = event.target.closest('tr')?.querySelector('[data-index]');
    this.#screen.hover(button ? Number(button.dataset.index) : null);
  }

  // A page that nobody sees holds no live connection: browsers allow few per server, over all tabs.
  #visibilityChanged() {
    if (document.hidden) this.#stopWatching();
    else if (this.#chosen.session) this.#follow(this.#chosen.session);
    this.refresh();
  }

  #watch(id) {
    this.#stopWatching();
    this.#stopWatching = () => {};
    this.#scene = null;
    this.#history = new History();
    this.#candidate = 0;
    this.#step = null;
    this.#notice('watch', '');
    if (id) this.#follow(id);
  }

  #follow(id) {
    this.#stopWatching();
    const history = this.#history;
    api.sessionHistory(id).then((answers) => history.load(answers)).catch(() => {}).finally(() => this.#render());
    this.#stopWatching = api.watchSession(id, {
      onAnswer: (answer) => this.#take(answer) && this.#render(),
      onState: (state) => this.#notice('watch', {
        live: '', retrying: 'The live connection was lost; trying again.', closed: 'This robot’s session is gone.',
      }[state]),
    });
  }

  // A live answer has points; the list's last answer has none. Returns whether it was taken.
  #take(answer) {
    const known = this.#scene?.answer;
    const hasMore = known?.sequence === answer.sequence && answer.scan_points && !known.scan_points;
    if (known && answer.sequence <= known.sequence && !hasMore) return false;
    // The first answer does not lead away from a map that was asked for.
    const isMoved = answer.pose && (known ? answer.pose.map !== known.pose?.map : !this.#chosen.map);
    this.#scene = new Scene(answer, this.session?.lidar?.mount, this.#grids);
    this.#history.add(answer, api.serverNow());
    if (this.#candidate >= this.#scene.candidates.length) this.#candidate = 0;
    const session = this.session;
    if (session) [session.last_answer, session.status] = [answer, answer.status];
    if (isMoved && this.#screen.isFollowing && answer.pose.map !== this.#chosen.map) this.goTo({ map: answer.pose.map });
    return true;
  }

  #gridLoaded() {
    this.#notice('map', '');
    if (this.#scene) this.#scene = new Scene(this.#scene.answer, this.session?.lidar?.mount, this.#grids);
    this.#render();
  }

  async #watchTrial(session) {
    await this.refresh();
    this.goTo({ session, view: null });
  }

  async #mapAdded(name) {
    await this.reload();
    this.goTo({ map: name, tab: 'maps', view: null });
    this.#mapList.scrollToChosen();
  }

  #viewMoved(view) {
    const address = addressOf({ ...this.#chosen, view: this.#screen?.isFollowing === false ? view : null });
    if (this.#screen?.shownMap && address !== location.hash) history.replaceState(null, '', address);
  }

  #render() {
    const now = api.serverNow();
    const robots = this.#robotsByMap();
    this.#robotList.show(this.#sessions, this.#chosen, now);
    this.#mapList.show(this.#maps, robots, this.#chosen, now);
    setText(part('summary'), `${this.#robotList.summary()} · ${this.#maps.length} map${this.#maps.length === 1 ? '' : 's'}`);
    this.#renderMap(robots, now);
    this.#renderRobot(now);
  }

  #renderMap(robots, now) {
    const { map } = this;
    const isMissing = this.#maps.length && this.#chosen.map && !map;
    this.#notice('missing', isMissing ? `There is no map ${this.#chosen.map}.` : '');
    showMap(map, robots.get(map?.name) ?? 0, now);
    this.#screen.showMap(map, this.#chosen.view);
    this.#screen.setGrid(map ? this.#grids.get(map.name) : null);
  }

  #renderRobot(now) {
    const { session } = this;
    const state = session && stateOf(session, now);
    const past = this.#step === null ? null : this.#history.entries[this.#step]?.pose ?? null;
    this.#robotPanel.show({ session, state, scene: this.#scene, chosen: this.#candidate });
    this.#robotPanel.showHistory(this.#history, this.#step);
    this.#screen.showRobot({
      scene: this.#scene, path: this.#history.pathOn(this.#chosen.map), chosen: this.#candidate, past,
      silent: Boolean(state?.silent), truth: this.#truth?.session === session?.id ? this.#truth : null,
    });
  }

  #robotsByMap() {
    const robots = new Map();
    for (const session of this.#sessions) {
      for (const map of session.maps ?? []) robots.set(map, (robots.get(map) ?? 0) + 1);
    }
    return robots;
  }

  // One notice per topic; an empty text takes it away.
  #notice(topic, text) {
    this.#notices.set(topic, text);
    setText(part('notice'), [...this.#notices.values()].filter(Boolean).join(' '));
  }
}

if (window.L) new Inspector().start();
else setText(part('notice'), 'Leaflet is missing on the server (Debian package libjs-leaflet), so there is no map.');
