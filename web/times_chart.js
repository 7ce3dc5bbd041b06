// The time per stage of the last answers, as stacked bars. Chart.js comes from the system.
/* global Chart */
import { milliseconds } from './words.js';
import { color } from './paint.js';

const SHOWN = 60;
const STAGES = ['odometry', 'extract', 'match', 'verify', 'track'];

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

// In words, for those who cannot see the bars.
export function timesText(entries) {
  const recent = entries.slice(-SHOWN);
  if (!recent.length) return '';
  const of = (stage) => median(recent.map(({ timing_ms: timing }) => timing[stage]));
  const stages = STAGES.map((stage) => [stage, of(stage)]).filter(([, time]) => time >= 0.05)
    .map(([stage, time]) => `${stage} ${milliseconds(time)}`);
  return `Median per answer: ${milliseconds(of('total'))}${stages.length ? ` (${stages.join(', ')})` : ''}.`;
}

export class TimesChart {
  #canvas;
  #chart = null;

  constructor(canvas) {
    this.#canvas = canvas;
  }

  show(entries) {
    if (!window.Chart) {
      this.#canvas.parentElement.hidden = true;
      return;
    }
    const recent = entries.slice(-SHOWN);
    this.#chart ??= this.#make();
    this.#chart.data.labels = recent.map(({ sequence }) => sequence);
    this.#chart.data.datasets.forEach((set, i) => {
      set.data = recent.map(({ timing_ms: timing }) => timing[STAGES[i]]);
      set.backgroundColor = color(`stage-${STAGES[i]}`);
    });
    const { scales, plugins } = this.#chart.options;
    for (const axis of [scales.x, scales.y]) axis.ticks.color = axis.title.color = color('faint');
    scales.y.grid.color = color('line');
    plugins.legend.labels.color = color('ink');
    this.#chart.update();
  }

  #make() {
    const title = (text) => ({ display: true, text });
    return new Chart(this.#canvas, {
      type: 'bar',
      data: { labels: [], datasets: STAGES.map((label) => ({ label, data: [], barPercentage: 1, categoryPercentage: 0.95 })) },
      options: {
        animation: false, responsive: true, maintainAspectRatio: false,
        plugins: { legend: { position: 'bottom', labels: { boxWidth: 12, boxHeight: 12 } } },
        scales: {
          x: { stacked: true, title: title('answer'), grid: { display: false }, ticks: { maxTicksLimit: 6 } },
          y: { stacked: true, title: title('ms'), beginAtZero: true, grid: {}, ticks: { maxTicksLimit: 5 } },
        },
      },
    });
  }
}
