// Tests of what the steps of the commissioning do by themselves: tuning and the self-test.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { moreSamples, state, text } from './studio.mjs';

const MOVES = 3;
// An identification takes two minutes.
const TO_IDENTIFY = 240_000;

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
  // An earlier self-test can be repeated, so the button alone does not show the new prediction.
  await page.locator('#selftest-said', { hasText: `${moves} moves, within` }).waitFor();
  await page.locator('#selftest-go:enabled').waitFor();
};

// Begins to identify a joint, in a studio of its own: other tests go on meanwhile.
export async function begins(page) {
  await step(page, 'Identify');
  assert.ok(await page.locator('#identified-save').isHidden());
  await page.locator('#step-buttons button').click();
  await state(page, 'armed');
}

// The joint that was found is downloaded, tuned and tested with.
export async function isFound(page) {
  const name = 'gimbal.identified.toml';
  await page.locator('#identified-said', { hasText: name }).waitFor({ timeout: TO_IDENTIFY });
  assert.match(await text(page, '#identified-words'), /breakaway [^]*verdict +good/);
  const [called, toml] = await saved(page, '#identified-save');
  assert.equal(called, name);
  assert.match(toml, /^# SIMULATED DEVICE[^]*\[spread\]/);
  await page.locator('[data-view=what-if]').click();
  assert.equal(await text(page, '#what-if-file'), 'gimbal.toml');
  // What was turned of one joint is not turned of the other; a gain is.
  const turned = page.locator('#knobs output.turned');
  await page.locator('[id="knob-inertia"]').fill('667');
  await page.locator('#knobs .knob input').first().fill('667');
  assert.equal(await turned.count(), 2);
  await page.locator('#what-if-joint').selectOption('found');
  assert.equal(await text(page, '#what-if-file'), name);
  assert.equal(await turned.count(), 1);
  await page.locator('#what-if-cloud-said', { hasText: 'drawn from the [spread]' }).waitFor();
  await step(page, 'Tune');
  const offered = await page.locator('#tune-joint option').allInnerTexts();
  assert.deepEqual(offered, ['gimbal.toml', `${name}, identified`]);
  await page.locator('#tune-joint').selectOption('found');
  await page.locator('#tune-more summary').click();
  await page.locator('#tune-cases').fill('2');
  await page.locator('#tune-start').click();
  await page.locator('#tune-said', { hasText: /better/ }).waitFor();
  assert.match(
    await text(page, '#tune-result'),
    new RegExp(`the joint of ${name}, which was identified`),
  );
  await step(page, 'Verify');
  await page.locator('#selftest-joint').selectOption('found');
  await predict(page, 2);
  assert.match(await text(page, '#selftest-result'), new RegExp(`joints around that of ${name},`));
  await page.locator('#selftest-go').click();
  await page.locator('#selftest-said:is(.passed, .doubted)').waitFor();
  await state(page, 'stopped');
}

export const commissioning = ({ said, visit, command }) => {
  return {
    async 'gains are tuned by a click, cancelled by another, and put into the form'(page) {
      await step(page, 'Tune');
      await page.locator('#tune-law').selectOption('all of the file');
      await page.locator('#tune-start').click();
      await page.locator('#tune-said', { hasText: /law 1 of 7, for .* of joint\.toml/ }).waitFor();
      await page.locator('#tune-count', { hasText: /[1-9]\d* sets of gains tried/ }).waitFor();
      assert.equal(
        await page.locator('[role=status] #tune-count').count(),
        0,
        'a screen reader speaks it',
      );
      assert.ok(await page.locator('#tune-start').isDisabled(), 'one at a time');
      await page.locator('#tune-cancel').click();
      await page.locator('#tune-said', { hasText: 'cancelled' }).waitFor();
      // What the command refuses is refused here, in words without its options.
      await page.locator('#tune-law').selectOption('pd');
      await page.locator('#tune-more summary').click();
      for (const [field, typed, why] of [
        ['chatter_v_per_s', '0', 'limit chatter_v_per_s=0: must be a number above 0'],
        ['cases', '1001', '1001 joints: must be a number from 1 to 1000'],
        ['cases', '2.5', 'it must be a whole number'],
      ]) {
        const before = await page.locator(`#tune-${field}`).inputValue();
        await page.locator(`#tune-${field}`).fill(typed);
        await page.locator('#tune-start:enabled').click();
        await said(page, why);
        await page.locator(`#tune-${field}`).fill(before);
      }
      await page.locator('#tune-chatter_v_per_s').fill('1e3');
      // Gains of pd succeed on no joint with friction, and would not be offered.
      await page.locator('#tune-law').selectOption('ri');
      await page.locator('#tune-cases').fill('6');
      await page.locator('#tune-goal').selectOption('settle');
      await page.locator('#tune-start:enabled').click();
      await page
        .locator('#tune-said', { hasText: 'better gains were found' })
        .waitFor({ timeout: 120_000 });
      await page.locator('#tune-result', { hasText: 'The figures are of 18 joints' }).waitFor();
      assert.equal(await page.locator('#tune-result table').count(), 2);
      await page.locator('.pictures summary').click();
      // A function, and not its text: the page's policy lets no text be run as code, so a text is
      // refused from the second look on.
      await page.waitForFunction(() => {
        const pictures = [...document.querySelectorAll('.pictures img')];
        return pictures.length > 0 && pictures.every((one) => one.naturalWidth > 0);
      });
      const [name, toml] = await saved(page, '#tune-save');
      assert.equal(name, 'joint.tuned.toml');
      // The device runs another law, so the form has no such gains.
      const put = page.locator('#tune-result [data-law=ri]');
      assert.ok(await put.locator('p').isVisible());
      assert.ok(!(await put.locator('button').isVisible()));
      // The device takes the first law of a file: ri, with another gain.
      const ri = /(\[controller\.ri\][^[]*?kp_v_per_deg = )([0-9.]+)/;
      const [, , tuned] = ri.exec(toml);
      const first = toml
        .replace('["pd", "ri",', '["ri", "pd",')
        .replace(ri, (_, head) => `${head}1.25`);
      const buffer = Buffer.from(first);
      await page.locator('#push').setInputFiles({ name: 'a.toml', mimeType: 'text/plain', buffer });
      await put.locator('button').click();
      const row = page.locator('[data-path="controller.ri.kp_v_per_deg"].edited input');
      assert.equal(Number(await row.inputValue()), Number(tuned));
      // Nothing is set before the click.
      await page.locator('#set', { hasText: 'Set 1 value' }).click();
      await said(page, `controller.ri.kp_v_per_deg: 1.25 -> ${tuned}`);
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
      assert.match(
        await text(page, '#selftest-go'),
        /^2\. Make the 3 moves within 3\.2\d* deg, compared with the joint of joint\.toml$/,
      );
      await state(page, 'stopped');
      // The moves of an older prediction than the fields show are not made.
      await page.locator('#selftest-moves').fill('200');
      await page.locator('#selftest-go:disabled').waitFor();
      await page.locator('#selftest-why', { hasText: 'Predict with these fields' }).waitFor();
      await page.locator('#selftest-range').fill('1e6');
      await page.locator('#selftest-predict').click();
      await said(page, 'a range of 1000000 deg');
      assert.ok(await page.locator('#selftest-go').isDisabled(), 'after a refusal');
      await page.locator('#selftest-range').fill('');
      await page.locator('#selftest-predict').click();
      await page.locator('#selftest-cancel').click();
      await said(page, 'the prediction of the self-test is cancelled');
      assert.ok(await page.locator('#selftest-go').isDisabled(), 'after it was cancelled');
      await predict(page, MOVES);
      await page.locator('#selftest-go').click();
      await page.locator('#selftest-said', { hasText: 'Move 2 of 3' }).waitFor();
      await state(page, 'armed');
      for (const id of ['#hold', '#step', '#selftest-predict', '#selftest-go'])
        assert.ok(await page.locator(id).isDisabled(), id);
      await page.locator('#selftest-said:is(.passed, .doubted)').waitFor();
      await state(page, 'stopped');
      assert.match(
        await text(page, '#selftest-said'),
        /pass: the joint moves as its file predicts/,
      );
      const [name, json] = await saved(page, '#selftest-save');
      assert.match(name, /^selftest-.*\.json$/);
      const { schema, verdict, checks, moves } = JSON.parse(json);
      assert.deepEqual([schema, verdict, checks.length, moves.length], [1, 'pass', 8, MOVES]);
      assert.equal(await page.locator('#selftest-result table').first().locator('tr').count(), 9);
      await page.locator('[data-view=live]').click();
    },

    async 'a real motor makes a self-test after the word only, and a silent one is set nothing'(
      page,
      context,
      address,
    ) {
      const board = await context.newPage();
      let [near, isSilent, ready] = [null, false, null];
      await board.routeWebSocket(/\/link/, (one) => {
        near = one;
        const far = one.connectToServer();
        far.onMessage((message) => {
          if (isSilent) return;
          const isEvent = typeof message === 'string';
          if (isEvent && message.includes('"phase":"ready"')) ready = message;
          near.send(isEvent ? message.replace('"kind":"simulated"', '"kind":"board"') : message);
        });
      });
      // The page that commanded so far gives way.
      if (!page.isClosed()) await page.close();
      await visit(context, address, board);
      await command(board);
      assert.match(await text(board, '#banner'), /A REAL MOTOR\s*it is off/);
      await predict(board, MOVES);
      // A prediction that is sent again does not match the edited fields.
      await board.locator('#selftest-moves').fill('200');
      near.send(ready);
      await moreSamples(board, 15);
      assert.ok(
        await board.locator('#selftest-go').isDisabled(),
        'the repeated prediction can start',
      );
      assert.equal(await board.locator('#selftest-moves').inputValue(), '200');
      await predict(board, MOVES);
      await board.locator('#selftest-go').click();
      await board.locator('#confirm', { hasText: 'The self-test moves the joint' }).waitFor();
      await moreSamples(board, 20);
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
