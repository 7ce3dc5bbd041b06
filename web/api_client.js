// The documented HTTP API, as far as the inspector needs it. Nothing else here talks to the server.

// An answer of the server that is an error, with its problem document (RFC 9457) when there is one.
export class ApiError extends Error {
  constructor(status, problem) {
    super(problem?.detail || problem?.title || `the server answered ${status}`);
    this.status = status;
  }
}

const RETRY_MS = 2000;
let bearer = sessionStorage.getItem('token');

// For servers that ask for one; forgotten when the tab is closed.
export function useToken(token) {
  bearer = token;
  sessionStorage.setItem('token', token);
}

async function get(path, { accept = 'application/json', signal } = {}) {
  const headers = { Accept: accept };
  if (bearer) headers.Authorization = `Bearer ${bearer}`;
  const response = await fetch(path, { headers, signal });
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
  const sessions = [];
  let token = '';
  do {
    const query = token ? `&page_token=${encodeURIComponent(token)}` : '';
    const page = await (await get(`v1/sessions?limit=100${query}`)).json();
    sessions.push(...page.sessions);
    token = page.next_page_token;
  } while (token);
  return sessions;
}

export async function mapFeatures(name) {
  return (await (await get(`${mapPath(name)}/features`)).json()).features;
}

// The localizability report, or how far it is: `state` is "done" or "computing".
export async function mapReport(name) {
  return (await get(`${mapPath(name)}/report?wait=0`)).json();
}

// The grid as a png, its cell size [m], and where its lower left corner lies and how it is turned.
export async function mapGrid(name) {
  const [image, yaml] = await Promise.all([get(`${mapPath(name)}/grid.png`, { accept: 'image/png' }),
    get(`${mapPath(name)}/grid.yaml`, { accept: '*/*' })]);
  return { image: await image.blob(), ...parseGridYaml(await yaml.text()) };
}

// map_server's yaml is flat: `key: value` lines, the origin as [x, y, yaw].
function parseGridYaml(text) {
  const value = (key) => text.match(new RegExp(`^${key}:\\s*(.+)$`, 'm'))?.[1] ?? '';
  const origin = value('origin').replace(/[[\]]/g, '').split(',').map(Number);
  return { resolution: Number(value('resolution')), origin: { x: origin[0], y: origin[1], yaw: origin[2] } };
}

// Calls back with each event of a stream named "answer" (Server-Sent Events).
async function readAnswers(stream, onAnswer) {
  const reader = stream.pipeThrough(new TextDecoderStream()).getReader();
  let text = '';
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const events = (text + value).split('\n\n');
    text = events.pop();
    for (const event of events) {
      if (/^event: ?answer$/m.test(event)) onAnswer(JSON.parse(event.match(/^data: ?(.*)$/m)[1]));
    }
  }
}

// Follows a session live until the returned function is called, and connects again after a lost connection.
// `onState` hears 'live', 'retrying' and, when the server refuses, 'closed'. EventSource would do, but cannot
// carry a token.
export function watchSession(id, { onAnswer, onState }) {
  const stop = new AbortController();
  const follow = async () => {
    try {
      const response = await get(`${sessionPath(id)}/events`, { accept: 'text/event-stream', signal: stop.signal });
      onState('live');
      await readAnswers(response.body, onAnswer);
    } catch (error) {
      if (stop.signal.aborted) return;
      if (error instanceof ApiError) {
        onState('closed');
        return;
      }
    }
    onState('retrying');
    setTimeout(() => stop.signal.aborted || follow(), RETRY_MS);
  };
  follow();
  return () => stop.abort();
}
