// An animated SVG of one move under two laws, of what the studio's server predicts. It is text, and
// the same for the same prediction. A reader who wants no motion sees its end.

const WIDTH = 860;
const HEIGHT = 400;
const LEFT = 64;
const RIGHT = 560;
const PANELS = { position: [44, 176], error: [226, 356] };
const PAUSE = 0.25;
const LOOKS = [
  { colour: '#d55e00', dash: '7 4' },
  { colour: '#00548f', dash: '' },
];
const NEEDLE_STEPS = 80;

export function animation({ laws, curves, title, deg, until, note }) {
  const end = Math.min(
    until,
    ...curves.map((one) => one.begin_s + (one.position_deg.length - 1) * one.tick_s),
  );
  const x = (s) => LEFT + ((RIGHT - LEFT) * s) / end;
  const line = (values, one, y) =>
    values
      .map((value, k) => [one.begin_s + k * one.tick_s, value])
      .filter(([s]) => s >= 0 && s <= end)
      .map(([s, value], k) => `${k ? 'L' : 'M'}${x(s).toFixed(1)} ${y(value).toFixed(1)}`)
      .join('');
  const scale =
    ([top, bottom], low, high) =>
    (value) =>
      bottom - ((Math.min(high, Math.max(low, value)) - low) / (high - low)) * (bottom - top);
  const most = 1.2 * deg;
  const yPosition = scale(PANELS.position, -0.1 * deg, most);
  const rest = Math.max(...curves.map((one) => Math.abs(one.error_counts.at(-1))));
  const band = Math.max(20, 20 * Math.ceil((1.3 * rest) / 20));
  const yError = scale(PANELS.error, -band, band);
  const parts = [];
  const text = (tx, ty, what, more = '') =>
    parts.push(`<text x="${tx}" y="${ty}" ${more}>${what}</text>`);
  const style = (k) =>
    `fill="none" stroke="${LOOKS[k].colour}" stroke-width="2.2" ` +
    `stroke-linejoin="round"${LOOKS[k].dash ? ` stroke-dasharray="${LOOKS[k].dash}"` : ''}`;
  curves.forEach((one, k) => {
    parts.push(`<path d="${line(one.position_deg, one, yPosition)}" ${style(k)}/>`);
    parts.push(`<path d="${line(one.error_counts, one, yError)}" ${style(k)}/>`);
  });
  // The future: a cover that slides away.
  parts.push(
    `<g class="cover"><rect x="${LEFT}" y="36" width="${RIGHT - LEFT + 12}" ` +
      `height="${HEIGHT - 66}" fill="#fff"/><path d="M${LEFT} 36V${PANELS.error[1]}" ` +
      `stroke="#999"/></g>`,
    `<rect x="${RIGHT + 1}" y="0" width="${WIDTH - RIGHT}" height="${HEIGHT}" fill="#fff"/>`,
  );
  const grid = (y, value, label) => {
    parts.push(`<path d="M${LEFT} ${y(value).toFixed(1)}H${RIGHT}" stroke="#ddd"/>`);
    text(LEFT - 8, (y(value) + 4).toFixed(1), label, 'text-anchor="end"');
  };
  for (const value of [0, deg / 2, deg]) grid(yPosition, value, String(value));
  for (const value of [-band, 0, band]) grid(yError, value, String(value));
  for (let s = 0; s <= end; s += 0.5) text(x(s).toFixed(1), HEIGHT - 26, s, 'text-anchor="middle"');
  text((LEFT + RIGHT) / 2, HEIGHT - 8, 'Time, s', 'text-anchor="middle"');
  text(LEFT, 20, title, 'font-weight="bold" font-size="15"');
  text(LEFT, 38, 'Position, deg');
  text(LEFT, PANELS.error[0] - 8, 'Error, counts (larger values at the edge)');
  const keyframes = [];
  curves.forEach((one, k) => {
    const [cx, cy] = [700, 112 + 160 * k];
    const degrees = (counts) => (-60 * Math.max(-band, Math.min(band, counts))) / band;
    const at = (s) => {
      const row = Math.round((s - one.begin_s) / one.tick_s);
      return degrees(one.error_counts[Math.min(one.error_counts.length - 1, Math.max(0, row))]);
    };
    const steps = [];
    for (let i = 0; i <= NEEDLE_STEPS; i++) {
      const share = (100 * (1 - PAUSE) * i) / NEEDLE_STEPS;
      const turn = at((end * i) / NEEDLE_STEPS).toFixed(1);
      steps.push(`${share.toFixed(2)}%{transform:rotate(${turn}deg)}`);
    }
    const last = degrees(one.error_counts.at(-1)).toFixed(1);
    keyframes.push(`@keyframes n${k}{${steps.join('')}100%{transform:rotate(${last}deg)}}`);
    const arc = (turn) => {
      const angle = (turn * Math.PI) / 180;
      return `${(cx + 78 * Math.sin(angle)).toFixed(1)} ${(cy - 78 * Math.cos(angle)).toFixed(1)}`;
    };
    parts.push(
      `<path d="M${arc(-60)}A78 78 0 0 1 ${arc(60)}" fill="none" stroke="#999" ` +
        `stroke-width="1.5"/>`,
      `<path d="M${cx} ${cy - 84}V${cy - 70}" stroke="#000" stroke-width="2"/>`,
      `<g style="transform-origin:${cx}px ` +
        `${cy}px;transform:rotate(${last}deg);animation:n${k} ` +
        `${(end / (1 - PAUSE)).toFixed(1)}s linear infinite" class="needle"><path ` +
        `d="M${cx} ${cy}V${cy - 74}" stroke="${LOOKS[k].colour}" stroke-width="3"/></g>`,
      `<circle cx="${cx}" cy="${cy}" r="5" fill="${LOOKS[k].colour}"/>`,
    );
    text(cx - 82, cy - 30, `+${band}`, 'text-anchor="end" fill="#777"');
    text(cx + 82, cy - 30, `−${band} counts`, 'fill="#777"');
    const counts = Math.abs(one.error_counts.at(-1)).toFixed(0);
    text(
      cx,
      cy + 24,
      `${laws[k]}: ends ${counts} counts off`,
      `text-anchor="middle" font-weight="bold" fill="${LOOKS[k].colour}"`,
    );
  });
  text(700, HEIGHT - 8, note, 'text-anchor="middle" font-size="11" fill="#555"');
  const dur = (end / (1 - PAUSE)).toFixed(1);
  const away = `transform:translateX(${RIGHT - LEFT}px)`;
  const still = `${(100 * (1 - PAUSE)).toFixed(0)}%`;
  const css =
    `@keyframes s{0%{transform:translateX(0)}${still},100%{${away}}}` +
    `${keyframes.join('')}.cover{${away};animation:s ${dur}s linear infinite}` +
    '@media(prefers-reduced-motion:reduce){.cover,.needle{animation:none!important}}';
  return (
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" ` +
    `width="${WIDTH}" height="${HEIGHT}"><title>${title}. ` +
    `${note}</title><style>${css}</style><rect width="${WIDTH}" height="${HEIGHT}" ` +
    `fill="#fff"/><g font-family="sans-serif" font-size="12" ` +
    `fill="#222">\n${parts.join('\n')}\n</g></svg>\n`
  );
}
