// A robot's answers over time: those that the server keeps, and those that come while it is watched.
const MAX_ANSWERS = 2000;

// An answer as it is kept here: without points and candidates.
const entryOf = ({ sequence, status, reason, pose, confidence, timing_ms: timing }, received) => ({
  sequence, status, reason, pose, confidence, timing_ms: timing, received,
});

export class History {
  #entries = [];

  get entries() {
    return this.#entries;
  }

  // What the server knows; later answers that came live stay.
  load(answers) {
    const last = answers.at(-1)?.sequence ?? -1;
    const loaded = answers.map((answer) => entryOf(answer, Date.parse(answer.received)));
    this.#entries = [...loaded, ...this.#entries.filter(({ sequence }) => sequence > last)];
  }

  // False when the answer was known.
  add(answer, received) {
    const last = this.#entries.at(-1);
    if (last && last.sequence >= answer.sequence) return false;
    this.#entries.push(entryOf(answer, received));
    if (this.#entries.length > MAX_ANSWERS) this.#entries.shift();
    return true;
  }

  // Consecutive answers of one status and reason: {status, reason, first, last}, indices of entries.
  segments() {
    const segments = [];
    this.#entries.forEach(({ status, reason }, index) => {
      const open = segments.at(-1);
      if (open && open.status === status && open.reason === reason) open.last = index;
      else segments.push({ status, reason, first: index, last: index });
    });
    return segments;
  }

  // Pieces of the path on one map, each without a jump.
  pathOn(map) {
    const pieces = [];
    let before = null;
    for (const { pose } of this.#entries) {
      if (!pose || pose.map !== map) {
        before = null;
        continue;
      }
      if (!before || before.epoch !== pose.epoch) pieces.push([]);
      pieces.at(-1).push({ x: pose.x, y: pose.y });
      before = pose;
    }
    return pieces;
  }
}
