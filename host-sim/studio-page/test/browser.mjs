// Drives the page in a headless Chromium, against the simulated device.
//
//   node test/browser.mjs STICTION CHROMIUM [--image ELF] [--pictures DIRECTORY] [--dist]
//
// With --image it also drives the flash image on the emulated microcontroller. With --pictures it
// also writes one picture of every view in both themes. With --dist it takes the files of the page
// from dist/, so that an edit of the page needs no build of the program.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { appendFileSync, mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { McapStreamReader } from '@mcap/core';
import { begins, commissioning, isFound } from './commissioning.mjs';
import { current } from './current.mjs';
import { emulated } from './emulated.mjs';
import { beginsGear, gearIsFound } from './gear.mjs';
import { refusedFile } from './refused-file.mjs';
import { results } from './results.mjs';
import { after, file, launch, moreSamples, open, serve, shown, state } from './studio.mjs';
import { runTest, text } from './studio.mjs';
import { typed } from './typed.mjs';
import { unknown } from './unknown.mjs';
import { views } from './views.mjs';

const [program, browserName, ...options] = process.argv.slice(2);
const [pictures, image] = ['--pictures', '--image'].map((name) => after(options, name));
const isDist = options.includes('--dist');
// Ends a test that hangs; nothing else depends on it.
const PATIENCE = 120_000;
const VIEWS = ['live', 'planes', 'parameters', 'what-if', 'commissioning', 'session', 'faults'];
// Longer than the default: a browser on a busy machine may be silent for half a second.
const LINK_TIMEOUT_S = 2;
// Of the thesis's joint.
const SAMPLE_TIME_S = 0.02;

// The thesis's joint, with that timeout.
function machine() {
  const toml = shown(program, 'step-response');
  assert.ok(!toml.includes('[limits]'));
  return file('joint.toml', `${toml}\n[limits]\nlink_timeout_s = ${LINK_TIMEOUT_S}\n`);
}

// A joint whose identification takes two minutes, and not five.
function gimbal() {
  const path = file('gimbal.toml');
  execFileSync(program, ['new', '--typical', 'gimbal', path]);
  // The page of it is in the background, and may be silent for longer.
  appendFileSync(path, '\n[limits]\nlink_timeout_s = 5\n');
  return path;
}

async function visit(context, address, page) {
  const opened = await open(context, address, { page, patience: PATIENCE, isDist });
  await opened.locator('#state.stopped, #state.faulted, #state.armed').waitFor();
  return opened;
}

// Asks until the server has seen that the page that commanded is gone.
async function command(page) {
  for (let tries = 0; tries < 100 && (await page.locator('#role').isVisible()); tries++) {
    await page.locator('#command').click();
    await page.waitForTimeout(100);
  }
  await page.locator('#role').waitFor({ state: 'hidden' });
}

const said = (page, words) => page.locator('#said li', { hasText: words }).first().waitFor();

// A sample has its number and its clock before its values.
const of_session = ({ hello }, sample, signal) =>
  sample[2 + hello.signals.findIndex(({ name }) => name === signal)];

// In their order: the last ones of each close the page.
function parts() {
  const of = { state, text, said, visit, command };
  const [tunes, tests, board] = Object.entries(commissioning(of));
  const parts = [typed, results, unknown, views].flatMap((part) => Object.entries(part(of)));
  return Object.fromEntries([tunes, tests, ...parts, board]);
}

const tests = {
  async 'every view opens, and says that there is no motor'(page) {
    for (const view of VIEWS) {
      await page.locator(`[data-view=${view}]`).click();
      await page.locator(`#${view}`).waitFor();
      assert.match(await text(page, '#banner'), /SIMULATED JOINT\s*simulated: no motor/);
      assert.ok(await page.locator('#stop').isVisible());
    }
    await page.keyboard.press('1');
    assert.equal(
      await page.locator('#plots canvas').count(),
      await page.locator('#plots figure').count(),
    );
    // A screen reader does not repeat a text with every status.
    await page.evaluate(() => {
      globalThis.changes = 0;
      const all = { childList: true, characterData: true, subtree: true };
      new MutationObserver((some) => (globalThis.changes += some.length)).observe(
        document.getElementById('banner'),
        all,
      );
    });
    await moreSamples(page, 50);
    assert.equal(await page.evaluate(() => globalThis.changes), 0);
  },

  async 'a move is made, and its samples arrive complete'(page) {
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#deg').fill('5');
    await page.locator('#deg').press('Enter');
    await page
      .locator('#now dd', { hasText: /^(4\.99|5\.00)\d deg$/ })
      .first()
      .waitFor();
    await moreSamples(page, 50);
    assert.match(await text(page, '#samples'), /^\d+ samples, none lost$/);
    await page.locator('#drawn', { hasText: /^drawn [1-9]\d* times a second$/ }).waitFor();
    // At rest, a rounding is shown as zero.
    assert.doesNotMatch(await text(page, '#now'), /e-/);
  },

  async 'Escape and Space stop it'(page) {
    await page.locator('#deg').focus();
    await page.keyboard.press('Escape');
    await state(page, 'stopped');
    await page.locator('#arm').click();
    await state(page, 'armed');
    // The button that was pressed last has the focus, and must not be pressed by Space.
    await page.keyboard.press(' ');
    await state(page, 'stopped');
    // As under Caps Lock.
    await page.keyboard.press('A');
    await state(page, 'armed');
    await page.locator('#span').focus();
    await page.keyboard.press(' ');
    await state(page, 'stopped');
    assert.equal(await page.locator('#span').inputValue(), '10');
    await page.locator('#span').blur();
  },

  async 'what the device refuses is said'(page) {
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#deg').fill('1e300');
    await page.locator('#deg').press('Enter');
    await said(page, 'it must be -360 to 360 deg');
    await page.locator('#deg').fill('five');
    await page.locator('#deg').press('Enter');
    await said(page, '`five` is not a number');
    await page.locator('#stop').click();
    await state(page, 'stopped');
  },

  async 'the form refuses what the device refuses, and marks what is changed'(page) {
    await page.locator('[data-view=parameters]').click();
    await page.locator('#search').fill('stall_s');
    const row = page.locator('[data-path="limits.stall_s"]');
    await row.locator('input').fill('-1');
    await page.locator('#set').click();
    await page.locator('.parameter.refused').waitFor();
    assert.match(await text(page, '#parameters-said'), /limits\.stall_s/);
    await row.locator('input').fill('0.75');
    const seen = () => page.locator('.parameter:visible').count();
    const found = await seen();
    await row.locator('input').press('Enter');
    await page.locator('[data-path="limits.stall_s"].unsaved:not(.edited)').waitFor();
    // Focus and search stay where they were.
    assert.equal(await page.evaluate(() => document.activeElement.id), 'p-limits.stall_s');
    assert.equal(await seen(), found);
    await page.locator('#undo').click();
    await page.locator('[data-path="limits.stall_s"]:not(.unsaved)').waitFor();
    assert.equal(await seen(), found);
    await page.locator('#search').fill('');
    await page.locator('[data-view=live]').click();
  },

  async 'a session is kept, opened without a device, and exported'(page) {
    await page.locator('[data-view=session]').click();
    const load = async (id) => {
      const [file] = await Promise.all([page.waitForEvent('download'), page.locator(id).click()]);
      return file.path();
    };
    const session = await load('#keep');
    const lines = readFileSync(session, 'utf8')
      .trim()
      .split('\n')
      .map((line) => JSON.parse(line));
    assert.equal(lines[0].stiction_session, 1);
    const kept = lines.flatMap(({ samples }) => samples ?? []);
    // The numbers begin anew when parameters were set, and miss none otherwise.
    assert.ok(
      kept.length > 50 &&
        kept.every(([number], i) => i === 0 || number < 5 || number === kept[i - 1][0] + 1),
    );
    const choose = (name, buffer) =>
      page.locator('#open').setInputFiles({ name, mimeType: 'text/plain', buffer });
    // A file that is not a session, or not whole, leaves the view as it was.
    const whole = readFileSync(session);
    const other = structuredClone(lines[0]);
    other.hello.signals.pop();
    const changed = (change) => {
      const all = structuredClone(lines);
      change(all);
      return Buffer.from(all.map((line) => JSON.stringify(line)).join('\n'));
    };
    for (const [name, wrong, why] of [
      [
        'e.jsonl',
        changed(([head]) => delete head.hello.sample_time_s),
        'does not describe its device',
      ],
      [
        'h.jsonl',
        changed(([head]) => (head.hello.signals[1].form = 'x')),
        'does not describe its device',
      ],
      ['i.jsonl', changed(([head]) => (head.hello.law = 5)), 'does not describe its device'],
      ['j.jsonl', changed((all) => all.push({ samples: 1 })), 'not in the form of the studio'],
      ['k.jsonl', Buffer.from('null'), 'this file is not a session'],
      [
        'l.jsonl',
        changed((all) => (all.find(({ samples }) => samples).samples[3][0] = null)),
        'a value that is not a number',
      ],
      [
        'f.jsonl',
        changed((all) => (all.find(({ samples }) => samples).samples[3][2] = 'far')),
        'a value that is not a number',
      ],
      ['g.jsonl', changed((all) => all.push({ event: { at: 1 } })), 'an event of this session'],
      ['b.jsonl', Buffer.from('{}'), 'this file is not a session'],
      ['c.jsonl', whole.subarray(0, whole.length - 40), 'it was cut off'],
      [
        'd.jsonl',
        Buffer.from([other, ...lines.slice(1)].map((line) => JSON.stringify(line)).join('\n')),
        'other signals',
      ],
    ]) {
      await choose(name, wrong);
      // Others were refused for the same reason before.
      await said(page, new RegExp(`${name}: .*${why}`));
      assert.doesNotMatch(await text(page, '#banner'), /RECORDING/);
      const seen = Number((await text(page, '#samples')).split(' ')[0]);
      assert.ok(seen >= kept.length, `${seen} samples of ${kept.length}`);
    }
    await choose('a.jsonl', whole);
    await page.locator('#banner', { hasText: 'A RECORDING' }).waitFor();
    // A parameter was set in it, so its numbers begin anew in its midst.
    assert.ok(kept.some(([number], i) => i > 0 && number < kept[i - 1][0]));
    // The banner changes at once, the readings in the next picture.
    await page
      .locator('#samples', { hasText: new RegExp(`^${kept.length} samples, none lost$`) })
      .waitFor();
    await page.locator('[data-view=session]').click();
    const about = await text(page, '#recorded-what');
    for (const part of [lines[0].hello.device, lines[0].hello.firmware, lines[0].saved])
      assert.ok(about.includes(part), `${part}: ${about}`);
    assert.equal(await page.locator('#recorded-file').textContent(), lines[0].file);
    const csv = readFileSync(await load('#csv'), 'utf8')
      .trim()
      .split('\n');
    assert.ok(
      csv[0].startsWith('time_s,reference_deg,position_deg,error_deg,') &&
        csv.length === kept.length + 1,
    );
    // A tick without a measurement has empty cells, not zeros.
    const isArmed = (sample) => (of_session(lines[0], sample, 'status') & 0xff) === 2;
    const armed = kept.filter(isArmed);
    assert.ok(armed.length > 0 && armed.length < kept.length);
    const columns = csv[0].split(',').length;
    for (const [place, sample] of kept.entries()) {
      const cells = csv[place + 1].split(',');
      assert.equal(cells.length, columns);
      const full = cells.filter((cell) => cell !== '').length;
      assert.equal(full, isArmed(sample) ? columns : 1, csv[place + 1]);
    }
    const mcap = new McapStreamReader();
    mcap.append(readFileSync(await load('#mcap')));
    const messages = [];
    for (let record; (record = mcap.nextRecord());)
      if (record.type === 'Message')
        messages.push(JSON.parse(new TextDecoder().decode(record.data)));
    assert.ok(mcap.done() && messages.length === armed.length);
    assert.equal(messages.at(-1).counts, of_session(lines[0], armed.at(-1), 'counts'));
    assert.match(readFileSync(await load('#svg'), 'utf8'), /^<svg /);
    assert.equal(
      readFileSync(await load('#png'))
        .subarray(1, 4)
        .toString(),
      'PNG',
    );
    await page.locator('#back').click();
    await page.locator('#recorded').waitFor({ state: 'hidden' });
    await state(page, 'stopped');
    await page.locator('[data-view=live]').click();
    // The device went on meanwhile.
    await page.waitForFunction(
      (least) => parseInt(document.getElementById('samples').textContent) > least,
      kept.length + 10,
    );
    assert.match(await text(page, '#samples'), /^\d+ samples, none lost$/);
  },

  async 'two tabs do not fight, and the second one can stop'(page, context, address) {
    const other = await visit(context, address);
    await other.locator('#role').waitFor();
    assert.match(await text(other, '#role'), /another page commands/);
    assert.ok(await other.locator('#arm').isDisabled());
    await page.locator('#arm').click();
    await state(other, 'armed');
    await other.locator('#stop').click();
    await state(page, 'stopped');
    await other.close();
  },

  ...parts(),

  async 'when the tab is closed, the link timeout turns the output off'(page, context, address) {
    const first = await visit(context, address);
    // The page before it has gone, so the command is free.
    await command(first);
    const other = await visit(context, address);
    await first.locator('#arm').click();
    await state(other, 'armed');
    // It stays on as long as the tab is there.
    await moreSamples(other, (2 * LINK_TIMEOUT_S) / SAMPLE_TIME_S);
    await state(other, 'armed');
    // How soon is a test of the server, on a clock of its own (host-sim/tests/studio/main.rs).
    await first.close();
    await state(other, 'faulted');
    assert.match(await text(other, '#state'), /fault 22/);
    await command(other);
    await other.locator('#clear').click();
    await state(other, 'stopped');
    await other.close();
  },
};

async function take(browser, address) {
  mkdirSync(pictures, { recursive: true });
  for (const [name, viewport] of [
    ['desk', { width: 1360, height: 900 }],
    ['phone', { width: 400, height: 800 }],
  ]) {
    for (const colorScheme of ['light', 'dark']) {
      const context = await browser.newContext({ viewport, colorScheme });
      const page = await visit(context, address);
      const shoot = (view) =>
        page.screenshot({ path: join(pictures, `${name}-${colorScheme}-${view}.png`) });
      await page.locator('#arm').click();
      await state(page, 'armed');
      for (const deg of ['5', '-2.5']) {
        await page.locator('#deg').fill(deg);
        await page.locator('#deg').press('Enter');
        await page.waitForTimeout(2600);
      }
      await page.locator('#deg').blur();
      for (const view of ['live', 'planes', 'what-if', 'commissioning', 'session']) {
        await page.locator(`[data-view=${view}]`).click();
        await page.waitForTimeout(view === 'what-if' ? 2500 : 300);
        await shoot(view);
      }
      await page.locator('#stop').click();
      // A picture may take longer than the link timeout, and the page gives no word meanwhile.
      await page.locator('#state.stopped, #state.faulted').waitFor();
      if (await page.locator('#clear').isEnabled()) await page.locator('#clear').click();
      await state(page, 'stopped');
      await page.locator('[data-view=parameters]').click();
      await page.locator('[data-path="limits.stall_s"] input').fill('0.75');
      await page.locator('#set').click();
      await page.locator('.unsaved').first().waitFor();
      await page.locator('[data-path="limits.stall_s"] input').fill('-1');
      await page.locator('#set').click();
      await page.waitForTimeout(300);
      await shoot('parameters');
      await page.locator('#discard').click();
      await page.locator('#undo').click();
      await page.locator('[data-view=live]').click();
      await page.locator('#arm').click();
      await state(page, 'armed');
      const other = await visit(context, address);
      await page.close();
      await state(other, 'faulted');
      await other.locator('[data-view=faults]').click();
      await other.waitForTimeout(300);
      await other.screenshot({ path: join(pictures, `${name}-${colorScheme}-faults.png`) });
      await command(other);
      await other.locator('#clear').click();
      await state(other, 'stopped');
      await context.close();
    }
  }
}

const joint = [machine(), '--controller', 'srnf'];
const { server, address } = serve(program, ...joint);
// A studio of its own for what takes minutes.
const bench = serve(program, gimbal());
const browser = await launch(browserName, isDist);
let failed = 0;
let gear = null;
try {
  const url = await address;
  const context = await browser.newContext({
    viewport: { width: 1280, height: 800 },
    acceptDownloads: true,
  });
  const other = await visit(context, await bench.address);
  await begins(other);
  gear = await beginsGear(program, context, { patience: PATIENCE, isDist });
  const page = await visit(context, url);
  for (const [name, test] of Object.entries(tests)) {
    const isFine = await runTest(name, async () => {
      await test(page, context, url);
      assert.deepEqual(page.mistakes, []);
    });
    failed += isFine ? 0 : 1;
  }
  const isFine = await runTest('what was identified is tuned and tested with', async () => {
    await isFound(other);
    assert.deepEqual(other.mistakes, []);
  });
  failed += isFine ? 0 : 1;
  const isGearFound = await runTest('the gear of two encoders is measured by moves', async () => {
    await gearIsFound(gear, pictures);
    assert.deepEqual(gear.page.mistakes, []);
  });
  failed += isGearFound ? 0 : 1;
  await gear.page.close();
  const isKept = await runTest('a file that the playground refuses leaves its joint alone', () =>
    refusedFile(context),
  );
  failed += isKept ? 0 : 1;
  const isMeasured = await runTest('the current of the motor is shown with its target', () =>
    current(program, context, { patience: PATIENCE, isDist }),
  );
  failed += isMeasured ? 0 : 1;
  bench.server.kill();
  await other.close();
  if (pictures) await take(browser, url);
  const last = await visit(context, url);
  const ended = new Promise((done) => server.on('exit', done));
  server.kill();
  await ended;
  await last.locator('#banner', { hasText: 'NO CONNECTION' }).waitFor();
  // What was measured last is grey, and named as such.
  await last.locator('.stale #stale').waitFor();
  const opacity = await last.locator('#now').evaluate((now) => getComputedStyle(now).opacity);
  assert.ok(Number(opacity) < 0.6, opacity);
  console.log('ok      a server that is killed is seen');
  await last.close();
  if (image) {
    const part = serve(program, ...joint, '--emulator', '--image', image);
    try {
      await emulated({ state, text, said, visit, command }, context, await part.address);
      console.log('ok      the flash image on the emulated microcontroller is driven');
    } finally {
      part.server.kill();
    }
  } else console.log('NOT RUN the flash image on the emulated microcontroller: no --image');
} catch (error) {
  failed++;
  console.log(`FAILED\n${error.stack}`);
} finally {
  server.kill();
  bench.server.kill();
  gear?.server.kill();
  await browser.close();
}
console.log(failed ? `${failed} failed` : 'all passed');
process.exit(failed ? 1 : 0);
