// What the studio costs while it runs: processor time and memory of the server, and what the page
// loses and draws, with a simulated harmonic drive at 1 kHz that moves every four seconds. It fails
// if a bound below does not hold.
//
//   node test/throughput.mjs STICTION CHROMIUM [MINUTES]
//
// `cargo xtask studio --throughput [MINUTES]` runs it, on Linux: it reads /proc. The figures are
// those of docs/how-to/studio.md.

import { execFileSync } from 'node:child_process';
import { appendFileSync, readFileSync } from 'node:fs';
import { file, launch, open, serve, state, text } from './studio.mjs';

const [program, browserName, minutes = '10'] = process.argv.slice(2);
const [PATIENCE, EVERY_MS, MINUTE_MS] = [30_000, 4000, 60_000];
const DEG = 5;
// Of a core, and of the memory that the server has after the first minute.
const [MOST_OF_A_CORE, MOST_GROWTH] = [0.5, 0.1];
const TICKS_A_SECOND = Number(execFileSync('getconf', ['CLK_TCK'], { encoding: 'utf8' }));

// Processor time that a process has taken, s, and the memory that it has, MB.
function taken(pid) {
  const stat = readFileSync(`/proc/${pid}/stat`, 'utf8');
  const [user, system] = stat
    .slice(stat.lastIndexOf(')') + 2)
    .split(' ')
    .slice(11, 13);
  const [, kb] = readFileSync(`/proc/${pid}/status`, 'utf8').match(/VmRSS:\s+(\d+) kB/);
  return { cpu: (Number(user) + Number(system)) / TICKS_A_SECOND, mb: Number(kb) / 1024 };
}

// Growth is seen after the first.
if (!(Number(minutes) >= 2)) throw new Error(`${minutes}: allowed are two minutes or more`);
const path = file('harmonic.toml');
execFileSync(program, ['new', '--typical', 'harmonic', path]);
// A browser on a busy machine may be silent for longer than the default.
appendFileSync(path, '\n[limits]\nlink_timeout_s = 5\n');
const { server, address } = serve(program, path);
const browser = await launch(browserName);
try {
  const context = await browser.newContext({ viewport: { width: 1200, height: 780 } });
  const page = await open(context, await address, { patience: PATIENCE });
  await state(page, 'stopped');
  await page.locator('#arm').click();
  await state(page, 'armed');
  const begin = Date.now();
  const before = taken(server.pid);
  let [sign, next, first] = [1, MINUTE_MS, null];
  const wrong = new Set();
  while (Date.now() - begin < Number(minutes) * MINUTE_MS) {
    await page.locator('#deg').fill(String(sign * DEG));
    await page.locator('#deg').press('Enter');
    sign = -sign;
    await page.waitForTimeout(EVERY_MS);
    const passed = Date.now() - begin;
    if (passed < next) continue;
    next += MINUTE_MS;
    const now = taken(server.pid);
    first ??= now;
    const share = (now.cpu - before.cpu) / (passed / 1000);
    const [samples, drawn] = [await text(page, '#samples'), await text(page, '#drawn')];
    console.log(
      `${(passed / 1000).toFixed(0)} s: server ${(100 * share).toFixed(1)} % of a core, ` +
        `${now.mb.toFixed(1)} MB; page: ${samples}, ${drawn}`,
    );
    if (!(await page.locator('#state.armed').isVisible())) wrong.add(await text(page, '#state'));
    if (share > MOST_OF_A_CORE) wrong.add('the server takes more than half a core');
    if (now.mb > (1 + MOST_GROWTH) * first.mb) wrong.add('its memory grows by more than 10 %');
    if (!/^[1-9]\d* samples, none lost$/.test(samples)) wrong.add(`samples are lost: ${samples}`);
  }
  if (first === null) wrong.add('nothing was measured');
  await page.locator('#stop').click();
  for (const mistake of page.mistakes) wrong.add(mistake);
  if (wrong.size) throw new Error([...wrong].join('\n'));
  console.log('server and page hold their bounds');
} finally {
  await browser.close();
  server.kill();
}
