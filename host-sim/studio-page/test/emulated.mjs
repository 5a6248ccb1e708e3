// The flash image on the emulated microcontroller, driven by the page. It runs slower than a part
// does where the computer is busy, so there is patience, and the moves are short.

import assert from 'node:assert/strict';
import { moreSamples } from './studio.mjs';

const PATIENCE = 120_000;

export async function emulated({ state, text, said, visit, command }, context, address) {
  const page = await visit(context, address);
  const wait = { timeout: PATIENCE };
  page.setDefaultTimeout(PATIENCE);
  const says = /EMULATED MICROCONTROLLER\s*the flash image .*: no motor$/;
  assert.match(await text(page, '#banner'), says);
  await page.locator('#arm').click();
  await state(page, 'armed');
  await page.locator('#deg').fill('0.5');
  await page.locator('#deg').press('Enter');
  await said(page, 'moves to 0.5 deg');
  await page
    .locator('#now dd', { hasText: /^0\.(49|50)\d* deg$/ })
    .nth(0)
    .waitFor(wait);
  await moreSamples(page, 50);
  assert.match(await text(page, '#samples'), /^\d+ samples, none lost$/);
  assert.match(await text(page, '#banner'), says);
  await page.keyboard.press('Escape');
  await state(page, 'stopped');
  // A tab that is closed ends by the link timeout of the image.
  const other = await visit(context, address);
  other.setDefaultTimeout(PATIENCE);
  await page.locator('#arm').click();
  await state(other, 'armed');
  await page.close();
  await state(other, 'faulted');
  assert.match(await text(other, '#state'), /fault 22/);
  await command(other);
  await other.locator('#clear').click();
  await state(other, 'stopped');
  assert.deepEqual([...page.mistakes, ...other.mistakes], []);
  await other.close();
}
