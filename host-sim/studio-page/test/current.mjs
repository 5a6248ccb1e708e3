// The motor's current: a panel and a number of a device that measures it, with the target of its
// loop. 1 V is the current that 1 V causes through the resistance.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { file, moreSamples, open, serve, state, text } from './studio.mjs';

const SENSOR = '\n[current_sensor]\nfull_scale_a = 30.0\ninductance_h = 0.001255\n';

// Panels and numbers of a typical joint with these tables, while it is armed.
async function shown(program, context, effort, tables, options, picture) {
  const path = file('harmonic.toml');
  execFileSync(program, ['new', '--typical', 'harmonic', path]);
  // 21 periods of the PWM in a sample time of 1 ms.
  const toml = readFileSync(path, 'utf8')
    .replace('pwm_hz = 20000.0', 'pwm_hz = 21000.0')
    .replace('[loop]', `[loop]\neffort = "${effort}"`);
  writeFileSync(path, toml + tables);
  const { server, address } = serve(program, path, '--controller', 'robust');
  try {
    const page = await open(context, await address, options);
    await state(page, 'stopped');
    await page.locator('#arm').click();
    await state(page, 'armed');
    await page.locator('#deg').fill('20');
    await page.locator('#deg').press('Enter');
    await moreSamples(page, 50);
    if (picture) await page.screenshot({ path: picture });
    const [panels, now] = [await text(page, '#plots'), await text(page, '#now')];
    await page.locator('[data-view=session]').click();
    const [csv] = await Promise.all([page.waitForEvent('download'), page.locator('#csv').click()]);
    const columns = readFileSync(await csv.path(), 'utf8')
      .split('\n')[0]
      .split(',');
    const found = { panels, now, columns };
    await page.close();
    return found;
  } finally {
    server.kill();
  }
}

export async function current(program, context, options, picture) {
  const looped = await shown(program, context, 'current', SENSOR, options, picture);
  assert.match(looped.panels, /Motor current, A\s*measured[\s\S]*target/);
  assert.match(looped.now, /Motor current\s*-?[\d.]+ A/);
  assert.equal(looped.columns.at(-1), 'current_a');
  const sensed = await shown(program, context, 'voltage', SENSOR, options);
  assert.match(sensed.panels, /Motor current, A\s*measured/);
  assert.doesNotMatch(sensed.panels, /Motor current, A\s*measured[\s\S]*target/);
  const without = await shown(program, context, 'voltage', '', options);
  assert.doesNotMatch(without.panels + without.now, /Motor current/);
  assert.ok(!without.columns.includes('current_a'));
}
