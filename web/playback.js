// Stepping through a robot's answers, by hand or by itself.
import { History, isWhole } from './history.js';

const STEP_MS = 400;

export class Playback {
  history = new History();
  #on;
  #step = null;    // Index of an entry, or null for the newest one.
  #wanted = null;  // Sequence that the address asks for, until it is known.
  #timer = null;

  // `on` has stepped(), called when another answer is looked at.
  constructor(on) {
    this.#on = on;
  }

  // Another robot or recording; `wanted` is the sequence to look at, or null.
  begin(wanted) {
    this.pause();
    [this.history, this.#step, this.#wanted] = [new History(), null, wanted];
  }

  // Looks at the answer of this sequence as soon as it is known.
  want(sequence) {
    this.#wanted = sequence;
    this.arrived();
  }

  // To be called when the history has grown.
  arrived() {
    if (this.#wanted === null) return;
    const index = this.history.indexOf(this.#wanted);
    if (index < 0) return;
    this.#wanted = null;
    this.stepTo(index);
  }

  // The entry that is looked at, or null for the newest answer, which may still change.
  get entry() {
    return this.#step === null ? null : this.history.entries[this.#step] ?? null;
  }

  get index() {
    return this.#step ?? this.history.entries.length - 1;
  }

  get isPlaying() {
    return this.#timer !== null;
  }

  // Beyond the last entry the newest answer is followed again.
  stepTo(index) {
    this.#step = index >= this.history.entries.length ? null : Math.max(0, index);
    this.#on.stepped();
  }

  // From where it stands; from the beginning when it stands at the end.
  play() {
    const { length } = this.history.entries;
    if (this.index >= length - 1) this.#step = 0;
    this.#timer = setInterval(() => this.#next(), STEP_MS);
    this.#on.stepped();
  }

  pause() {
    clearInterval(this.#timer);
    this.#timer = null;
  }

  #next() {
    if (this.index >= this.history.entries.length - 1) this.pause();
    else ++this.#step;
    this.#on.stepped();
  }
}

// An entry as an answer: one without its scan has no candidate poses either.
export const answerOf = (entry) => (isWhole(entry) ? entry : { ...entry, hypotheses: [], local: null });
