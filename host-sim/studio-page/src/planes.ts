// Phase portrait (velocity over error) and friction map (effort over velocity) of the shown time.

import uPlot from 'uplot';
import type { History } from './history';
import { colour, errorCounts, isDark, LOOKS, type Read } from './terms';

const MOST_POINTS = 6000;
const SHADES = 6;

type Plane = { title: string; across: string; up: string; x: Read; y: Read };

const velocity: Read = (of) => of.reader('velocity_deg_per_s');

const PLANES: Plane[] = [
  {
    title: 'Phase portrait',
    across: 'Error, counts',
    up: 'Velocity, deg/s',
    x: errorCounts,
    y: velocity,
  },
  {
    title: 'Friction map',
    across: 'Velocity, deg/s',
    up: 'Effort applied, V',
    x: velocity,
    y: (of) => of.reader('v_applied_v'),
  },
];

export class Planes {
  private plots: uPlot[] = [];
  // Whether a line starts at a point: the loop was open before, or samples are missing.
  private begins: boolean[] = [];

  constructor(
    private readonly root: HTMLElement,
    private readonly of: History,
    private readonly onThinned: (text: string) => void,
  ) {
    new ResizeObserver(() => this.resize()).observe(root);
  }

  build(): void {
    for (const plot of this.plots) plot.destroy();
    this.root.replaceChildren();
    this.plots = PLANES.map((plane) => {
      const box = document.createElement('figure');
      const head = document.createElement('figcaption');
      head.append(Object.assign(document.createElement('strong'), { textContent: plane.title }));
      box.append(head);
      this.root.append(box);
      return new uPlot(this.options(plane), [null, [[], []]] as unknown as uPlot.AlignedData, box);
    });
    this.resize();
  }

  private options(plane: Plane): uPlot.Options {
    const ink = isDark() ? '#c8ccd0' : '#33383d';
    const grid = { stroke: isDark() ? '#33393f' : '#dddddd', width: 1 };
    const font = '12px system-ui, sans-serif';
    const axis = {
      stroke: ink,
      grid,
      ticks: grid,
      font,
      labelFont: font,
      labelSize: 20,
      values: (_: uPlot, all: number[]) => all.map((v) => String(+v.toPrecision(6))),
    };
    const range = (_: uPlot, low: number | null, high: number | null): [number, number] => {
      if (low === null || high === null || !isFinite(low) || !isFinite(high)) return [-1, 1];
      const room = Math.max(0.06 * (high - low), 1e-3);
      return [low - room, high + room];
    };
    return {
      mode: 2,
      width: 500,
      height: 420,
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false, range }, y: { range } },
      axes: [
        { ...axis, label: plane.across, size: 46 },
        { ...axis, label: plane.up, size: 62 },
      ],
      series: [
        {},
        {
          facets: [
            { scale: 'x', auto: true },
            { scale: 'y', auto: true },
          ],
          stroke: colour(LOOKS.primary),
          paths: (plot, series) => trace(plot, series, this.begins),
        } as uPlot.Series,
      ],
    } as uPlot.Options;
  }

  resize(): void {
    const width = this.root.clientWidth;
    if (width === 0) return;
    const beside = width >= 800 ? 2 : 1;
    for (const plot of this.plots) {
      plot.setSize({
        width: Math.floor(width / beside) - 12,
        height: Math.min(480, Math.max(300, width / beside - 60)),
      });
    }
  }

  draw([first, end]: [number, number]): void {
    const step = Math.max(1, Math.ceil((end - first) / MOST_POINTS));
    const armed = this.of.arming();
    const rows: number[] = [];
    this.begins = [];
    // Number of rows since the start of the line.
    let along = 0;
    for (let row = first; row < end; row++) {
      if (!armed(row)) {
        along = 0;
        continue;
      }
      if (!this.of.follows(row)) along = 0;
      const isLast = row === end - 1;
      if (along % step === 0 || isLast) {
        rows.push(row);
        this.begins.push(along === 0);
      }
      along++;
    }
    this.onThinned(step > 1 ? `Drawn is 1 of ${step} samples.` : '');
    this.plots.forEach((plot, place) => {
      const [x, y] = [PLANES[place].x(this.of), PLANES[place].y(this.of)];
      plot.setData([null, [rows.map(x), rows.map(y)]] as unknown as uPlot.AlignedData);
    });
  }
}

// Draws the curve in shades: the newest part is the strongest, and ends in a dot.
function trace(plot: uPlot, series: number, begins: boolean[]): null {
  uPlot.orient(plot, series, (_s, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    const { ctx } = plot;
    const count = (xs as number[]).length;
    if (count === 0) return;
    const x = (i: number) => toX(xs[i] as number, scaleX, width, left);
    const y = (i: number) => toY(ys[i] as number, scaleY, height, top);
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, top, width, height);
    ctx.clip();
    ctx.strokeStyle = ctx.fillStyle = colour(LOOKS.primary);
    ctx.lineWidth = 1.6 * devicePixelRatio;
    for (let shade = 0; shade < SHADES; shade++) {
      const [from, to] = [shade, shade + 1].map((part) =>
        Math.floor((part * (count - 1)) / SHADES),
      );
      ctx.globalAlpha = 0.2 + (0.8 * (shade + 1)) / SHADES;
      ctx.beginPath();
      ctx.moveTo(x(from), y(from));
      for (let i = from + 1; i <= to; i++) {
        if (begins[i]) ctx.moveTo(x(i), y(i));
        else ctx.lineTo(x(i), y(i));
      }
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
    ctx.fillStyle = isDark() ? '#ff8f40' : '#d55e00';
    ctx.beginPath();
    ctx.arc(x(count - 1), y(count - 1), 4.5 * devicePixelRatio, 0, 2 * Math.PI);
    ctx.fill();
    ctx.restore();
  });
  return null;
}
