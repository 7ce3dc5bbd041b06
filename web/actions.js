// What buttons do, by their `data-action`. `page` is the Inspector.
import * as api from './api_client.js';
import { addDemoMap, openUploads } from './upload_dialog.js';
import { askDescription, confirmThen } from './dialogs.js';
import { recordingName, recordingOf } from './recording.js';
import { saveFile } from './save_file.js';
import { plural } from './words.js';

function deleteMap(page) {
  const { map } = page;
  confirmThen({
    title: `Delete the map ${map.name}?`,
    text: `Its ${map.floor_map ? 'occupancy map' : plural(map.keyframes, 'keyframe')} and corners are removed, and robots `
      + 'in it get an error at their next batch. Download it first if it may be needed again.',
    yes: 'Delete the map',
  }, async () => {
    await api.deleteMap(map.name);
    page.goTo({ map: null, view: null });
    await page.reload();
  });
}

function rollBack(page, revision) {
  const { map } = page;
  confirmThen({
    title: `Roll ${map.name} back to revision ${revision}?`,
    text: `Its content, lidar and parameters become those of revision ${revision}. Robots continue in it with their next `
      + 'batch. The present revision is kept.',
    yes: 'Roll back',
  }, async () => {
    await api.rollBackMap(map.name, revision);
    await page.reload();
  });
}

// The page compares maps, so a former revision becomes a map of its own.
function compareRevision(page, revision) {
  const { map, mapNames } = page;
  const copy = `${map.name}.r${revision}`.slice(-128);
  if (mapNames.includes(copy)) {
    page.goTo({ compare: copy });
    return;
  }
  confirmThen({
    title: `Compare with revision ${revision}?`,
    text: `It is added as the map ${copy}. Delete that map when it is of no use any more.`,
    yes: 'Add it and compare',
  }, async () => {
    await api.uploadArchive(copy, await api.mapArchive(map.name, revision), { onProgress: () => {} });
    await page.reload();
    page.goTo({ compare: copy });
  });
}

function resetRobot(page) {
  const { session } = page;
  confirmThen({
    title: `Reset ${session.robot}?`,
    text: 'It forgets its pose and its local map, and searches anew. Do this when the robot was carried.',
    yes: 'Reset the robot',
  }, async () => {
    await api.resetSession(session.id);
    await page.reload();
  });
}

function deleteRobot(page) {
  const { session } = page;
  confirmThen({
    title: `Delete the session of ${session.robot}?`,
    text: 'The robot gets an error at its next batch and must open a new session.',
    yes: 'Delete the session',
  }, async () => {
    await api.deleteSession(session.id);
    page.goTo({ session: null });
    await page.reload();
  });
}

const ACTIONS = {
  'sign-out': (_, page) => page.signOut(),
  'add-map': () => openUploads([]),
  demo: () => addDemoMap(),
  'whole-map': (_, page) => page.wholeMap(),
  'choose-candidate': ({ index }, page) => page.chooseCandidate(Number(index)),
  'step-to': ({ index }, page) => page.stepTo(Number(index)),
  'step-live': (_, page) => page.stepTo(Infinity),
  'play-history': (_, page) => page.playOrPause(),
  'save-recording': (_, page) => saveFile(recordingName(page.session), recordingOf(page.session, page.history.entries)),
  'close-recording': (_, page) => page.closeRecording(),
  'show-place': ({ x, y }, page) => page.lookAt({ x: Number(x), y: Number(y) }),
  'try-here': (_, page) => page.tryHere(),
  'stop-trial': (_, page) => page.stopTrial(),
  'describe-map': (_, page) => askDescription(page.map, async (description) => {
    await api.describeMap(page.map.name, { description });
    await page.reload();
  }),
  'download-map': (_, page) => saveFile(`${page.map.name}.cornerfix`, api.mapArchive(page.map.name)),
  'roll-back': ({ revision }, page) => rollBack(page, Number(revision)),
  'compare-revision': ({ revision }, page) => compareRevision(page, Number(revision)),
  'download-revision': ({ revision }, page) => saveFile(`${page.map.name}.r${revision}.cornerfix`,
    api.mapArchive(page.map.name, Number(revision))),
  'delete-map': (_, page) => deleteMap(page),
  'reset-robot': (_, page) => resetRobot(page),
  'delete-robot': (_, page) => deleteRobot(page),
};

export function run({ action, ...data }, page) {
  ACTIONS[action]?.(data, page);
}
