// The documented HTTP API, as far as the inspector needs it. Nothing else here talks to the server.

// An answer of the server that is an error, with its problem document (RFC 9457) when there is one.
export class ApiError extends Error {
  constructor(status, problem) {
    super(problem?.detail || problem?.title || `the server answered ${status}`);
    this.status = status;
  }
}

async function get(path) {
  const response = await fetch(path, { headers: { Accept: 'application/json' } });
  if (!response.ok) {
    throw new ApiError(response.status, await response.json().catch(() => null));
  }
  return response;
}

const mapPath = (name) => `v1/maps/${encodeURIComponent(name)}`;
const sessionPath = (id) => `v1/sessions/${encodeURIComponent(id)}`;

export async function listMaps() {
  const maps = [];
  let token = '';
  do {
    const query = token ? `&page_token=${encodeURIComponent(token)}` : '';
    const page = await (await get(`v1/maps?limit=100${query}`)).json();
    maps.push(...page.maps);
    token = page.next_page_token;
  } while (token);
  return maps;
}

export async function listSessions() {
  return (await (await get('v1/sessions')).json()).sessions;
}

export async function mapFeatures(name) {
  return (await (await get(`${mapPath(name)}/features`)).json()).features;
}

// The grid as a png, its cell size and where its lower left corner lies [m].
export async function mapGrid(name) {
  const [image, yaml] = await Promise.all([get(`${mapPath(name)}/grid.png`), get(`${mapPath(name)}/grid.yaml`)]);
  return { image: await image.blob(), ...parseGridYaml(await yaml.text()) };
}

// map_server's yaml is flat: `key: value` lines, the origin as [x, y, yaw].
function parseGridYaml(text) {
  const value = (key) => text.match(new RegExp(`^${key}:\\s*(.+)$`, 'm'))?.[1] ?? '';
  const origin = value('origin').replace(/[[\]]/g, '').split(',').map(Number);
  return { resolution: Number(value('resolution')), origin: { x: origin[0], y: origin[1] } };
}

// Follows a session by Server-Sent Events until the returned function is called. The browser connects
// again by itself after a lost connection; `onState` hears 'live', 'retrying' and 'closed' (refused).
export function watchSession(id, { onAnswer, onState }) {
  const source = new EventSource(`${sessionPath(id)}/events`);
  source.addEventListener('open', () => onState('live'));
  source.addEventListener('answer', (event) => onAnswer(JSON.parse(event.data)));
  source.addEventListener('error', () => {
    onState(source.readyState === EventSource.CLOSED ? 'closed' : 'retrying');
  });
  return () => source.close();
}
