// The history in the details: a timeline of statuses, stepping and playing, and the time per stage.
import { element, part, setText, show } from './dom.js';
import { isWhole } from './history.js';
import { TimesChart, timesText } from './times_chart.js';
import * as words from './words.js';

const MAX_GROW = 40;  // Of a segment of the timeline: a long one leaves room for the others.

const reasonText = (reason) => (reason ? `, ${reason.replaceAll('_', ' ')}` : '');

export class HistoryPanel {
  #chart = new TimesChart(part('times-chart'));

  // `isRecording`: the answers are those of a file.
  show(playback, isRecording) {
    const { entries } = playback.history;
    part('robot-history').hidden = entries.length < 2;
    if (entries.length < 2) return;
    this.#showTimeline(playback);
    this.#showSlider(playback);
    show(part('history-entry'), ...this.#entryTexts(playback, isRecording));
    setText(part('play-history'), playback.isPlaying ? 'Pause' : 'Play');
    part('step-live').hidden = !playback.entry || isRecording;
    part('save-recording').hidden = isRecording;
    this.#chart.show(entries);
    setText(part('times-text'), timesText(entries));
  }

  #showSlider({ history, index }) {
    const slider = part('history-step');
    slider.max = String(history.entries.length - 1);
    slider.value = String(index);
    const { sequence, status } = history.entries[index];
    slider.setAttribute('aria-valuetext', `answer ${sequence}, ${words.statusText(status)}`);
  }

  #showTimeline({ history, entry, index }) {
    show(part('timeline'), ...history.segments().map(({ status, reason, first, last }) => {
      const text = `${words.statusText(status)}${reasonText(reason)}, ${words.plural(last - first + 1, 'answer')}`;
      const button = element('button', {
        type: 'button', 'data-action': 'step-to', 'data-index': first, 'data-status': status,
        'data-key': `step-${history.entries[first].sequence}`, 'aria-label': text, title: text,
        'aria-current': entry && index >= first && index <= last ? 'true' : undefined,
      });
      button.style.flexGrow = Math.min(MAX_GROW, last - first + 1);
      return button;
    }));
  }

  #entryTexts({ entry, history }, isRecording) {
    if (!entry) return [];
    const { sequence, status, reason, received } = entry;
    const texts = [element('p', {}, `Answer ${sequence}, ${words.timeText(new Date(received))}: ${words.statusText(status)}${reasonText(reason)}.`)];
    if (!isWhole(entry)) {
      texts.push(element('p', { class: 'hint' }, isRecording ? 'The recording has no scan of this answer.'
        : 'The server did not keep the scan of this answer. It keeps scans when it is started with --recorded-answers.'));
    }
    const kept = history.entries.filter(isWhole).length;
    if (kept && kept < history.entries.length) texts.push(element('p', { class: 'hint' }, `Answers with their scan: ${kept} of ${history.entries.length}.`));
    return texts;
  }
}
