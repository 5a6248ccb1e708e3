// Tests of the views that predict, compare and guide, and of what stands between a click and a real
// motor.

import assert from 'node:assert/strict';

export const views = ({ state, text, said, visit, command }) => ({
  async 'a slider changes what is predicted, and nothing else'(page) {
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#deg').fill('3');
    await page.locator('#deg').press('Enter');
    await page.waitForTimeout(2500);
    await page.locator('[data-view=what-if]').click();
    const rest = page.locator('#what-if-table tr').nth(1).locator('td').nth(1);
    await rest.waitFor();
    // The last move was made by a simulated joint, so it was as it is predicted.
    await page.locator('.legend', { hasText: 'measured' }).waitFor();
    await page.locator('.legend', { hasText: 'joints around it' }).waitFor();
    assert.match(await text(page, '#what-if-cloud-said'), /of 24 joints .* The worst has/);
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
    assert.ok(await page.locator('#what-if-set').isDisabled(), 'the joint is no gain');
    await slider.focus();
    await page.keyboard.press(' ');
    await state(page, 'stopped');
    await page.locator('#what-if-laws label', { hasText: /^ ?pd$/ }).click();
    await page.locator('#what-if-table td', { hasText: /^pd$/ }).waitFor();
    await page.locator('#what-if-reset').click();
  },

  async 'gains that were tried are set on the device, and taken back'(page) {
    await page.locator('[id="knob-controller.srnf.kp_v_per_deg"]').fill('600');
    await page.locator('#what-if-set').click();
    await said(page, 'controller.srnf.kp_v_per_deg: 1.0 ->');
    await page.locator('[data-view=parameters]').click();
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
    await page.locator('#compare-not').click();
    await page.locator('[data-view=live]').click();
  },

  async 'a trajectory is followed, and refused where the device refuses it'(page) {
    await page.locator('summary', { hasText: 'Trajectory' }).click();
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#trapezoid-speed').fill('0');
    await page.locator('#trapezoid button').click();
    await said(page, 'the speed has to be');
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
    const titles = await page.locator('#steps button').allInnerTexts();
    assert.equal(titles.length, 7);
    for (const [place] of titles.entries()) {
      await page.locator('#steps button').nth(place).click();
      assert.equal(await page.locator('#step-picture svg').count(), 1);
      assert.ok((await text(page, '#step-text')).length > 80);
    }
    await page.locator('#steps button', { hasText: 'Direction' }).click();
    await page.locator('#step-buttons button', { hasText: 'Jog' }).click();
    await said(page, 'jogs: a little each way');
    await said(page, 'the encoder counts in the sense');
    await page.locator('#steps button', { hasText: 'Limits' }).click();
    await page.locator('#step-buttons button').click();
    await page.locator('[data-path="limits.stall_s"]').waitFor();
    await page.locator('#search').fill('');
    await page.locator('[data-view=live]').click();
  },

  async 'a real motor is turned on after a word was typed only'(page, context, address) {
    const board = await context.newPage();
    // The same device, which says that it is a board.
    await board.routeWebSocket(/\/link/, (near) => {
      const far = near.connectToServer();
      far.onMessage((message) =>
        near.send(
          typeof message === 'string'
            ? message.replace('"kind":"simulated"', '"kind":"board"')
            : message,
        ),
      );
    });
    // The page that commanded so far gives way.
    await page.close();
    await visit(context, address, board);
    await command(board);
    assert.match(await text(board, '#banner'), /A REAL MOTOR\s*it is off/);
    for (const word of ['', 'yes']) {
      await board.locator('#arm').click();
      await board.locator('#confirm-word').fill(word);
      await board.locator('#confirm-word').press('Enter');
      await board.waitForTimeout(400);
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
    await board.keyboard.press('Escape');
    await state(board, 'stopped');
    assert.match(await text(board, '#banner'), /it is off/);
    await board.close();
  },
});
