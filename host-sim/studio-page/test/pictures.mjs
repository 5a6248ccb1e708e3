// Makes the pictures of docs/pictures/: the studio, and an animation of one move under two laws.
//
//   node test/pictures.mjs STICTION CHROMIUM DIRECTORY [--dist]
//
// With --dist it takes the files of the page from dist/, as browser.mjs does.

import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { animation } from './animation.mjs';
import { file, launch, open, serve, shown } from './studio.mjs';

const [program, browserName, directory, ...options] = process.argv.slice(2);
const isDist = options.includes('--dist');
// Tall enough for the three panels, the table, the gains and the joint.
const [WIDE, TALL, LIVE] = [1200, 1220, 780];
// Of 1000: twice the inertia.
const TURNED = 667;
const PATIENCE = 30_000;
const [MACHINE, LAWS, DEG] = ['untuned-joints', ['pd', 'robust'], 2.5];

// The joint as it stands, without the variants of the file.
function joint() {
  const [text] = shown(program, MACHINE).split('[[variant]]');
  // A browser that takes a picture may be silent for longer than the default.
  return file('joint.toml', `${text}\n[limits]\nlink_timeout_s = 5\n`);
}

// The answer to the next prediction that the page asks for.
function nextPrediction(socket) {
  return new Promise((done) => {
    socket.on('framereceived', ({ payload }) => {
      if (typeof payload !== 'string') return;
      const event = JSON.parse(payload);
      if (event.event === 'predicted' && event.part === 'laws' && event.content.length === 2)
        done(event.content);
    });
  });
}

const { server, address } = serve(program, joint(), '--controller', 'robust');
const browser = await launch(browserName, isDist);
try {
  const context = await browser.newContext({
    viewport: { width: WIDE, height: TALL },
    colorScheme: 'light',
  });
  const page = await context.newPage();
  const connected = page.waitForEvent('websocket');
  await open(context, await address, { page, patience: PATIENCE, isDist });
  const predicted = nextPrediction(await connected);
  const shoot = (name) => page.screenshot({ path: join(directory, `${name}.png`) });
  const view = (name) => page.locator(`[data-view=${name}]`).click();
  await page.locator('#state.stopped').waitFor();
  await page.locator('#arm').click();
  await page.locator('#state.armed').waitFor();
  const move = async (deg) => {
    await page.locator('#deg').fill(String(deg));
    await page.locator('#deg').press('Enter');
    await page.waitForTimeout(3500);
    await page.locator('#deg').blur();
  };
  await move(5);
  await view('what-if');
  await page.locator('#what-if-cloud-said', { hasText: 'joints' }).waitFor();
  await page.locator('[id="knob-inertia"]').fill(String(TURNED));
  await page.waitForTimeout(2000);
  await shoot('studio-what-if');
  await page.locator('#what-if-reset').click();
  await page.waitForTimeout(1000);
  await page.setViewportSize({ width: WIDE, height: LIVE });
  await view('live');
  await move(DEG);
  await shoot('studio-live');
  await view('what-if');
  await page.locator('#stop').click();
  await page.locator('#state.stopped, #state.faulted').waitFor();
  if (await page.locator('#clear').isEnabled()) await page.locator('#clear').click();
  await page.locator('#state.stopped').waitFor();
  await page.locator('#what-if-way').selectOption('step');
  await page.locator('#what-if-deg').fill(String(DEG));
  await page.locator('#what-if-laws label', { hasText: /^ ?pd$/ }).click();
  const content = await predicted;
  const curves = LAWS.map((law) => content.find((one) => one.law === law));
  const svg = animation({
    laws: LAWS,
    curves,
    deg: DEG,
    until: 2.5,
    title: `A step of ${DEG} deg against stick-slip friction`,
    note: 'Simulated: the core of the firmware around a joint that sticks.',
  });
  writeFileSync(join(directory, 'stick-slip.svg'), svg);
  await view('parameters');
  await page.locator('#search').fill('');
  await page.locator('[data-path="limits.stall_s"] input').fill('-1');
  await page.locator('#set').click();
  await page.locator('.parameter.refused').waitFor();
  await page.waitForTimeout(300);
  await shoot('studio-parameters');
} finally {
  server.kill();
  await browser.close();
}
