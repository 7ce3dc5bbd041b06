// A robot's answers over time: those that the server keeps, those that come while it is watched, or
// those of a recording.
const MAX_ANSWERS = 2000;
const MAX_WHOLE = 300;  // Newest answers that keep their scan and candidate poses.

const withoutScan = ({ sequence, status, reason, pose, confidence, timing_ms, received }) => ({
  sequence, status, reason, pose, confidence, timing_ms, received,
});

// Whether an entry still has its scan and candidate poses.
export const isWhole = ({ hypotheses }) => Array.isArray(hypotheses);

export class History {
  #entries = [];  // Answers, each with the time when it was received [ms].

  get entries() {
    return this.#entries;
  }

  // What the server keeps, or a recording. Answers that came live stay: they have their scan.
  load(answers) {
    const live = new Map(this.#entries.map((entry) => [entry.sequence, entry]));
    const last = answers.at(-1)?.sequence ?? -1;
    const loaded = answers.map((answer) => {
      const known = live.get(answer.sequence);
      return known && (isWhole(known) || !isWhole(answer)) ? known : { ...answer, received: Date.parse(answer.received) };
    });
    this.#entries = [...loaded, ...this.#entries.filter(({ sequence }) => sequence > last)];
  }

  // False when the answer was known. The list's answers have no points; the live ones that follow do.
  add(answer, received) {
    const last = this.#entries.at(-1);
    if (last && last.sequence > answer.sequence) return false;
    if (last?.sequence === answer.sequence) {
      if (answer.scan_points && !last.scan_points) this.#entries.splice(-1, 1, { ...answer, received: last.received });
      return false;
    }
    this.#entries.push({ ...answer, received });
    const old = this.#entries.length - 1 - MAX_WHOLE;
    if (old >= 0) this.#entries[old] = withoutScan(this.#entries[old]);
    if (this.#entries.length > MAX_ANSWERS) this.#entries.shift();
    return true;
  }

  indexOf(sequence) {
    return this.#entries.findIndex((entry) => entry.sequence === sequence);
  }

  // The last pose before an entry, or null.
  poseBefore(index) {
    return this.#entries.slice(0, index).findLast(({ pose }) => pose)?.pose ?? null;
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

  // Pieces of the path on one map up to an entry, each without a jump.
  pathOn(map, last = this.#entries.length - 1) {
    const pieces = [];
    let before = null;
    for (const { pose } of this.#entries.slice(0, last + 1)) {
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
