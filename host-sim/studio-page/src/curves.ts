// Curves of one move, each with a time of its own: position, error and effort, one below the other.

import uPlot from 'uplot';
import { element } from './app';
import { colour, isDark, type Look } from './terms';

export type MoveCurve = {
  // Empty for a curve of a cloud, which has no entry in the legend.
  name: string;
  look: Look;
  times: number[];
  position?: number[];
  error?: number[];
  effort?: number[];
  twist?: number[];
};
type Term = 'position' | 'error' | 'effort' | 'twist';

const PANELS: { title: string; term: Term; height: number }[] = [
  { title: 'Position, deg', term: 'position', height: 190 },
  { title: 'Error, counts', term: 'error', height: 170 },
  // Only of a joint with two encoders: their difference, from the start of the move on.
  { title: 'Motor less load, deg', term: 'twist', height: 120 },
  { title: 'Effort, V', term: 'effort', height: 150 },
];

// Scale at which all panels and the table fit into the window, with a lower limit.
const fits = () => Math.min(1.4, Math.max(0.7, (innerHeight - 480) / 510));

export class Curves {
  private plots: (uPlot | null)[] = PANELS.map(() => null);
  private layout: string[] = PANELS.map(() => '');
  private boxes: HTMLElement[];
  private legend = element('p', { className: 'legend' });
  private last: [MoveCurve[], [number, number]] | null = null;
  private range: [number, number] = [0, 1];

  constructor(private readonly root: HTMLElement) {
    this.boxes = PANELS.map(({ title }) =>
      element('figure', {}, element('figcaption', {}, element('strong', { textContent: title }))),
    );
    root.append(this.legend, ...this.boxes);
    new ResizeObserver(() => this.resize()).observe(root);
  }

  // Redraws with the colours of another theme.
  repaint(): void {
    this.layout = PANELS.map(() => '');
    if (this.last) this.show(...this.last);
  }

  show(all: MoveCurve[], range: [number, number]): void {
    this.last = [all, range];
    this.range = range;
    this.name(all.filter((one) => one.name));
    PANELS.forEach(({ term }, place) => {
      const own = all.filter((one) => one[term]);
      this.boxes[place].hidden = term === 'twist' && own.length === 0;
      const layout = JSON.stringify(own.map(({ name, look }) => [name, look]));
      if (layout !== this.layout[place]) {
        this.plots[place]?.destroy();
        this.plots[place] = new uPlot(this.options(own, place), [[]], this.boxes[place]);
        this.layout[place] = layout;
        this.resize();
      }
      const tables = own.map((one) => [one.times, one[term]!] as unknown as uPlot.AlignedData);
      const data = tables.length ? uPlot.join(tables) : ([[]] as unknown as uPlot.AlignedData);
      this.plots[place]!.setData(data);
    });
  }

  private name(all: MoveCurve[]): void {
    const one = ({ name, look }: MoveCurve) => {
      const chip = element('span', { className: 'chip' });
      const dash = look.dash ? ` stroke-dasharray="${look.dash.join(' ')}"` : '';
      chip.innerHTML =
        `<svg width="28" height="8" aria-hidden="true"><line x1="0" y1="4" ` +
        `x2="28" y2="4" stroke="${colour(look)}" ` +
        `stroke-width="${look.width + 0.5}"${dash}/></svg><span></span>`;
      chip.querySelector('span')!.textContent = name;
      return chip;
    };
    this.legend.replaceChildren(...all.map(one));
  }

  private options(own: MoveCurve[], place: number): uPlot.Options {
    const ink = isDark() ? '#c8ccd0' : '#33383d';
    const grid = { stroke: isDark() ? '#33393f' : '#dddddd', width: 1 };
    const font = '12px system-ui, sans-serif';
    const last = place === PANELS.length - 1;
    const axis = { stroke: ink, grid, ticks: grid, font, labelFont: font };
    return {
      width: 600,
      height: Math.round(PANELS[place].height * fits()) + (last ? 34 : 0),
      padding: [6, 14, 0, 0],
      legend: { show: false },
      cursor: { sync: { key: 'what-if' }, drag: { x: false, y: false }, points: { show: false } },
      scales: {
        x: { time: false, range: () => this.range },
        y: {
          range: (_, low, high) => {
            if (low === null || high === null || !isFinite(low) || !isFinite(high)) return [-1, 1];
            const room = Math.max(0.07 * (high - low), 1e-3);
            return [low - room, high + room];
          },
        },
      },
      axes: [
        {
          ...axis,
          size: last ? 42 : 8,
          label: last ? 'Time since the start of the set point, s' : undefined,
          labelSize: 18,
          values: (_, all) => all.map((s) => (last ? String(+s.toFixed(4)) : '')),
        },
        {
          ...axis,
          size: 62,
          space: 24,
          values: (_, all) => all.map((v) => String(+v.toPrecision(6))),
        },
      ],
      series: [
        {},
        ...own.map(({ look }) => ({
          stroke: colour(look),
          width: look.width,
          dash: look.dash,
          points: { show: false },
          spanGaps: true,
        })),
      ],
    };
  }

  private resize(): void {
    const width = this.root.clientWidth;
    if (width === 0) return;
    this.plots.forEach((plot) => plot?.setSize({ width: width - 4, height: plot.height }));
  }
}
