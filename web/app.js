// The page: what is chosen (kept in the address, so that it can be sent to others), what the server
// knows, and who draws it.
import * as actions from './actions.js';
import { addressOf, readAddress } from './address.js';
import * as api from './api_client.js';
import { part, setText } from './dom.js';
import { GridCache } from './grid_cache.js';
import { HistoryPanel } from './history_panel.js';
import { MapList } from './map_list.js';
import { showComparison, showMap, showReport } from './map_panel.js';
import { MapRevisions } from './map_revisions.js';
import { MapScreen } from './map_screen.js';
import { Playback, answerOf } from './playback.js';
import { readRecording } from './recording.js';
import { RobotList } from './robot_list.js';
import { showRobot } from './robot_panel.js';
import { Scene } from './scene.js';
import { setUpUploads } from './upload_dialog.js';
import { agoText, durationText, plural, timeText } from './words.js';
import { Trial } from './trial.js';
import { stateOf } from './why.js';

const REFRESH_MS = 2000;
const MANY_MAPS = 100;
const MANY_MAPS_REFRESH_MS = 10000;
const ADDRESS_MS = 300;  // Browsers limit how often the address may change.

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
  #revisions = new MapRevisions();
  #historyPanel = new HistoryPanel();
  #maps = [];
  #maps_read_ms = 0;
  #sessions = [];
  #chosen = { map: null, session: null, answer: null, tab: 'robots', compare: null, view: null };
  #scene = null;
  #past = null;  // The scene of an answer that is looked at again, with its entry.
  #playback = new Playback({ stepped: () => this.#stepped() });
  #recording = null;  // What readRecording() gave, while it is shown.
  #addressTimer = null;
  #candidate = 0;
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
    part('recording-file').addEventListener('change', (event) => this.#openFile(event.target));
    part('compare-with').addEventListener('change', ({ target }) => this.goTo({ compare: target.value || null }));
    part('token-form').addEventListener('submit', (event) => this.#signIn(event));
    for (const tab of ['robots', 'maps']) {
      part(`tab-${tab}`).addEventListener('click', () => this.goTo({ tab }));
      part(`tab-${tab}`).addEventListener('keydown', (event) => this.#otherTab(event, tab));
    }
    setUpUploads({ maps: () => this.#maps, done: (map) => this.#mapAdded(map), open: (file) => this.openRecording(file) });
    this.#choose();
    const again = async () => {
      await this.refresh();
      setTimeout(again, REFRESH_MS);
    };
    again();
  }

  get session() {
    return this.#recording?.session ?? this.#sessions.find(({ id }) => id === this.#chosen.session) ?? null;
  }

  get map() {
    return this.#maps.find(({ name }) => name === this.#chosen.map) ?? null;
  }

  get mapNames() {
    return this.#maps.map(({ name }) => name);
  }

  goTo(chosen) {
    history.replaceState(null, '', addressOf({ ...this.#chosen, ...chosen }));
    this.#choose();
  }

  chooseCandidate(index) {
    this.#candidate = index;
    const map = this.#shownScene()?.candidates[index]?.map;
    if (map && map !== this.#chosen.map) this.goTo({ map, view: null });
    this.#render();
  }

  get history() {
    return this.#playback.history;
  }

  stepTo(index) {
    this.#playback.pause();
    this.#playback.stepTo(index);
  }

  playOrPause() {
    if (this.#playback.isPlaying) this.stepTo(this.#playback.index);
    else this.#playback.play();
  }

  // A recording from a file takes the place of the chosen robot.
  async openRecording(file) {
    try {
      const { robot, lidar, maps, answers } = await readRecording(file);
      this.goTo({ session: null, answer: null, tab: 'robots', view: null });
      this.#watch(null);
      const last = answers.at(-1);
      this.#recording = { name: file.name, session: { id: null, robot, lidar, maps, last_seen: last.received, last_answer: answerOf(last) } };
      this.history.load(answers);
      this.#notice('recording', '');
      this.stepTo(0);
    } catch (error) {
      this.#notice('recording', error.message);
    }
  }

  closeRecording() {
    this.#watch(this.#chosen.session);
    this.#render();
  }

  async #openFile(field) {
    const [file] = field.files;
    if (file) await this.openRecording(file);
    field.value = '';
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
    if (!this.#recording && answer && answer.sequence > (this.#scene?.answer.sequence ?? -1)) this.#take(answer);
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
    if (!this.#chosen.session && !this.#recording && this.#sessions.length === 1) this.goTo({ session: this.#sessions[0].id });
    if (this.#chosen.map || !this.#maps.length) return;
    this.goTo({ map: this.session?.last_answer?.pose?.map ?? this.session?.map ?? this.#maps[0].name });
  }

  // What the address asks for.
  #choose() {
    const asked = readAddress(location.hash);
    const isOther = asked.session !== this.#chosen.session || Boolean(this.#recording && asked.session);
    const isOtherAnswer = asked.answer !== null && asked.answer !== this.#playback.entry?.sequence;
    this.#chosen = asked;
    if (asked.view) this.#screen.stopFollowing();
    if (isOther) this.#watch(asked.session);
    else if (isOtherAnswer) this.#playback.want(asked.answer);
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
    [this.#scene, this.#past, this.#recording] = [null, null, null];
    this.#playback.begin(this.#chosen.answer);
    this.#candidate = 0;
    this.#notice('watch', '');
    if (id) this.#follow(id);
  }

  #follow(id) {
    this.#stopWatching();
    const { history } = this;
    api.sessionHistory(id).then((answers) => history.load(answers)).catch(() => {}).finally(() => this.#historyLoaded());
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
    this.#scene = this.#sceneOf(answer, this.history.entries.length);
    this.history.add(answer, api.serverNow());
    const session = this.session;
    if (session) [session.last_answer, session.status] = [answer, answer.status];
    if (isMoved && !this.#playback.entry && this.#screen.isFollowing && answer.pose.map !== this.#chosen.map) this.goTo({ map: answer.pose.map });
    return true;
  }

  // `index` is that of the answer in the history.
  #sceneOf(answer, index) {
    return new Scene(answer, { mount: this.session?.lidar?.mount, before: this.history.poseBefore(index), grids: this.#grids });
  }

  // Of the answer that is looked at, or null before the first one.
  #shownScene() {
    const { entry, index } = this.#playback;
    if (entry && this.#past?.entry !== entry) this.#past = { entry, scene: this.#sceneOf(answerOf(entry), index) };
    const scene = entry ? this.#past.scene : this.#scene;
    if (this.#candidate >= (scene?.candidates.length ?? 0)) this.#candidate = 0;
    return scene;
  }

  // What they show depends on the grids and on the history.
  #remakeScenes() {
    if (this.#scene) this.#scene = this.#sceneOf(this.#scene.answer, this.history.entries.length);
    this.#past = null;
  }

  #gridLoaded() {
    this.#notice('map', '');
    this.#remakeScenes();
    this.#render();
  }

  #historyLoaded() {
    this.#remakeScenes();
    this.#playback.arrived();
    this.#render();
  }

  #stepped() {
    const map = this.#shownScene()?.candidates[0]?.map;
    if (map && map !== this.#chosen.map && this.#screen.isFollowing) this.goTo({ map });
    this.#render();
    clearTimeout(this.#addressTimer);
    this.#addressTimer = setTimeout(() => this.goTo({ answer: this.#playback.entry?.sequence ?? null }), ADDRESS_MS);
  }

  async #watchTrial(session) {
    await this.refresh();
    this.goTo({ session, view: null });
  }

  async #mapAdded(name) {
    await this.reload();
    this.goTo({ map: name, tab: 'maps', view: null });
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
    this.#revisions.show(map, now);
    this.#screen.showMap(map, this.#chosen.view);
    const grid = map ? this.#grids.get(map.name) : null;
    this.#screen.setGrid(grid);
    const compared = this.#maps.find(({ name }) => name === this.#chosen.compare && name !== map?.name);
    const differences = this.#screen.compareWith(compared ? this.#grids.get(compared.name) : null);
    showComparison(this.#maps, map?.name, compared?.name, differences);
  }

  #renderRobot(now) {
    const { session } = this;
    const { entry, index } = this.#playback;
    const state = session && (entry ? { status: entry.status, silent: false, replaced: false } : stateOf(session, now));
    const scene = this.#shownScene();
    const past = entry ? `Answer ${entry.sequence} of ${timeText(new Date(entry.received))}.` : '';
    showRobot({ session, state, scene, chosen: this.#candidate, time: past || (session && `Last scan ${agoText(state.age_s)}`) });
    this.#historyPanel.show(this.#playback, Boolean(this.#recording));
    this.#showRecording();
    this.#screen.showRobot({
      session: session?.id ?? null, scene, path: this.history.pathOn(this.#chosen.map, index), chosen: this.#candidate, past,
      silent: Boolean(state?.silent), truth: this.#truth && this.#truth.session === session?.id ? this.#truth : null,
    });
  }

  #showRecording() {
    part('recording-bar').hidden = !this.#recording;
    if (!this.#recording) return;
    const { name, session } = this.#recording;
    const unknown = (session.last_answer.pose ?? session.last_answer.hypotheses[0])?.map;
    const isMissing = unknown && !this.#maps.some((map) => map.name === unknown);
    setText(part('recording-name'), `Recording ${name}: ${plural(this.history.entries.length, 'answer')} of ${session.robot}.`
      + `${isMissing ? ` The server has no map ${unknown}.` : ''}`);
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
