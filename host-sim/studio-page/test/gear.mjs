// The gear of a device with two encoders, which moves measure after an identification.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { appendFileSync, readFileSync } from 'node:fs';
import { file, open, serve, state, text } from './studio.mjs';

// The sequence takes two minutes, and the moves 22 s.
const TO_IDENTIFY = 300_000;
const [STIFFNESS, SLACK] = [4000, 0.15];
const GEAR = ['--stiffness', STIFFNESS, '--backlash', SLACK, '--counts-per-turn', 16384];

const shownPair = (words, name) => {
  const [, value, sd] = new RegExp(`${name} ([\\d.]+) ± ([\\d.]+)`).exec(words);
  return [Number(value), Number(sd)];
};

// Begins to identify the joint, in a studio of its own: other tests go on meanwhile.
export async function beginsGear(program, context, { patience, isDist }) {
  const path = file('harmonic.toml');
  execFileSync(program, ['new', '--typical', 'harmonic', path, ...GEAR.map(String)]);
  // Its page is in the background, and may be silent for longer.
  appendFileSync(path, '\n[limits]\nlink_timeout_s = 5\n');
  const { server, address } = serve(program, path);
  const page = await open(context, await address, { patience, isDist });
  await state(page, 'stopped');
  const identify = async () => {
    await page.locator('[data-view=commissioning]').click();
    await page.locator('#steps button', { hasText: 'Identify' }).click();
    await page.locator('#step-buttons button').click();
    await state(page, 'armed');
  };
  await identify();
  return { server, page, identify };
}

// A move is judged at the load, and its twist is predicted and measured.
async function whatIf(page, pictures) {
  await page.locator('#arm').click();
  await state(page, 'armed');
  await page.locator('#deg').fill('3');
  await page.locator('#deg').press('Enter');
  await page
    .locator('#now dd', { hasText: /^(2\.9|3\.0)\d+ deg$/ })
    .first()
    .waitFor();
  await page.locator('[data-view=what-if]').click();
  await page.locator('#what-if-way').selectOption('last');
  await page.locator('#what-if-table th', { hasText: 'At the load: within' }).waitFor();
  const twist = page.locator('#what-if-plots figure', { hasText: 'Motor less load, deg' });
  await twist.locator('canvas').waitFor();
  await page.locator('#what-if-plots .legend', { hasText: 'measured' }).waitFor();
  if (pictures) await page.screenshot({ path: `${pictures}/gear-what-if.png`, fullPage: true });
  await page.locator('#stop').click();
  await state(page, 'stopped');
}

// The result has the true gear, and so has the file; Escape ends the moves at once.
export async function gearIsFound({ page, identify }, pictures) {
  const said = page.locator('#identified-said');
  await said.filter({ hasText: /move [12] of 3/ }).waitFor({ timeout: TO_IDENTIFY });
  await state(page, 'armed');
  for (const id of ['#hold', '#step', '#arm', '.identify >> nth=0'])
    assert.ok(await page.locator(id).isDisabled(), id);
  if (pictures) await page.screenshot({ path: `${pictures}/gear-moves.png` });
  await said.filter({ hasText: 'Gear: ' }).waitFor({ timeout: TO_IDENTIFY });
  await state(page, 'stopped');
  const words = await said.innerText();
  for (const [name, truth] of [
    ['stiffness', STIFFNESS],
    ['slack', SLACK],
    ['ratio', 100_000],
  ]) {
    const [value, sd] = shownPair(words, name);
    assert.ok(Math.abs(value - truth) < 3 * sd && sd < 0.1 * truth, `${name} ${value} ± ${sd}`);
  }
  assert.match(await text(page, '#identified-words'), /gear +by moves with both encoders/);
  if (pictures) await page.screenshot({ path: `${pictures}/gear-found.png`, fullPage: true });
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.locator('#identified-save').click(),
  ]);
  const toml = readFileSync(await download.path(), 'utf8');
  const stiffness = Number(/stiffness_nm_per_rad = ([\d.]+)/.exec(toml)[1]);
  assert.ok(Math.abs(stiffness / STIFFNESS - 1) < 0.1, toml);
  assert.notEqual(stiffness, STIFFNESS, 'the value of the file before');
  await whatIf(page, pictures);
  await identify();
  await said.filter({ hasText: /move 1 of 3/ }).waitFor({ timeout: TO_IDENTIFY });
  await page.keyboard.press('Escape');
  await state(page, 'stopped');
  await said.filter({ hasText: 'the gear was not identified: its moves were ended' }).waitFor();
  assert.ok(await page.locator('#arm').isEnabled());
}
