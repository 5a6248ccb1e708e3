// The live plots as a picture: PNG of the screen, SVG of the same curves.

import { gapColour, type Plots } from './plots';
import { colour, isDark } from './terms';

const GAP = 26;
const MARGIN = 8;

const ground = () => (isDark() ? '#14171a' : '#ffffff');
const ink = () => (isDark() ? '#e6e8ea' : '#1a1d20');

export function png(plots: Plots, title: string): Promise<Blob | null> {
  const scale = devicePixelRatio;
  const canvases = plots.drawn.map(({ plot }) => plot.ctx.canvas);
  const picture = document.createElement('canvas');
  picture.width = Math.max(...canvases.map((one) => one.width)) + 2 * MARGIN * scale;
  picture.height = canvases.reduce((all, one) => all + one.height + GAP * scale, GAP * scale);
  const ctx = picture.getContext('2d')!;
  ctx.fillStyle = ground();
  ctx.fillRect(0, 0, picture.width, picture.height);
  ctx.fillStyle = ink();
  ctx.font = `${13 * scale}px system-ui, sans-serif`;
  ctx.fillText(title, MARGIN * scale, 18 * scale);
  let top = GAP * scale;
  plots.drawn.forEach(({ panel }, place) => {
    ctx.font = `bold ${12 * scale}px system-ui, sans-serif`;
    ctx.fillStyle = ink();
    ctx.fillText(panel.title, MARGIN * scale, top + 17 * scale);
    let left = (MARGIN + 150) * scale;
    ctx.font = `${12 * scale}px system-ui, sans-serif`;
    for (const term of panel.terms) {
      if (plots.hidden.has(term.name)) continue;
      ctx.strokeStyle = colour(term.look);
      ctx.lineWidth = term.look.width * scale;
      ctx.setLineDash((term.look.dash ?? []).map((one) => one * scale));
      ctx.beginPath();
      ctx.moveTo(left, top + 13 * scale);
      ctx.lineTo(left + 28 * scale, top + 13 * scale);
      ctx.stroke();
      ctx.fillText(term.name, left + 34 * scale, top + 17 * scale);
      left += 50 * scale + ctx.measureText(term.name).width;
    }
    ctx.setLineDash([]);
    ctx.drawImage(canvases[place], MARGIN * scale, top + GAP * scale);
    top += canvases[place].height + GAP * scale;
  });
  return new Promise((done) => picture.toBlob(done));
}

const escaped = (text: string) =>
  text.replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/"/g, '&quot;');

export function svg(plots: Plots, title: string): Blob {
  const [begin, end] = plots.range;
  const [width, left] = [900, 70];
  const parts: string[] = [];
  const text = (x: number, y: number, what: string, more = '') =>
    parts.push(`<text x="${x}" y="${y}" ${more}>${escaped(what)}</text>`);
  let top = 30;
  text(10, 18, title);
  plots.drawn.forEach(({ panel, plot }, place) => {
    const height = panel.tall ? 170 : 110;
    const { min = -1, max = 1 } = plot.scales.y as { min?: number; max?: number };
    const x = (time: number) => left + ((time - begin) / (end - begin)) * (width - left - 20);
    const y = (value: number) => top + 22 + (1 - (value - min) / (max - min)) * height;
    text(10, top + 12, panel.title, 'font-weight="bold"');
    for (const gap of plots.gaps) {
      const [from, to] = [Math.max(begin, gap.begin), Math.min(end, gap.end)].map(x);
      const broad = Math.max(1, to - from).toFixed(2);
      parts.push(
        `<rect x="${from.toFixed(2)}" y="${top + 22}" width="${broad}" height="${height}" ` +
          `fill="${gapColour(gap)}" class="${gap.isReset ? 'reset' : 'gap'}"/>`,
      );
      if (gap.isReset) text(from + 3, top + 34, 'reset');
    }
    for (const value of ticks(min, max, 5)) {
      parts.push(
        `<path d="M${left} ${y(value).toFixed(1)}H${width - 20}" ` +
          `stroke="${isDark() ? '#33393f' : '#dddddd'}"/>`,
      );
      text(left - 6, y(value) + 4, String(+value.toPrecision(6)), 'text-anchor="end"');
    }
    let at = 180;
    panel.terms.forEach((term, series) => {
      if (plots.hidden.has(term.name)) return;
      const { look } = term;
      const dash = look.dash ? ` stroke-dasharray="${look.dash.join(' ')}"` : '';
      const style = `fill="none" stroke="${colour(look)}" stroke-width="${look.width}"${dash}`;
      parts.push(`<path d="M${at} ${top + 8}h28" ${style}/>`);
      text(at + 34, top + 12, term.name);
      at += 60 + 7 * term.name.length;
      let path = '';
      let pen = 'M';
      plot.data[0].forEach((time, i) => {
        const value = plot.data[series + 1][i];
        if (value === null || value === undefined || time < begin || time > end) pen = 'M';
        else {
          path += `${pen}${x(time).toFixed(2)} ${y(value).toFixed(2)}`;
          pen = 'L';
        }
      });
      parts.push(`<path d="${path}" ${style}/>`);
    });
    top += height + 40;
    if (place === plots.drawn.length - 1) {
      for (const time of ticks(begin, end, 8))
        text(x(time), top, String(+time.toFixed(4)), 'text-anchor="middle"');
      text((left + width) / 2, top + 18, 'Time, s', 'text-anchor="middle"');
    }
  });
  const body =
    `<rect width="100%" height="100%" fill="${ground()}"/><g ` +
    `font-family="sans-serif" font-size="12" fill="${ink()}">${parts.join('\n')}</g>`;
  return new Blob(
    [
      `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" ` +
        `height="${top + 30}">${body}</svg>\n`,
    ],
    { type: 'image/svg+xml' },
  );
}

function ticks(low: number, high: number, about: number): number[] {
  const raw = (high - low) / about;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw) ?? raw;
  const all: number[] = [];
  for (let value = Math.ceil(low / step) * step; value <= high; value += step) all.push(value);
  return all;
}
