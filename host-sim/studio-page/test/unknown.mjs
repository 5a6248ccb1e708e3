// Tests of what the page says where something is missing: a status, samples, the time of a device
// that was reset.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';

// A page whose news go through `changed` on their way; null leaves one out. `ways` are its
// connections.
async function between(context, changed) {
  const [page, ways] = [await context.newPage(), []];
  await page.routeWebSocket(/\/link/, (near) => {
    const far = near.connectToServer();
    ways.push(near);
    far.onMessage((message) => {
      const news = changed(message);
      if (news !== null) near.send(news);
    });
  });
  return { page, ways };
}

async function download(page, id) {
  const [file] = await Promise.all([page.waitForEvent('download'), page.locator(id).click()]);
  return readFileSync(await file.path(), 'utf8');
}

export const unknown = ({ text, said, visit }) => ({
  async 'a status that is not known is not said to be off'(_page, context, address) {
    let isSilent = false;
    const { page, ways } = await between(context, (message) => {
      if (typeof message !== 'string') return message;
      const event = JSON.parse(message);
      if (isSilent && event.event === 'status') return null;
      if (event.event === 'hello') Object.assign(event, { kind: 'board', every: 3 });
      return JSON.stringify(event);
    });
    await visit(context, address, page);
    assert.match(await text(page, '#banner'), /● A REAL MOTOR\s/);
    // Not every tick is sent; the count of the samples shows that.
    await page.locator('#samples', { hasText: /^\d+ samples, 1 of 3 ticks, / }).waitFor();
    isSilent = true;
    await ways[0].close();
    await page.locator('#banner', { hasText: 'NO CONNECTION' }).waitFor();
    await page.locator('#banner', { hasText: '? A REAL MOTOR' }).waitFor();
    assert.match(await text(page, '#banner'), /it may be driven/);
    assert.equal(await page.locator('#banner').getAttribute('class'), 'unknown');
    assert.match(await text(page, '#state'), /^unknown/i);
    isSilent = false;
    await page.locator('#banner', { hasText: '● A REAL MOTOR' }).waitFor();
    await page.close();
  },

  async 'a page that hears that the device is gone does not know its status'(
    _page,
    context,
    address,
  ) {
    let isGone = false;
    const { page } = await between(context, (message) => {
      if (!isGone) return message;
      if (typeof message !== 'string' || JSON.parse(message).event !== 'status') return null;
      return JSON.stringify({ event: 'gone', said: 'the device does not answer' });
    });
    await visit(context, address, page);
    isGone = true;
    await page.locator('#banner', { hasText: 'THE DEVICE DOES NOT ANSWER' }).waitFor();
    assert.match(await text(page, '#state'), /^unknown/i);
    assert.equal(await text(page, '#status'), '');
    await page.close();
  },

  async 'a reset of the device is reported, and earlier samples stay'(_page, context, address) {
    let [isReset, zero] = [false, null];
    const { page } = await between(context, (message) => {
      if (!isReset || typeof message === 'string') return message;
      const words = new Uint32Array(new Uint8Array(message).buffer);
      const [, columns, rows] = words;
      zero ??= words.slice(4, 6);
      for (let row = 0; row < rows; row++) {
        words[4 + row * (2 + columns)] -= zero[0];
        words[5 + row * (2 + columns)] -= zero[1];
      }
      return Buffer.from(words.buffer);
    });
    await visit(context, address, page);
    const count = async () => parseInt(await text(page, '#samples'));
    await page.waitForFunction(() => parseInt(document.getElementById('samples').textContent) > 60);
    const before = await count();
    isReset = true;
    await said(page, 'the device was reset');
    await page
      .locator('#samples', { hasText: /^\d+ samples, none lost, the device was reset once$/ })
      .waitFor();
    assert.ok((await count()) >= before);
    await page.locator('[data-view=session]').click();
    const svg = await download(page, '#svg');
    assert.equal(svg.match(/class="reset"/g)?.length, svg.match(/font-weight="bold"/g).length);
    await page.close();
  },

  async 'gaps of a session, and the thinning of its planes, are shown'(_page, context, address) {
    const { page } = await between(context, (message) => message);
    await visit(context, address, page);
    await page.locator('[data-view=session]').click();
    const [head, ...lines] = (await download(page, '#keep')).trim().split('\n');
    const samples = lines.flatMap((line) => JSON.parse(line).samples ?? []);
    const status = JSON.parse(head).hello.signals.findIndex(({ name }) => name === 'status');
    const values = samples.at(-1).slice(2);
    values[status] = 2;
    const rows = (count, number, clock) =>
      Array.from({ length: count }, (_, i) => [number + i, clock + i, ...values]);
    // Numbers that begin anew without a gap, ten that are missing, two seconds that are missing
    // where they begin anew again, and a reset.
    const all = [
      ...rows(9000, 500, 70_000),
      ...rows(4000, 0, 79_000),
      ...rows(3000, 4010, 83_010),
      ...rows(2000, 0, 86_110),
      ...rows(2000, 2000, 5),
    ];
    const session = [head, JSON.stringify({ samples: all })].join('\n');
    await page.locator('#open').setInputFiles({
      name: 'gaps.jsonl',
      mimeType: 'text/plain',
      buffer: Buffer.from(session),
    });
    const wanted = '20000 samples, 110 lost in 2 gaps, the device was reset once';
    await page.locator('#samples', { hasText: wanted }).waitFor();
    assert.equal(await text(page, '#samples'), wanted);
    await page.locator('[data-view=planes]').click();
    await page.locator('#thinned', { hasText: 'Drawn is 1 of 4 samples.' }).waitFor();
    await page.locator('[data-view=session]').click();
    const svg = await download(page, '#svg');
    const panels = svg.match(/font-weight="bold"/g).length;
    assert.equal(svg.match(/class="gap"/g).length, 2 * panels);
    assert.equal(svg.match(/class="reset"/g).length, panels);
    // No line leads across one of them, as far as they are broader than the least width.
    const bands = [...svg.matchAll(/<rect x="([\d.]+)" y="\d+" width="([\d.]+)"/g)]
      .map(([, ...all]) => all.map(Number))
      .filter(([, width]) => width > 1.5);
    const curves = [...svg.matchAll(/ d="(M[^"HVh]+)"/g)].map(([, path]) => path);
    assert.ok(bands.length >= 2 * panels && curves.length >= panels);
    for (const line of curves.flatMap((path) => path.slice(1).split('M'))) {
      const [first, last] = [line, line.slice(line.lastIndexOf('L') + 1)].map(parseFloat);
      for (const [from, width] of bands) {
        const middle = from + width / 2;
        assert.ok(last < middle || first > middle, `${first} to ${last} across ${middle}`);
      }
    }
    // A double click shows as much as was chosen: two seconds of ticks of 20 ms.
    await page.locator('[data-view=live]').click();
    await page.locator('#span').selectOption('2');
    await page.locator('#plots .u-over').first().dblclick();
    await page.locator('[data-view=session]').click();
    const ticks = (await download(page, '#csv')).trim().split('\n').length - 1;
    assert.ok(ticks >= 100 && ticks <= 103, `${ticks}`);
    await page.close();
  },
});
