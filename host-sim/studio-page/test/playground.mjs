// Drives the playground in a headless Chromium, opened as a file, beside the studio of the program:
// both must show the same for the same joint.
//
//   node test/playground.mjs STICTION CHROMIUM DIRECTORY [--pictures DIRECTORY]

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { after, file, launch, moreSamples, open, serve, state, text, runTest } from './studio.mjs';

const [program, browserName, directory, ...options] = process.argv.slice(2);
const pictures = after(options, '--pictures');
const address = pathToFileURL(join(resolve(directory), 'index.html')).href;
const PATIENCE = 30_000;

// A file of the user.
const gimbal = file('gimbal.toml');
execFileSync(program, ['new', '--typical', 'gimbal', gimbal]);

// Records the messages from and to a page, on any wire, with the time.
function recorded() {
  globalThis.heard = [];
  const keep = (way, data) => {
    if (typeof data === 'string') globalThis.heard.push({ at: performance.now(), way, data });
  };
  for (const [kind, method] of [
    [Worker, 'postMessage'],
    [WebSocket, 'send'],
  ]) {
    const send = kind.prototype[method];
    kind.prototype[method] = function (data, ...more) {
      keep('asked', data);
      return send.call(this, data, ...more);
    };
    const place = Object.getOwnPropertyDescriptor(kind.prototype, 'onmessage');
    Object.defineProperty(kind.prototype, 'onmessage', {
      ...place,
      set(listener) {
        place.set.call(this, (event) => {
          keep('received', event.data);
          listener(event);
        });
      },
    });
  }
}

async function visit(context, url) {
  const page = await context.newPage();
  page.asked = [];
  page.on('request', (request) => page.asked.push(request.url()));
  await page.addInitScript(recorded);
  // Nothing is to be written at all.
  page.on('console', (one) => one.type() !== 'error' && page.mistakes.push(one.text()));
  await open(context, url, { page, patience: PATIENCE });
  await page.locator('#state.stopped').waitFor();
  return page;
}

// The last prediction of the laws and of the cloud, once both are complete.
async function predicted(page) {
  await page.waitForFunction(() => {
    const all = globalThis.heard.map(({ data }) => JSON.parse(data));
    const asked = all.filter((one) => one.do === 'predict').at(-1);
    const parts = all.filter((one) => one.event === 'predicted' && one.id === asked?.id);
    return parts.some(({ part }) => part === 'cloud');
  });
  // The page may have asked anew with the answer.
  await page.waitForTimeout(1500);
  return page.evaluate(() => {
    const all = globalThis.heard.map(({ at, data }) => ({ at, ...JSON.parse(data) }));
    const asked = all.filter((one) => one.do === 'predict').at(-1);
    const parts = all.filter((one) => one.event === 'predicted' && one.id === asked.id);
    const of = (part) => parts.find((one) => one.part === part);
    return {
      wish: asked.wish,
      laws: of('laws').content,
      cloud: of('cloud').content,
      took: [of('laws').at - asked.at, of('cloud').at - of('laws').at],
    };
  });
}

async function turn(page, path, place) {
  await page.locator(`[id="knob-${path}"]`).evaluate((slider, value) => {
    slider.value = value;
    slider.dispatchEvent(new Event('input'));
  }, String(place));
}

// Every law, a step or a move, one gain and one part of the joint turned.
async function turned(page, way) {
  await page.locator('[data-view=what-if]').click();
  await page.locator('#what-if-way').selectOption(way);
  for (const box of await page.locator('#what-if-laws input').all()) await box.check();
  await page
    .locator('#knobs details')
    .evaluateAll((all) => all.forEach((one) => (one.open = true)));
  await turn(page, 'inertia', 620);
  await turn(page, 'joint.friction.stick_v', 540);
  await turn(page, 'controller.pd.kp_v_per_deg', 450);
  return predicted(page);
}

// The samples of a move of 5 deg, each term of each, from the tick in which the set point sets out.
async function moved(page) {
  await page.locator('[data-view=live]').click();
  await page.locator('#arm').click();
  await state(page, 'armed');
  // Its soft start is over.
  await moreSamples(page, 150);
  await page.locator('#deg').fill('5');
  await page.locator('#deg').press('Enter');
  await moreSamples(page, 200);
  await page.locator('#stop').click();
  await state(page, 'stopped');
  await page.locator('[data-view=session]').click();
  const [file] = await Promise.all([page.waitForEvent('download'), page.locator('#keep').click()]);
  const lines = readFileSync(await file.path(), 'utf8')
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));
  const names = lines[0].hello.signals.map(({ name }) => name);
  const samples = lines.flatMap(({ samples }) => samples ?? []);
  assert.ok(
    samples.every(([number], k) => k === 0 || number === samples[k - 1][0] + 1),
    'a gap',
  );
  const [place, fraction] = ['reference_counts', 'reference_fraction_counts'].map((name) => {
    assert.ok(names.includes(name), name);
    return 2 + names.indexOf(name);
  });
  const begin = samples.findIndex((one) => one[place] !== 0 || one[fraction] !== 0);
  const rows = samples.slice(begin, begin + Math.round(3 / lines[0].hello.sample_time_s));
  return { names, rows: rows.map((row) => row.slice(2)) };
}

const own = async (page, file) => {
  await Promise.all([
    page.waitForEvent('load'),
    page.locator('#playground-file').setInputFiles(file),
  ]);
};

// A worker that ends, a way to trap in the middle, and a page that cannot unpack the simulator.
const ENDED = /the simulation has ended: .*Reload the page/;

const tests = {
  async 'it opens as a file, asks no server, and says that there is no motor'(page) {
    assert.match(await text(page, '#banner'), /A SIMULATION IN THIS PAGE\s*no motor/);
    await page.locator('#what-if-table td').first().waitFor();
    const others = page.asked.filter((url) => !/^(file|blob|data):/.test(url));
    assert.deepEqual(others, []);
  },

  async 'a slider changes the curve'(page) {
    const before = await predicted(page);
    await turn(page, 'joint.friction.stick_v', 700);
    const after = await predicted(page);
    assert.notDeepEqual(after.laws[0].position_deg, before.laws[0].position_deg);
    await page.locator('#what-if-reset').click();
    assert.deepEqual((await predicted(page)).laws, before.laws);
  },

  async 'a joint is armed, moved, stopped, and changed'(page) {
    await page.locator('[data-view=live]').click();
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#deg').fill('5');
    await page.locator('#deg').press('Enter');
    await page
      .locator('#now dd', { hasText: /^(4\.99|5\.00)\d deg$/ })
      .first()
      .waitFor();
    assert.match(await text(page, '#samples'), /^\d+ samples, none lost$/);
    await page.keyboard.press('Escape');
    await state(page, 'stopped');
    await page.locator('[data-view=parameters]').click();
    const row = page.locator('[data-path="limits.stall_s"]');
    await row.locator('input').fill('-1');
    await page.locator('#set').click();
    await page.locator('.parameter.refused').waitFor();
    await row.locator('input').fill('0.75');
    await page.locator('#set').click();
    await page.locator('[data-path="limits.stall_s"].unsaved:not(.edited)').waitFor();
    await page.locator('#undo').click();
    await page.locator('[data-path="limits.stall_s"]:not(.unsaved)').waitFor();
  },

  async 'the end of a simulation is reported, and it does not restart'(page, context) {
    const other = await context.newPage();
    other.setDefaultTimeout(PATIENCE);
    // A trap: for the page it is like any other error of the worker.
    await other.addInitScript(() => {
      const own = globalThis.Worker;
      globalThis.begun = 0;
      globalThis.Worker = class extends own {
        constructor(...all) {
          super(...all);
          globalThis.begun++;
          globalThis.trap = () => this.onerror(new ErrorEvent('error', { message: 'unreachable' }));
        }
      };
    });
    // The `#` part is not a valid address.
    await other.goto(`${address}#%E0%A4%A`);
    await state(other, 'stopped');
    await other.evaluate(() => globalThis.trap());
    await other.locator('#playground-said', { hasText: ENDED }).waitFor();
    assert.match(await text(other, '#banner'), ENDED);
    assert.ok(await other.locator('#arm').isDisabled());
    await other.keyboard.press('Escape');
    await other.locator('#said li', { hasText: 'there is no connection' }).waitFor();
    await other.waitForTimeout(1500);
    assert.equal(await other.evaluate(() => globalThis.begun), 1);
    await other.close();
    const broken = await context.newPage();
    broken.setDefaultTimeout(PATIENCE);
    await broken.addInitScript(() => delete globalThis.DecompressionStream);
    await broken.goto(address);
    await broken.locator('#playground-said', { hasText: ENDED }).waitFor();
    await broken.close();
    assert.match(await text(page, '#banner'), /no motor/);
  },

  async 'a file that is wrong is refused with the reason, and the joint in use stays'(page) {
    const wrong = `${gimbal}.toml`;
    writeFileSync(wrong, readFileSync(gimbal, 'utf8').replace('ratio =', 'ration ='));
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#playground-file').setInputFiles(wrong);
    await page.locator('#playground-said', { hasText: 'ration' }).waitFor();
    // The joint is the same one, armed as before, and still obeys.
    await state(page, 'armed');
    await page.locator('#stop').click();
    await state(page, 'stopped');
    assert.match(await text(page, '#banner'), /no motor/);
    await Promise.all([
      page.waitForEvent('load'),
      page.locator('#playground-joint').selectOption('harmonic'),
    ]);
    await state(page, 'stopped');
    assert.match(await text(page, '#what-if-file'), /harmonic/);
  },
};

// The same of a joint, in the page and by the program.
async function alike(context, page, machine) {
  const { server, address } = serve(program, machine);
  try {
    const other = await visit(context, await address);
    for (const way of ['move', 'step']) {
      const [here, there] = [await turned(page, way), await turned(other, way)];
      assert.deepEqual(here.wish, there.wish);
      assert.deepEqual(here.laws, there.laws);
      assert.deepEqual(here.cloud, there.cloud);
      const ms = (times) => times.map((time) => `${time.toFixed(0)} ms`).join(' and ');
      console.log(
        `        ${way}, ${here.laws.length} laws and a cloud of ${here.cloud.curves.length}: ` +
          `${ms(here.took)}; by the program ${ms(there.took)}`,
      );
    }
    const [here, there] = [await moved(page), await moved(other)];
    assert.deepEqual(here.names, there.names);
    assert.ok(here.rows.length > 100 && new Set(here.rows.flat()).size > 100);
    const numbers = here.rows.length * here.names.length;
    const differ = here.names.filter((_, k) =>
      here.rows.some((row, tick) => !Object.is(row[k], there.rows[tick]?.[k])),
    );
    console.log(`        a move: ${numbers} numbers of ${here.rows.length} ticks`);
    assert.deepEqual(differ, [], 'terms that differ');
    assert.deepEqual([...page.mistakes, ...other.mistakes], []);
    await other.close();
  } finally {
    server.kill();
  }
}

async function take(browser) {
  mkdirSync(pictures, { recursive: true });
  for (const width of [1200, 390]) {
    for (const colorScheme of ['light', 'dark']) {
      const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme });
      const page = await visit(context, address);
      await predicted(page);
      const shoot = (name) =>
        page.screenshot({
          path: join(pictures, `${name}-${width}-${colorScheme}.png`),
          fullPage: true,
        });
      await shoot('what-if');
      await page.locator('[data-view=live]').click();
      await page.locator('#arm').click();
      await state(page, 'armed');
      await page.locator('#deg').press('Enter');
      await page.waitForTimeout(4000);
      await shoot('live');
      await context.close();
    }
  }
}

const browser = await launch(browserName);
let failed = 0;
const run = async (name, test) => {
  failed += (await runTest(name, test)) ? 0 : 1;
};
try {
  if (pictures) await take(browser);
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
  const page = await visit(context, address);
  for (const [name, test] of Object.entries(tests))
    await run(name, async () => {
      await test(page, context);
      assert.deepEqual(page.mistakes, []);
    });
  await page.close();
  await run('the axis of the thesis gives the same messages as in the program', async () =>
    alike(context, await visit(context, `${address}#step-response/what-if`), 'step-response'),
  );
  await run('a file of the user gives the same messages as in the program', async () => {
    const other = await visit(context, address);
    await own(other, gimbal);
    await state(other, 'stopped');
    await alike(context, other, gimbal);
  });
} finally {
  await browser.close();
}
console.log(failed ? `${failed} failed` : 'all passed');
process.exit(failed ? 1 : 0);
