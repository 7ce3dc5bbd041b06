// Reads a recorded run of JSON lines (docs/logs.md) as it streams, and gives it to the server as scans of a map.
import { addMapScans, describeMap } from './api_client.js';

const BATCH = 50;
const GEOMETRY = ['angle_min', 'angle_increment', 'range_min', 'range_max'];

async function* linesOf(file, onProgress) {
  let read = 0;
  const counted = new TransformStream({
    transform(chunk, controller) {
      read += chunk.byteLength;
      onProgress(read / file.size);
      controller.enqueue(chunk);
    },
  });
  let bytes = file.stream().pipeThrough(counted);
  if (file.name.endsWith('.gz')) bytes = bytes.pipeThrough(new DecompressionStream('gzip'));
  const reader = bytes.pipeThrough(new TextDecoderStream()).getReader();
  let text = '';
  let number = 0;
  for (;;) {
    const { done, value } = await reader.read();
    const lines = (text + (value ?? '')).split('\n');
    text = done ? '' : lines.pop();
    for (const line of lines) {
      ++number;
      if (line.trim()) yield { line, number };
    }
    if (done) return;
  }
}

function parse({ line, number }, fileName) {
  try {
    return JSON.parse(line);
  } catch {
    throw new Error(`${fileName}, line ${number}: not a JSON object.`);
  }
}

const asPose = (values) => values && { x: values[0], y: values[1], yaw: values[2] };

function scanOf(row, hasPoses) {
  const scan = { stamp: row.t, ranges: row.ranges };
  for (const name of [...GEOMETRY, 'time_increment']) if (name in row) scan[name] = row[name];
  if (hasPoses) scan.pose = asPose(row.pose);
  else if (row.odom) scan.odom = asPose(row.odom);
  return scan;
}

// Adds the run's scans to the map, made when it is not there. Scans without poses are a run whose poses
// the server finds. Returns the server's last answer.
export async function buildMapFrom(file, name, { onProgress, signal, isNew }) {
  let lidar = null;
  let hasPoses = null;
  let scans = [];
  let answer = null;
  const send = async () => {
    if (signal.aborted) throw new Error('The upload was cancelled.');
    if (scans.length) answer = await addMapScans(name, { lidar, scans });
    scans = [];
  };
  for await (const line of linesOf(file, onProgress)) {
    const row = parse(line, file.name);
    if (!lidar) {
      lidar = lidarOf(row, file.name);
      if (isNew) await describeMap(name, { description: `from ${file.name}`, lidar });
      continue;
    }
    hasPoses ??= Boolean(row.pose);
    if (hasPoses && !row.pose) continue;
    scans.push(scanOf(row, hasPoses));
    if (scans.length === BATCH) await send();
  }
  await send();
  if (!answer) throw new Error(`${file.name} has no scan.`);
  return answer;
}

function lidarOf(header, fileName) {
  const missing = GEOMETRY.filter((name) => !(name in header));
  if (missing.length) throw new Error(`${fileName}, line 1: expected the header of a run; it has no ${missing.join(', ')}.`);
  const lidar = Object.fromEntries(GEOMETRY.map((name) => [name, header[name]]));
  return header.beams ? { ...lidar, beams: header.beams } : lidar;
}
