// The documented HTTP API, as far as the page needs it. Nothing else here talks to the server.
import { parseGridYaml } from './grid.js';

// An answer of the server that is an error, with its problem document (RFC 9457) when there is one.
export class ApiError extends Error {
  constructor(status, problem) {
    super(problem?.detail || problem?.title || `the server answered ${status}`);
    this.status = status;
    this.errors = problem?.errors ?? [];
  }
}

const RETRY_MS = 2000;
const TOKEN_KEY = 'token';
let bearer = sessionStorage.getItem(TOKEN_KEY);
let clock_offset_ms = 0;  // Of the server's clock to the browser's.

export const hasToken = () => Boolean(bearer);

// For servers that ask for one; forgotten when the tab is closed. Null forgets it at once.
export function useToken(token) {
  bearer = token;
  if (token) sessionStorage.setItem(TOKEN_KEY, token);
  else sessionStorage.removeItem(TOKEN_KEY);
}

// The server's time [ms], as far as its answers give it.
export const serverNow = () => Date.now() + clock_offset_ms;

const authorization = () => (bearer ? { Authorization: `Bearer ${bearer}` } : {});

async function call(method, path, { accept = 'application/json', body, type, signal } = {}) {
  const headers = { Accept: accept, ...authorization() };
  if (type) headers['Content-Type'] = type;
  const response = await fetch(path, { method, headers, body, signal });
  const date = Date.parse(response.headers.get('Date') ?? '');
  if (!Number.isNaN(date)) clock_offset_ms = date - Date.now();
  if (!response.ok) throw new ApiError(response.status, await response.json().catch(() => null));
  return response;
}

const get = (path, options) => call('GET', path, options);
const sendJson = (method, path, body) => call(method, path, { type: 'application/json', body: JSON.stringify(body) });

const mapPath = (name) => `v1/maps/${encodeURIComponent(name)}`;
const sessionPath = (id) => `v1/sessions/${encodeURIComponent(id)}`;

async function listAll(kind) {
  const all = [];
  let token = '';
  do {
    const query = token ? `&page_token=${encodeURIComponent(token)}` : '';
    const page = await (await get(`v1/${kind}?limit=500${query}`)).json();
    all.push(...page[kind]);
    token = page.next_page_token;
  } while (token);
  return all;
}

export const listMaps = () => listAll('maps');
export const listSessions = () => listAll('sessions');
export const session = async (id) => (await get(sessionPath(id))).json();

export const describeMap = async (name, description) => (await sendJson('PUT', mapPath(name), description)).json();
export const deleteMap = (name) => call('DELETE', mapPath(name));
export const resetSession = (id) => call('POST', `${sessionPath(id)}/reset`);
export const deleteSession = (id) => call('DELETE', sessionPath(id));
export const mapCorners = async (name) => (await (await get(`${mapPath(name)}/features`)).json()).features;
export const cornerDescriptor = async (name, id) => (await get(`${mapPath(name)}/features/${id}/descriptor`)).json();
export const addMapScans = async (name, batch) => (await sendJson('POST', `${mapPath(name)}/scans`, batch)).json();
export const createSession = async (request) => (await sendJson('POST', 'v1/sessions', request)).json();
export const postScans = async (id, batch) => (await sendJson('POST', `${sessionPath(id)}/scans`, batch)).json();

// The answers of a session so far, oldest first, without points.
export const sessionHistory = async (id) => (await (await get(`${sessionPath(id)}/history`)).json()).answers;

// The localizability report, or how far it is: `state` is "done" or "computing".
export const mapReport = async (name) => (await get(`${mapPath(name)}/report?wait=0`)).json();

// The grid as a blob with what its yaml says.
export async function mapGrid(name) {
  const [image, yaml] = await Promise.all([get(`${mapPath(name)}/grid.png`, { accept: 'image/png' }),
    get(`${mapPath(name)}/grid.yaml`, { accept: '*/*' })]);
  return { image: await image.blob(), description: parseGridYaml(await yaml.text()) };
}

export const gridImage = async (name) => (await get(`${mapPath(name)}/grid.png`, { accept: 'image/png' })).blob();
// Of the present revision, or of a kept one.
export async function mapArchive(name, revision) {
  const query = revision ? `?revision=${revision}` : '';
  return (await get(`${mapPath(name)}/archive${query}`, { accept: '*/*' })).blob();
}
// The present one, then those that are kept, newest first.
export const mapRevisions = async (name) => (await (await get(`${mapPath(name)}/revisions`)).json()).revisions;
export const rollBackMap = (name, revision) => sendJson('POST', `${mapPath(name)}/rollback`, { revision });
export const sharedFile = async (path) => (await get(path, { accept: '*/*' })).blob();

// Only XMLHttpRequest reports how much of a body is sent. `onProgress` gets a share in [0, 1].
function upload(method, path, { body, type, onProgress, signal }) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open(method, path);
    for (const [name, value] of Object.entries(authorization())) request.setRequestHeader(name, value);
    if (type) request.setRequestHeader('Content-Type', type);
    request.responseType = 'json';
    request.upload.onprogress = ({ loaded, total }) => onProgress(total ? loaded / total : 0);
    request.onload = () => (request.status < 300 ? resolve(request.response)
      : reject(new ApiError(request.status, request.response)));
    request.onerror = () => reject(new Error('The connection to the server was lost.'));
    request.onabort = () => reject(new Error('The upload was cancelled.'));
    signal?.addEventListener('abort', () => request.abort());
    request.send(body);
  });
}

// The two files of map_server.
export function uploadGrid(name, yaml, image, options) {
  const body = new FormData();
  body.append('yaml', yaml, yaml.name);
  body.append('image', image, image.name);
  return upload('PUT', `${mapPath(name)}/grid`, { body, ...options });
}

export function uploadArchive(name, file, options) {
  return upload('POST', `${mapPath(name)}/archive`, { body: file, type: 'application/vnd.sqlite3', ...options });
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
      if (error instanceof ApiError && error.status !== 503) {
        onState('closed');
        return;
      }
    }
    if (stop.signal.aborted) return;
    onState('retrying');
    setTimeout(() => stop.signal.aborted || follow(), RETRY_MS);
  };
  follow();
  return () => stop.abort();
}
