// The revisions of the shown map that the server keeps: when and how each was made, and the way back.
import * as api from './api_client.js';
import { element, part, show } from './dom.js';
import { agoText, plural } from './words.js';

const ORIGINS = {
  settings: 'other settings', scans: 'scans', trajectory: 'a trajectory', occupancy_map: 'an occupancy map',
  archive: 'an archive', roll_back: 'a roll-back',
};

const button = (action, revision, text) => element('button', {
  type: 'button', class: 'link', 'data-action': action, 'data-revision': revision, 'data-key': `${action}-${revision}`,
}, text);

function revisionItem({ revision, created, origin, features, current }, now) {
  const age = created ? `, ${agoText((now - Date.parse(created)) / 1000)}` : '';
  const facts = `Revision ${revision}${age}: by ${ORIGINS[origin] ?? 'an older server'}, ${plural(features, 'corner')}. `;
  if (current) return element('li', {}, facts, element('strong', {}, 'In use.'));
  return element('li', {}, facts, button('roll-back', revision, 'Roll back…'), ' ',
    button('compare-revision', revision, 'Compare…'), ' ', button('download-revision', revision, 'Download'));
}

export class MapRevisions {
  #key = null;  // Of the map that was asked for: its name and revision.
  #list = [];

  show(map, now) {
    const key = map && `${map.name} ${map.revision}`;
    if (key !== this.#key) this.#load(map?.name, key);
    part('revisions-panel').hidden = this.#list.length < 2;
    show(part('revisions'), ...this.#list.map((revision) => revisionItem(revision, now)));
  }

  async #load(name, key) {
    this.#key = key;
    this.#list = [];
    if (!key) return;
    try {
      const list = await api.mapRevisions(name);
      if (this.#key === key) this.#list = list;
    } catch {
      if (this.#key === key) this.#key = null;  // The next look asks again.
    }
  }
}
