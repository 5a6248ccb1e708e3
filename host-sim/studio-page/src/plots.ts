// Live plots, one below the other, with a common time axis, cursor and time window.

import uPlot from 'uplot';
import { ends, type Gap, type History } from './history';
import { colour, isDark, type Panel, type Term } from './terms';

// The time window: a length up to now, or a piece of the past.
export type Window = { length: number; end: number | null };

const SYNC = 'time';

// Height of the numbers and the title of the time axis.
const AXIS = 34;

export class Plots {
  window: Window = { length: 10, end: null };
  hidden = new Set<string>();
  private panels: { panel: Panel; plot: uPlot; buttons: HTMLElement }[] = [];

  constructor(
    private readonly root: HTMLElement,
    private readonly of: History,
    private readonly moved: () => void,
    // Chosen length of the window.
    private readonly span: () => number,
  ) {
    new ResizeObserver(() => this.resize()).observe(root);
    addEventListener('resize', () => this.resize());
  }

  // Time of the newest sample.
  get now(): number {
    return this.of.length ? this.of.time(this.of.length - 1) : 0;
  }

  get range(): [number, number] {
    const end = this.window.end ?? this.now;
    return [end - this.window.length, end];
  }

  get rows(): [number, number] {
    const [begin, end] = this.range;
    return [Math.max(0, this.of.row(begin) - 1), Math.min(this.of.length, this.of.row(end) + 1)];
  }

  build(panels: Panel[]): void {
    for (const { plot } of this.panels) plot.destroy();
    this.root.replaceChildren();
    this.panels = panels.map((panel, place) => {
      const box = document.createElement('figure');
      const head = document.createElement('figcaption');
      head.innerHTML = `<strong></strong><span class="terms"></span>`;
      head.querySelector('strong')!.textContent = panel.title;
      box.append(head);
      this.root.append(box);
      const plot = new uPlot(
        this.options(panel, place === panels.length - 1),
        this.empty(panel),
        box,
      );
      const buttons = head.querySelector<HTMLElement>('.terms')!;
      panel.terms.forEach((term, at) => buttons.append(this.chip(term, at, plot)));
      return { panel, plot, buttons };
    });
    this.resize();
  }

  private empty(panel: Panel): uPlot.AlignedData {
    return [[], ...panel.terms.map(() => [])] as unknown as uPlot.AlignedData;
  }

  private chip(term: Term, at: number, plot: uPlot): HTMLElement {
    const chip = document.createElement('button');
    chip.className = 'chip';
    const { look } = term;
    const dash = look.dash ? ` stroke-dasharray="${look.dash.join(' ')}"` : '';
    chip.innerHTML =
      `<svg width="28" height="8" aria-hidden="true"><line x1="0" y1="4" x2="28" ` +
      `y2="4" stroke="${colour(look)}" ` +
      `stroke-width="${look.width + 0.5}"${dash}/></svg><span></span><output></output>`;
    chip.querySelector('span')!.textContent = term.name;
    const show = () => {
      const shown = !this.hidden.has(term.name);
      chip.setAttribute('aria-pressed', String(shown));
      plot.setSeries(at + 1, { show: shown });
    };
    chip.onclick = () => {
      if (!this.hidden.delete(term.name)) this.hidden.add(term.name);
      show();
    };
    show();
    return chip;
  }

  private options(panel: Panel, last: boolean): uPlot.Options {
    const ink = isDark() ? '#c8ccd0' : '#33383d';
    const grid = { stroke: isDark() ? '#33393f' : '#dddddd', width: 1 };
    const font = '12px system-ui, sans-serif';
    const axis = { stroke: ink, grid, ticks: grid, font };
    return {
      width: 600,
      height: 100,
      padding: [6, 14, 0, 0],
      legend: { show: false },
      cursor: {
        sync: { key: SYNC, setSeries: false },
        drag: { x: true, y: false, setScale: false },
        points: { size: 5 },
      },
      scales: {
        x: { time: false, range: () => this.range },
        y: { range: (_, low, high) => padded(low, high) },
      },
      axes: [
        {
          ...axis,
          size: last ? 42 : 8,
          label: last ? 'Time, s' : undefined,
          labelSize: 18,
          labelFont: font,
          values: (_, all) => (last ? all.map((s) => String(+s.toFixed(4))) : all.map(() => '')),
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
        ...panel.terms.map(({ name, look }) => ({
          label: name,
          stroke: colour(look),
          width: look.width,
          dash: look.dash,
          points: { show: false },
          spanGaps: false,
        })),
      ],
      hooks: {
        drawClear: [(plot) => this.drawGaps(plot)],
        setSelect: [(plot) => this.zoom(plot)],
        setCursor: [(plot) => this.showValues(plot)],
        ready: [
          (plot) => {
            plot.over.ondblclick = () => {
              this.window = { length: this.span(), end: null };
              this.moved();
            };
          },
        ],
      },
    };
  }

  // Height at which all panels fit into the window, with a lower limit.
  private height(panel: Panel, last: boolean): number {
    const captions = 27 * this.panels.length;
    const parts = this.panels.reduce((all, one) => all + (one.panel.tall ? 3 : 2), 0) || 1;
    const part = Math.max(48, (innerHeight - 215 - captions - AXIS) / parts);
    return Math.floor((panel.tall ? 3 : 2) * part) + (last ? AXIS : 0);
  }

  // Gaps in the shown time.
  get gaps(): Gap[] {
    const [begin, end] = this.range;
    return this.of.gaps.filter((gap) => gap.end >= begin && gap.begin <= end);
  }

  // Draws a band where samples are missing.
  private drawGaps(plot: uPlot): void {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textBaseline = 'top';
    for (const gap of this.gaps) {
      const left = Math.max(bbox.left, plot.valToPos(gap.begin, 'x', true));
      const right = Math.min(bbox.left + bbox.width, plot.valToPos(gap.end, 'x', true));
      ctx.fillStyle = gapColour(gap);
      ctx.fillRect(left, bbox.top, Math.max(1, right - left), bbox.height);
      if (!gap.isReset) continue;
      ctx.fillStyle = isDark() ? '#e6e8ea' : '#1a1d20';
      ctx.fillText('reset', left + 3 * devicePixelRatio, bbox.top + 3 * devicePixelRatio);
    }
    ctx.restore();
  }

  private zoom(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < 4) return;
    const [begin, end] = [plot.posToVal(left, 'x'), plot.posToVal(left + width, 'x')];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.window = { length: end - begin, end };
    this.moved();
  }

  // Shows the values under the cursor, or the newest ones.
  private showValues(plot: uPlot): void {
    const entry = this.panels.find((one) => one.plot === plot);
    if (!entry) return;
    const at = plot.cursor.idx ?? (plot.data[0]?.length ?? 0) - 1;
    entry.buttons.querySelectorAll('output').forEach((output, term) => {
      const value = plot.data[term + 1]?.[at];
      output.textContent = value === null || value === undefined ? '–' : shown(value);
    });
  }

  resize(): void {
    const width = this.root.clientWidth;
    if (width === 0) return;
    this.panels.forEach(({ panel, plot }, place) =>
      plot.setSize({
        width: width - 4,
        height: this.height(panel, place === this.panels.length - 1),
      }),
    );
  }

  draw(): void {
    const [first, end] = this.rows;
    for (const { panel, plot } of this.panels) {
      const data = curves(this.of, panel.terms, first, end, Math.max(200, plot.width));
      plot.setData(data as unknown as uPlot.AlignedData, false);
      plot.redraw(true, true);
      const [low, high] = this.range;
      plot.setScale('x', { min: low, max: high });
      this.showValues(plot);
    }
  }

  // Drawn panels, for pictures.
  get drawn(): { panel: Panel; plot: uPlot }[] {
    return this.panels;
  }
}

export function gapColour({ isReset }: Gap): string {
  if (isReset) return isDark() ? '#4a5058' : '#c9ced4';
  return isDark() ? '#7a4a20' : '#f6d3b5';
}

export function shown(value: number): string {
  const size = Math.abs(value);
  if (Number.isInteger(value)) return String(value);
  // A rounding of single precision, and no measurement.
  if (size < 1e-6) return '0';
  return size >= 1000 ? value.toFixed(0) : size >= 1 ? value.toFixed(3) : value.toPrecision(3);
}

function padded(low: number | null, high: number | null): [number, number] {
  if (low === null || high === null || !isFinite(low) || !isFinite(high)) return [-1, 1];
  const room = Math.max(0.08 * (high - low), 1e-3, 0.02 * Math.max(Math.abs(low), Math.abs(high)));
  return [low - room, high + room];
}

// Returns rows as curves. If there are more than two rows a pixel, each piece keeps its least and
// largest value, so that no peak is lost. Nothing is drawn where the loop is open or samples are
// missing.
export function curves(
  of: History,
  terms: Term[],
  first: number,
  end: number,
  pixels: number,
): (number | null)[][] {
  const rows = Math.max(0, end - first);
  const piece = Math.max(1, Math.ceil(rows / pixels));
  const times: number[] = [];
  const values: (number | null)[][] = terms.map(() => []);
  const gap = (time: number) => {
    times.push(time);
    values.forEach((all) => all.push(null));
  };
  const readers = terms.map((term) => term.value(of));
  const isArmed = of.arming();
  for (let row = first, stop; row < end; row = stop) {
    stop = Math.min(end, row + piece);
    // A piece ends where samples are missing, so that no line crosses the gap.
    if (!of.whole(row, stop - 1)) {
      stop = row + 1;
      while (of.follows(stop)) stop++;
    }
    if (row > 0 && !of.follows(row)) gap(of.time(row) - 1e-6);
    const armed = isArmed(row) && isArmed(stop - 1);
    if (piece === 1 || !armed) {
      times.push(of.time(row));
      readers.forEach((read, at) => values[at].push(armed ? read(row) : null));
      continue;
    }
    times.push(of.time(row), of.time(stop - 1));
    readers.forEach((read, at) => values[at].push(...ends(read, row, stop - 1)));
  }
  return [times, ...values];
}
