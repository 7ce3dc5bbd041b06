// Adds a map by files that are dropped on the page or chosen: a map_server pair, an archive, or a run.
import * as api from './api_client.js';
import { whyRefused } from './dialogs.js';
import { part, setText } from './dom.js';
import { buildMapFrom } from './log_reader.js';

const DEMO = { name: 'willow', yaml: 'demo/willow_full_0.05.yaml', image: 'demo/willow_full_0.05.png' };
const OTHER_RUNS = /\.(log|clf|gfs|bag|mcap|db3)(\.gz)?$/i;

const IMAGE = /\.(pgm|png|bmp)$/i;
const YAML = /\.ya?ml$/i;
const ARCHIVE = /\.(cornerfix|sqlite3?)$/i;
const RECORDING = /\.json$/i;
const RUN = /\.jsonl(\.gz)?$/i;

let page = null;
let files = [];
let running = null;  // Aborts the upload that is under way.

// What the files are: {kind, text, start}, or {text} when they cannot be used.
function recognize(chosen) {
  const find = (pattern) => chosen.find(({ name }) => pattern.test(name));
  const [yaml, image, archive, run, other] = [YAML, IMAGE, ARCHIVE, RUN, OTHER_RUNS].map(find);
  if (yaml && image) {
    return { text: `An occupancy map: ${yaml.name} and ${image.name}.`, start: (name, options) => api.uploadGrid(name, yaml, image, options) };
  }
  if (yaml || image) return { text: `Choose ${yaml ? 'the image (pgm or png)' : 'the yaml'} as well: map_server’s maps are two files.` };
  if (archive) return { text: `A map archive: ${archive.name}.`, needsFreeName: true, start: (name, options) => api.uploadArchive(name, archive, options) };
  if (run) return { text: `A recorded run: ${run.name}.`, start: (name, options) => buildMapFrom(run, name, options) };
  if (other) return { text: `The page cannot read ${other.name}. On the command line: cornerfix map build NAME ${other.name}` };
  return { text: chosen.length ? `None of these files is a map or a run: ${chosen.map(({ name }) => name).join(', ')}.` : '' };
}

const nameFrom = (fileName) => fileName.replace(/\.(gz)$/i, '').replace(/\.[^.]+$/, '').replace(/[^A-Za-z0-9._-]+/g, '-')
  .replace(/^[^A-Za-z0-9]+/, '');

function take(chosen) {
  files = [...chosen];
  const known = recognize(files);
  setText(part('upload-kind'), known.text);
  setText(part('upload-error'), '');
  if (files.length && !part('upload-name').value) part('upload-name').value = nameFrom((files.find(({ name }) => YAML.test(name)) ?? files[0]).name);
  part('upload-start').disabled = !known.start;
}

function problemWith(name, known) {
  if (!/^[A-Za-z0-9][A-Za-z0-9._-]{0,127}$/.test(name)) return 'A name has letters, digits, dots, dashes and underscores only.';
  if (known.needsFreeName && page.maps().some((map) => map.name === name)) return `There is a map ${name} already: choose another name.`;
  return '';
}

async function start() {
  const known = recognize(files);
  const name = part('upload-name').value.trim();
  const problem = problemWith(name, known);
  setText(part('upload-error'), problem);
  if (!problem) await run(name, known.start);
}

async function run(name, upload) {
  const bar = part('upload-progress');
  running = new AbortController();
  bar.hidden = false;
  part('upload-start').disabled = true;
  setText(part('upload-cancel'), 'Cancel');
  try {
    const answer = await upload(name, {
      signal: running.signal, isNew: !page.maps().some((map) => map.name === name), onProgress: (share) => showProgress(share),
    });
    part('upload-dialog').close();
    if (answer?.warnings?.length) window.setTimeout(() => setText(part('notice'), `${name}: ${answer.warnings.join('; ')}`), 0);
    await page.done(name);
  } catch (error) {
    setText(part('upload-error'), whyRefused(error));
  } finally {
    running = null;
    bar.hidden = true;
    part('upload-start').disabled = false;
    setText(part('upload-cancel'), 'Close');
  }
}

// All is sent: now the server makes the map, which may take a while.
function showProgress(share) {
  const bar = part('upload-progress');
  if (share < 1) bar.value = share;
  else bar.removeAttribute('value');
  setText(part('upload-kind'), share < 1 ? `Sent ${Math.round(share * 100)} %` : 'The server is making the map.');
}

export function openUploads(chosen) {
  part('upload-name').value = '';
  part('upload-files').value = '';
  take(chosen);
  const dialog = part('upload-dialog');
  if (!dialog.open) dialog.showModal();
}

// The map of the demo, which the server ships.
export async function addDemoMap() {
  const fileOf = async (path) => new File([await api.sharedFile(path)], path.split('/').at(-1));
  openUploads([await fileOf(DEMO.yaml), await fileOf(DEMO.image)]);
  part('upload-name').value = DEMO.name;
  await start();
}

// `given` has maps(), the entries there are, done(name), called when a map is added, and open(file),
// which plays a recording.
export function setUpUploads(given) {
  page = given;
  part('upload-files').addEventListener('change', (event) => take(event.target.files));
  part('upload-start').addEventListener('click', start);
  part('upload-dialog').addEventListener('close', () => running?.abort());
  document.addEventListener('dragover', (event) => event.preventDefault());
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    const { files: dropped } = event.dataTransfer;
    const recording = [...dropped].find(({ name }) => RECORDING.test(name));
    if (recording) page.open(recording);
    else if (dropped.length && !running) openUploads(dropped);
  });
}
