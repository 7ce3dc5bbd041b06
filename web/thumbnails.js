// Small pictures of maps, made when they come into view and kept until the map's content changes.
import { gridImage } from './api_client.js';

const WIDTH_PX = 96;
const MAX_AT_ONCE = 2;
const MAX_KEPT = 2000;

async function draw(canvas, name) {
  const picture = await createImageBitmap(await gridImage(name));
  const zoom = Math.min(WIDTH_PX / picture.width, WIDTH_PX / picture.height);
  [canvas.width, canvas.height] = [picture.width * zoom, picture.height * zoom].map((side) => Math.max(1, Math.round(side)));
  const context = canvas.getContext('2d');
  context.imageSmoothingQuality = 'high';
  context.drawImage(picture, 0, 0, canvas.width, canvas.height);
  picture.close();
}

export class Thumbnails {
  #known = new Map();  // By name and digest.
  #waiting = [];
  #busy = 0;
  #jobs = new WeakMap();
  #seen = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) if (isIntersecting) this.#enqueue(target);
  }, { rootMargin: '200px' });

  // A canvas that fills itself once it can be seen.
  of({ name, digest, bounds }) {
    const key = `${name} ${digest}`;
    const known = this.#known.get(key);
    if (known) return known;
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height, canvas.className] = [1, 1, 'thumbnail'];
    canvas.setAttribute('aria-hidden', 'true');
    if (this.#known.size >= MAX_KEPT) this.#known.delete(this.#known.keys().next().value);
    if (!bounds) return canvas;
    this.#known.set(key, canvas);
    this.#jobs.set(canvas, name);
    this.#seen.observe(canvas);
    return canvas;
  }

  #enqueue(canvas) {
    this.#seen.unobserve(canvas);
    this.#waiting.push(canvas);
    this.#work();
  }

  // Those seen last come first: a list that is scrolled fast need not draw what has gone by.
  async #work() {
    while (this.#busy < MAX_AT_ONCE && this.#waiting.length) {
      const canvas = this.#waiting.pop();
      if (!canvas.isConnected) {
        this.#seen.observe(canvas);
        continue;
      }
      ++this.#busy;
      draw(canvas, this.#jobs.get(canvas)).catch(() => {}).finally(() => {
        --this.#busy;
        this.#work();
      });
    }
  }
}
