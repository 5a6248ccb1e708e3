// Tests of what the steps of the commissioning do by themselves: tuning and the self-test.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';

const MOVES = 3;

export const commissioning = ({ state, text, said, visit, command }) => {
  const step = async (page, name) => {
    await page.locator('[data-view=commissioning]').click();
    await page.locator('#steps button', { hasText: name }).click();
  };
  const saved = async (page, id) => {
    const [file] = await Promise.all([page.waitForEvent('download'), page.locator(id).click()]);
    return [file.suggestedFilename(), readFileSync(await file.path(), 'utf8')];
  };
  const predict = async (page, moves) => {
    await step(page, 'Verify');
    await page.locator('#selftest-moves').fill(String(moves));
    await page.locator('#selftest-predict').click();
    // A self-test that was made before could be repeated: the button alone tells nothing.
    await page.locator('#selftest-said', { hasText: `${moves} moves, within` }).waitFor();
    await page.locator('#selftest-go:enabled').waitFor();
  };

  return {
    async 'gains are tuned by a click, cancelled by another, and put into the form'(page) {
      await step(page, 'Tune');
      await page.locator('#tune-law').selectOption('all of the file');
      await page.locator('#tune-start').click();
      await page.locator('#tune-said', { hasText: /law 1 of 7, .* sets of gains tried/ }).waitFor();
      assert.ok(await page.locator('#tune-start').isDisabled(), 'one at a time');
      await page.locator('#tune-cancel').click();
      await page.locator('#tune-said', { hasText: 'cancelled' }).waitFor();
      await page.locator('#tune-law').selectOption('pd');
      await page.locator('#tune-goal').selectOption('settle');
      await page.locator('#tune-start:enabled').click();
      await page.locator('#tune-said', { hasText: 'better gains were found' }).waitFor();
      assert.equal(await page.locator('#tune-result table').count(), 2);
      await page.locator('.pictures summary').click();
      const drawn = () =>
        [...document.querySelectorAll('.pictures img')].filter((one) => one.naturalWidth > 0);
      await page.waitForFunction(`(${drawn})().length === 2`);
      const [name, toml] = await saved(page, '#tune-save');
      assert.equal(name, 'joint.tuned.toml');
      // The device runs another law, so the form has no such gains.
      const put = page.locator('#tune-result [data-law=pd]');
      assert.ok(await put.locator('p').isVisible());
      assert.ok(!(await put.locator('button').isVisible()));
      // The device takes pd of a file, with another gain.
      const [, tuned] = /^kp_v_per_deg = (\S+)/m.exec(toml);
      const buffer = Buffer.from(toml.replace(/^kp_v_per_deg = \S+/m, 'kp_v_per_deg = 1.25'));
      await page.locator('#push').setInputFiles({ name: 'a.toml', mimeType: 'text/plain', buffer });
      await put.locator('button').click();
      const row = page.locator('[data-path="controller.pd.kp_v_per_deg"].edited input');
      assert.equal(Number(await row.inputValue()), Number(tuned));
      // Nothing is set before somebody does.
      await page.locator('#set', { hasText: 'Set 1 value' }).click();
      await said(page, `controller.pd.kp_v_per_deg: 1.25 -> ${tuned}`);
      for (const changes of ['1', '0']) {
        await page.locator('#undo').click();
        await page.waitForFunction(
          (left) => document.querySelector('#undo').dataset.left === left,
          changes,
        );
      }
      await page.locator('[data-view=live]').click();
    },

    async 'a self-test is predicted, made and judged by clicks'(page) {
      await predict(page, MOVES);
      assert.match(
        await text(page, '#selftest-said'),
        /^3 moves, within 3\.2\d* deg to either side/,
      );
      assert.match(await text(page, '#selftest-go'), /^2\. Make the 3 moves$/);
      await state(page, 'stopped');
      await page.locator('#selftest-go').click();
      await page.locator('#selftest-said', { hasText: 'Move 2 of 3' }).waitFor();
      await state(page, 'armed');
      for (const id of ['#hold', '#step', '#selftest-predict', '#selftest-go'])
        assert.ok(await page.locator(id).isDisabled(), id);
      await page.locator('#selftest-said:is(.passed, .doubted)').waitFor();
      await state(page, 'stopped');
      assert.match(await text(page, '#selftest-said'), /pass: the joint does what its file says/);
      const [name, json] = await saved(page, '#selftest-save');
      assert.match(name, /^selftest-.*\.json$/);
      const { schema, verdict, checks, moves } = JSON.parse(json);
      assert.deepEqual([schema, verdict, checks.length, moves.length], [1, 'pass', 8, MOVES]);
      assert.equal(await page.locator('#selftest-result table').first().locator('tr').count(), 9);
      await page.locator('[data-view=live]').click();
    },

    async 'a real motor makes a self-test after the word only, and Escape ends it; a device that is silent is set nothing'(
      page,
      context,
      address,
    ) {
      const board = await context.newPage();
      let [near, isSilent] = [null, false];
      await board.routeWebSocket(/\/link/, (one) => {
        near = one;
        const far = one.connectToServer();
        far.onMessage((message) => {
          if (isSilent) return;
          const isEvent = typeof message === 'string';
          near.send(isEvent ? message.replace('"kind":"simulated"', '"kind":"board"') : message);
        });
      });
      // The page that commanded so far gives way.
      if (!page.isClosed()) await page.close();
      await visit(context, address, board);
      await command(board);
      assert.match(await text(board, '#banner'), /A REAL MOTOR\s*it is off/);
      await predict(board, MOVES);
      await board.locator('#selftest-go').click();
      await board.locator('#confirm', { hasText: 'The self-test moves the joint' }).waitFor();
      await board.waitForTimeout(400);
      await state(board, 'stopped');
      await board.locator('#confirm-word').fill('arm');
      await board.locator('#confirm-word').press('Enter');
      await board.locator('#selftest-said', { hasText: 'Move 1 of 3' }).waitFor();
      await board.keyboard.press('Escape');
      await state(board, 'stopped');
      await board.locator('#selftest-said.failed', { hasText: 'ended by a stop' }).waitFor();
      // Gains that were turned can be set, until the device does not answer.
      await board.locator('[data-view=what-if]').click();
      await board.locator('[id="knob-controller.srnf.kp_v_per_deg"]').fill('600');
      await board.locator('#what-if-set:enabled').waitFor();
      isSilent = true;
      near.send(JSON.stringify({ event: 'gone', said: 'the device does not answer' }));
      await board.locator('#what-if-set:disabled').waitFor();
      isSilent = false;
      await board.locator('#what-if-set:enabled').waitFor();
      await board.close();
    },
  };
};
