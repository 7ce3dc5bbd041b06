// The list of robots: those that need somebody first.
import { KeyedList, bringIntoSight, element, part, setText, show } from './dom.js';
import { addressOf } from './address.js';
import { explain, stateOf, urgencyOf } from './why.js';
import { agoText, plural, statusText } from './words.js';

export const badge = (status) => element('span', { class: 'badge', 'data-status': status }, statusText(status));

const needsHelp = ({ status, silent, replaced }) => !replaced && (silent || status !== 'localized');

function matches({ session, state }, { text, wanted }) {
  const names = [session.robot, session.last_answer?.pose?.map, ...(session.maps ?? [])];
  if (text && !names.some((name) => name?.toLowerCase().includes(text))) return false;
  if (wanted === 'help') return needsHelp(state);
  if (wanted === 'silent') return state.silent && !state.replaced;
  return wanted ? state.status === wanted && !state.silent && !state.replaced : true;
}

const mapsText = (session) => session.last_answer?.pose?.map ?? session.maps?.join(', ') ?? 'any map';

function makeRow({ session, state, href, current }) {
  const { why, silence } = explain(session.last_answer, state);
  return element('li', {}, element('a', {
    href, 'data-key': session.id, 'aria-current': current ? 'true' : undefined, 'data-silent': state.silent || state.replaced,
  }, element('strong', {}, session.robot), badge(state.status),
  element('small', { class: 'age' }), element('small', { class: 'map' }, mapsText(session)),
  (needsHelp(state) || state.replaced) && element('small', { class: 'why' }, silence ? `Silent. ${why}` : why)));
}

export class RobotList {
  #form = part('robot-filter');
  #list = new KeyedList(part('robots'), {
    key: ({ session }) => session.id,
    version: (row) => JSON.stringify([row.session.robot, row.state.status, row.state.silent, row.state.replaced, row.href, row.current,
      row.session.last_answer?.reason, mapsText(row.session), row.session.last_answer?.hypotheses.length,
      needsHelp(row.state) && row.session.last_answer?.confidence.toFixed(2)]),
    make: makeRow,
  });
  #sessions = [];
  #chosen = {};
  #now = 0;
  #seen = null;  // The chosen session that was scrolled to.

  constructor() {
    this.#form.addEventListener('input', () => this.#draw());
    this.#form.addEventListener('submit', (event) => event.preventDefault());
  }

  show(sessions, chosen, now) {
    [this.#sessions, this.#chosen, this.#now] = [sessions, chosen, now];
    this.#draw();
    const row = this.#seen !== chosen.session && this.#list.node(chosen.session);
    if (!row) return;
    this.#seen = chosen.session;
    bringIntoSight(row);
  }

  // Robots by state, for the page's head.
  summary() {
    const counts = { localized: 0, help: 0, silent: 0 };
    for (const session of this.#sessions) {
      const state = stateOf(session, this.#now);
      if (!state.replaced) ++counts[state.silent ? 'silent' : state.status === 'localized' ? 'localized' : 'help'];
    }
    if (!this.#sessions.length) return 'no robot';
    const parts = [plural(counts.localized + counts.help + counts.silent, 'robot')];
    if (counts.localized) parts.push(`${counts.localized} localized`);
    if (counts.help) parts.push(`${counts.help} not localized`);
    if (counts.silent) parts.push(`${counts.silent} silent`);
    return parts.join(' · ');
  }

  #draw() {
    const filter = { text: this.#form.elements.text.value.trim().toLowerCase(), wanted: this.#form.elements.state.value };
    const rows = this.#sessions.map((session) => ({
      session,
      state: stateOf(session, this.#now),
      current: session.id === this.#chosen.session,
      href: addressOf({ map: session.last_answer?.pose?.map ?? session.map ?? this.#chosen.map, session: session.id }),
    })).filter((row) => matches(row, filter));
    rows.sort((a, b) => urgencyOf(a.state) - urgencyOf(b.state) || a.session.robot.localeCompare(b.session.robot, 'en'));
    this.#list.show(rows);
    for (const { session, state } of rows) {
      setText(this.#list.node(session.id).querySelector('.age'), agoText(state.age_s));
    }
    this.#hint(rows.length);
  }

  #hint(shown) {
    const hint = part('robots-hint');
    if (!this.#sessions.length) {
      show(hint, 'No robot has a session. A robot opens one with POST /v1/sessions. To replay a recorded run:',
        element('code', {}, 'cornerfix replay LOG --map NAME'));
    } else {
      show(hint, shown ? '' : 'No robot matches the filter.');
    }
  }
}
