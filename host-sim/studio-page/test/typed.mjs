// Tests of what is typed, and of a small window.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

// The table by which the program tests its own parser.
const CASES = JSON.parse(
  readFileSync(join(import.meta.dirname, '../../files/src/typed_number_cases.json'), 'utf8'),
);

const VIEWS = ['live', 'planes', 'parameters', 'what-if', 'commissioning', 'session', 'faults'];

export const typed = ({ state, text, said }) => ({
  async 'a typed number is read as the program reads it, and shown before it is sent'(page) {
    for (const { typed, reads, refused } of CASES) {
      await page.locator('#deg').fill(typed);
      const shown = await text(page, '#deg-read');
      if (refused === undefined) assert.match(shown, new RegExp(`^= ${reads} deg(:|$)`), typed);
      else assert.equal(shown, `✕ ${refused}`, typed);
    }
  },

  async 'a decimal comma moves there, and what is ambiguous or too far is refused where it is typed'(
    page,
  ) {
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#deg').fill('4,5');
    assert.equal(await text(page, '#deg-read'), '= 4.5 deg');
    await page.locator('#deg').press('Enter');
    await said(page, 'moves to 4.5 deg');
    await page.locator('#deg').fill('99999');
    assert.equal(await text(page, '#deg-read'), '= 99999 deg: ✕ it must be -360 to 360 deg');
    await page.locator('#deg').press('Enter');
    await said(page, 'no limits of travel');
    await page.locator('summary', { hasText: 'Trajectory' }).click();
    const way = await page.locator('#trapezoid-way').inputValue();
    await page.locator('#trapezoid-way').fill('99999');
    await page.locator('#trapezoid button').click();
    await said(page, 'trajectory to 99999: the target is rejected');
    await page.locator('#trapezoid-way').fill(way);
    await page.locator('summary', { hasText: 'Trajectory' }).click();
    await page.locator('#deg').fill('1,234');
    await page.locator('#deg').press('Enter');
    await said(page, '`1,234` is ambiguous');
    await page.locator('#stop').click();
    await state(page, 'stopped');
    await page.locator('[data-view=parameters]').click();
    const row = page.locator('[data-path="limits.stall_s"]');
    await row.locator('input').fill('0,75');
    await row.locator('.marks', { hasText: 'read as 0.75' }).waitFor();
    await page.locator('#set').click();
    await page.locator('[data-path="limits.stall_s"].unsaved:not(.edited)').waitFor();
    assert.equal(await row.locator('input').inputValue(), '0.75');
    await page.locator('#undo').click();
    await page.locator('[data-path="limits.stall_s"]:not(.unsaved)').waitFor();
    await page.locator('#deg').fill('5');
    await page.locator('[data-view=live]').click();
  },

  async 'one move is one move'(page) {
    await page.locator('[data-view=commissioning]').click();
    await page.locator('#steps button', { hasText: 'Verify' }).click();
    await page.locator('#selftest-moves').fill('1');
    await page.locator('#selftest-predict').click();
    await said(page, '1 move: it must be a whole number');
    await page.locator('#selftest-moves').fill('20');
    // The server's number takes the place of what was typed, and of how that was read.
    await page.locator('#selftest-range').fill('4,5');
    const read = page.locator('#selftest-range + output');
    assert.equal(await read.textContent(), 'read as 4.5');
    await page.locator('#selftest-predict').click();
    await page.locator('#selftest-range + output:empty').waitFor({ state: 'attached' });
    assert.equal(await page.locator('#selftest-range').inputValue(), '4.5');
    const cancel = page.locator('#selftest-cancel');
    if (await cancel.isVisible()) await cancel.click();
    await page.locator('#selftest-range').fill('');
    await page.locator('#steps button').first().click();
    await page.locator('[data-view=live]').click();
  },

  // The keys show a view in the window, and not below it.
  async 'in a window of 800 by 600 every view is beside the commands'(page) {
    const before = page.viewportSize();
    await page.setViewportSize({ width: 800, height: 600 });
    for (const [place, view] of VIEWS.entries()) {
      await page.keyboard.press(String(place + 1));
      const [box, move] = await Promise.all(
        [`#${view}`, '#move'].map((where) => page.locator(where).boundingBox()),
      );
      assert.ok(box.y < 200 && box.x > move.x + move.width, `${view}: ${JSON.stringify(box)}`);
      assert.ok(move.y + move.height < 600, JSON.stringify(move));
      const isWide = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth);
      assert.ok(!isWide, `${view} is wider than the window`);
    }
    await page.setViewportSize(before);
    await page.keyboard.press('1');
  },
});
