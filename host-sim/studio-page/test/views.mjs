// Tests of the views that predict, compare and guide, and of what stands between a click and a real
// motor.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { moreSamples } from './studio.mjs';

// Five minutes at 1 kHz, and how long the page may be busy with them without a pause.
const ROWS = 300_000;
const MOST_BUSY_MS = 250;

// A session with a number of samples.
function long(session) {
  const lines = readFileSync(session, 'utf8').trim().split('\n');
  const { samples } = JSON.parse(lines.at(-1));
  const [, , ...values] = samples.at(-1);
  const all = [lines[0]];
  for (let row = 0; row < ROWS; row += 200)
    all.push(
      JSON.stringify({
        samples: Array.from({ length: 200 }, (_, i) => [row + i, row + i, ...values]),
      }),
    );
  const file = `${session}-long.jsonl`;
  writeFileSync(file, all.join('\n') + '\n');
  return file;
}

export const views = ({ state, text, said, visit, command }) => ({
  async 'a slider changes what is predicted, and nothing else'(page) {
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#deg').fill('3');
    await page.locator('#deg').press('Enter');
    await moreSamples(page, 125);
    await page.locator('[data-view=what-if]').click();
    const rest = page.locator('#what-if-table tr').nth(1).locator('td').nth(1);
    await rest.waitFor();
    // The last move was made by a simulated joint, so it was as it is predicted.
    await page.locator('.legend', { hasText: 'measured' }).waitFor();
    await page.locator('.legend', { hasText: 'joints around it' }).waitFor();
    const around = await text(page, '#what-if-cloud-said');
    assert.match(around, /of 24 joints .* one is assumed\. The worst has/);
    assert.match(await text(page, '#what-if-file'), /^joint\.toml$/);
    const before = await rest.innerText();
    const slider = page.locator('[id="knob-inertia"]');
    await slider.fill('800');
    await page.waitForFunction(
      (was) =>
        document.querySelector('#what-if-table tr:nth-child(2) td:nth-child(2)').textContent !==
        was,
      before,
    );
    // Space stops also from a slider.
    await slider.focus();
    await page.keyboard.press(' ');
    await state(page, 'stopped');
    assert.ok(await page.locator('#what-if-set').isDisabled(), 'the joint is no gain');
    const gain = page.locator('[id="knob-controller.srnf.kp_v_per_deg"]');
    await gain.fill('600');
    await page.locator('#what-if-set:enabled').waitFor();
    await gain.dblclick();
    await page.locator('#what-if-set:disabled').waitFor();
    await page.locator('#what-if-laws label', { hasText: /^ ?pd$/ }).click();
    await page.locator('#what-if-table td', { hasText: /^pd$/ }).waitFor();
    // PD asks for less than the friction, so the joint sticks while the set point goes 50 counts.
    await page.locator('#what-if-way').selectOption('ramp');
    await page.locator('#what-if-deg').fill('10');
    await page.locator('#what-if-table th', { hasText: 'Largest error, counts' }).waitFor();
    const pd = page.locator('#what-if-table tr', { hasText: /^pd/ }).locator('td').nth(1);
    await pd.filter({ hasText: /^50$/ }).waitFor();
    await page.locator('#what-if-way').selectOption('last');
    await page.locator('#what-if-reset').click();
  },

  async 'gains that were tried are set on the device, and taken back'(page) {
    // What was typed elsewhere, and the joint that was turned, stay.
    await page.locator('[data-view=parameters]').click();
    await page.locator('[data-path="limits.stall_s"] input').fill('0.5625');
    await page.locator('[data-view=what-if]').click();
    await page.locator('[id="knob-inertia"]').fill('800');
    await page.locator('[id="knob-controller.srnf.kp_v_per_deg"]').fill('600');
    await page.locator('#what-if-set').click();
    await said(page, 'controller.srnf.kp_v_per_deg: 1.0 ->');
    await page.locator('#what-if-set:disabled').waitFor();
    assert.equal(await page.locator('[id="knob-inertia"]').inputValue(), '800');
    await page.locator('#what-if-reset').click();
    assert.equal(await page.locator('[id="knob-inertia"]').inputValue(), '500');
    await page.locator('[data-view=parameters]').click();
    const typed = page.locator('[data-path="limits.stall_s"].edited input');
    assert.equal(await typed.inputValue(), '0.5625');
    await page.locator('#discard').click();
    await page
      .locator('[data-path="controller.srnf.kp_v_per_deg"].unsaved')
      .waitFor({ state: 'attached' });
    await page.locator('#undo').click();
    await page
      .locator('[data-path="controller.srnf.kp_v_per_deg"]:not(.unsaved)')
      .waitFor({ state: 'attached' });
    await page.locator('[data-view=live]').click();
  },

  async 'a reader is predicted to'(page, context, address) {
    const other = await visit(context, address);
    await other.locator('#role').waitFor();
    await other.locator('[data-view=what-if]').click();
    await other.locator('#what-if-table td').first().waitFor();
    assert.ok(await other.locator('#what-if-set').isDisabled());
    await other.close();
  },

  async 'what is in use is compared with a file'(page) {
    await page.locator('[data-view=parameters]').click();
    const [file] = await Promise.all([
      page.waitForEvent('download'),
      page.locator('#pull').click(),
    ]);
    const stream = await file.createReadStream();
    let toml = '';
    for await (const piece of stream) toml += piece;
    const with_ = (buffer) =>
      page
        .locator('#compare')
        .setInputFiles({ name: 'a.toml', mimeType: 'text/plain', buffer: Buffer.from(buffer) });
    await with_(toml);
    await page.locator('#comparison', { hasText: 'Nothing differs from a.toml' }).waitFor();
    const changed = toml.replace(/^stall_s = .*$/m, 'stall_s = 0.625');
    assert.notEqual(changed, toml);
    await with_(changed);
    await page.locator('#comparison', { hasText: '1 value differs from a.toml' }).waitFor();
    const row = page.locator('[data-path="limits.stall_s"].differs');
    assert.match(await row.innerText(), /a\.toml has 0\.625/);
    await with_('no file');
    await said(page, 'line 1');
    // The server would cut the connection for it.
    for (const many of [65 * 1024, 40 * 1024]) {
      await with_('"'.repeat(many));
      await said(page, 'at most 64');
    }
    assert.equal(await page.locator('#said li', { hasText: 'at most 64' }).count(), 2);
    await with_(toml);
    await page.locator('#comparison', { hasText: 'Nothing differs from a.toml' }).waitFor();
    assert.equal(await page.locator('#said li', { hasText: 'the connection to' }).count(), 0);
    await page.locator('#compare-not').click();
    await page.locator('[data-view=live]').click();
  },

  async 'boxes and files are reached and used without a mouse'(page) {
    await page.locator('[data-view=parameters]').click();
    const box = page.locator('#only-changed');
    await box.focus();
    await page.keyboard.press('Enter');
    assert.ok(await box.isChecked());
    // Space stops, here too.
    await page.locator('#said li').first().waitFor();
    // The list of messages has a limit, so its length does not show a new one.
    await page.evaluate(() => (document.querySelector('#said li').dataset.before = ''));
    await page.keyboard.press(' ');
    await page
      .locator('#said li:first-child:not([data-before])', { hasText: 'the motor is off' })
      .waitFor();
    assert.ok(await box.isChecked());
    await page.keyboard.press('Enter');
    assert.ok(!(await box.isChecked()));
    await page.locator('#pull').focus();
    await page.keyboard.press('Tab');
    assert.equal(await page.evaluate(() => document.activeElement.id), 'push');
    const chosen = page.waitForEvent('filechooser');
    // The browser answers after it has registered that the test replaces its dialog.
    await page.evaluate(() => 0);
    await page.keyboard.press('Enter');
    assert.equal(await (await chosen).element().getAttribute('id'), 'push');
    await page.locator('[data-view=live]').click();
  },

  async 'a connection that was cut for a while leaves a gap that is counted'(
    page,
    context,
    address,
  ) {
    const other = await context.newPage();
    const ways = [];
    await other.routeWebSocket(/\/link/, (near) => {
      near.connectToServer();
      ways.push(near);
    });
    await visit(context, address, other);
    await other.locator('#samples', { hasText: /^[1-9]\d+ samples, none lost$/ }).waitFor();
    await ways[0].close();
    await other.locator('#banner', { hasText: 'NO CONNECTION' }).waitFor();
    await other.locator('#samples', { hasText: /lost in 1 gap$/ }).waitFor();
    const lost = Number(/, (\d+) lost/.exec(await text(other, '#samples'))[1]);
    // The page tries again after a second, and a tick takes 20 ms.
    assert.ok(lost > 40 && lost < 400, `${lost}`);
    assert.equal(ways.length, 2);
    await other.close();
  },

  async 'a trajectory is followed, and refused where the device refuses it'(page) {
    await page.locator('summary', { hasText: 'Trajectory' }).click();
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#trapezoid-speed').fill('0');
    await page.locator('#trapezoid button').click();
    await said(page, 'the speed must be');
    await page.locator('#trapezoid-speed').fill('10');
    await page.locator('#trapezoid button').click();
    await said(page, 'follows the trajectory');
    await page
      .locator('#now dd', { hasText: /^9\.\d+ deg$|^10\.\d+ deg$/ })
      .first()
      .waitFor();
    await page.locator('#stop').click();
    await state(page, 'stopped');
  },

  async 'each step of the commissioning has its text and its picture'(page) {
    await page.locator('[data-view=commissioning]').click();
    const commandOf = async (step) => {
      await page.locator('#steps button', { hasText: step }).click();
      return text(page, '#step-command-text');
    };
    const titles = await page.locator('#steps button').allInnerTexts();
    assert.equal(titles.length, 7);
    for (const [place] of titles.entries()) {
      await page.locator('#steps button').nth(place).click();
      assert.equal(await page.locator('#step-picture svg').count(), 1);
      assert.ok((await text(page, '#step-text')).length > 80);
    }
    await page.locator('#steps button', { hasText: 'Verify' }).click();
    // The self-test judges by the joint that was found, whose file the step before has written.
    const tune = await commandOf('Tune');
    const written = / --out (\S+)$/.exec(tune)[1];
    assert.match(await commandOf('Verify'), new RegExp(`--machine ${written} selftest$`));
    // A button that can do nothing says why.
    await page.locator('#steps button', { hasText: 'Direction' }).click();
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#step-buttons button:disabled').waitFor();
    assert.match(await text(page, '#step-why'), /^Jog: the motor is driven/);
    await page.locator('#stop').click();
    await state(page, 'stopped');
    await page.locator('#step-buttons button:enabled').waitFor();
    assert.equal(await text(page, '#step-why'), '');
    await page.locator('#step-buttons button', { hasText: 'Jog' }).click();
    await said(page, 'jogs: a little each way');
    await said(page, 'the encoder counts in the sense');
    // This joint has no stop.
    await page.locator('summary', { hasText: 'First motion' }).click();
    await page.locator('#home-travel').fill('1');
    await page.locator('#home button').click();
    await said(page, 'goes to its hard stop, twice');
    await said(page, 'no stop within the travel');
    await page.locator('#home-effort').fill('much');
    await page.locator('#home button').click();
    await said(page, '`much` is not a number');
    for (const field of ['#home-travel', '#home-effort']) await page.locator(field).fill('');
    await page.locator('summary', { hasText: 'First motion' }).click();
    await page.locator('#steps button', { hasText: 'Limits' }).click();
    await page.locator('#step-buttons button').click();
    await page.locator('[data-path="limits.stall_s"]').waitFor();
    await page.locator('#search').fill('');
    await page.locator('[data-view=live]').click();
  },

  async 'a real motor is turned on after a word was typed only'(page, context, address) {
    const board = await context.newPage();
    // The same device, reported as a board without a file of its joint.
    const NO_FILE = { machine: null, knobs: [], laws: [], why: 'the joint is not known' };
    const changed = (text) => {
      const event = JSON.parse(text);
      if (event.event === 'hello') event.kind = 'board';
      return JSON.stringify(event.event === 'what-if' ? { ...event, ...NO_FILE } : event);
    };
    await board.routeWebSocket(/\/link/, (near) => {
      const far = near.connectToServer();
      far.onMessage((message) =>
        near.send(typeof message === 'string' ? changed(message) : message),
      );
    });
    // The page that commanded so far gives way.
    await page.close();
    await visit(context, address, board);
    await command(board);
    assert.match(await text(board, '#banner'), /A REAL MOTOR\s*it is off/);
    await board.locator('[data-view=what-if]').click();
    await board.locator('#what-if-said', { hasText: 'the joint is not known' }).waitFor();
    assert.equal(await text(board, '#what-if-file'), 'no file');
    assert.equal(await board.locator('#knobs input, #what-if-table td').count(), 0);
    await board.locator('[data-view=live]').click();
    for (const word of ['', 'yes']) {
      await board.locator('#arm').click();
      await board.locator('#confirm-word').fill(word);
      await board.locator('#confirm-word').press('Enter');
      await moreSamples(board, 20);
      await state(board, 'stopped');
    }
    await board.locator('#confirm-word').press('Escape');
    await board.locator('#confirm').waitFor({ state: 'hidden' });
    await board.locator('summary', { hasText: 'First motion' }).click();
    await board.locator('#actions .jog').click();
    await board.locator('#confirm', { hasText: 'A jog pushes' }).waitFor();
    await board.locator('#confirm-not').click();
    await board.locator('#arm').click();
    await board.locator('#confirm-word').fill('arm');
    await board.locator('#confirm-word').press('Enter');
    await state(board, 'armed');
    assert.match(await text(board, '#banner'), /A REAL MOTOR IS DRIVEN/);
    // A recording that is opened hides nothing of that, and a long one takes nothing from it.
    await board.locator('[data-view=session]').click();
    const [kept] = await Promise.all([
      board.waitForEvent('download'),
      board.locator('#keep').click(),
    ]);
    await board.evaluate(() => {
      window.longest = 0;
      new PerformanceObserver((all) => {
        for (const { duration } of all.getEntries())
          window.longest = Math.max(window.longest, duration);
      }).observe({ type: 'longtask' });
    });
    await board.locator('#open').setInputFiles(long(await kept.path()));
    await board.locator('#banner', { hasText: 'A RECORDING IS SHOWN' }).waitFor();
    assert.match(await text(board, '#banner'), /A REAL MOTOR IS DRIVEN/);
    assert.equal(await board.locator('#banner').getAttribute('class'), 'driven');
    await board.locator('[data-view=session]').click();
    for (const id of ['#keep', '#csv', '#mcap'])
      await Promise.all([board.waitForEvent('download'), board.locator(id).click()]);
    // So long at most the page gave no word.
    const longest = await board.evaluate(() => window.longest);
    assert.ok(longest < MOST_BUSY_MS, `${longest} ms`);
    await state(board, 'armed');
    await board.keyboard.press('Escape');
    await state(board, 'stopped');
    assert.match(await text(board, '#banner'), /it is off.* A RECORDING IS SHOWN/);
    await board.locator('#back').click();
    await board.locator('#banner-more', { hasText: /holds the joint$/ }).waitFor();
    await board.close();
  },
});
