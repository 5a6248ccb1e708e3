// The playground keeps its joint when a file is refused. The page is the real one; a script replaces
// for its simulator, whose build takes minutes (playground.mjs drives that one).

import assert from 'node:assert/strict';
import { copyFileSync, mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';
import { build } from 'esbuild';

const page = join(import.meta.dirname, '..');

// It opens every file without the word "wrong".
const WORKER = `
  const send = (event) => postMessage(JSON.stringify(event));
  onmessage = ({ data }) => {
    if (typeof data === 'string') return;
    if (data.file?.includes('wrong')) return send({ event: 'not-opened', said: 'a key is wrong' });
    send({ event: 'role', commands: true, why: '' });
    send({ event: 'status', state: 'stopped', driven: false, text: data.machine, targets_deg: null });
  };`;

async function built() {
  const directory = mkdtempSync(join(tmpdir(), 'stiction-'));
  const parts = {
    name: 'playground',
    setup({ onResolve, onLoad }) {
      const wire = join(page, 'src/playground/wire.ts');
      onResolve({ filter: /^\.\/wire$/ }, () => ({ path: wire }));
      onResolve({ filter: /^playground:/ }, ({ path }) => ({ path, namespace: 'playground' }));
      onLoad({ filter: /simulator$/, namespace: 'playground' }, () => ({
        contents: gzipSync('no simulator'),
        loader: 'binary',
      }));
      onLoad({ filter: /worker$/, namespace: 'playground' }, () => ({
        contents: WORKER,
        loader: 'text',
      }));
    },
  };
  await build({
    bundle: true,
    target: 'es2022',
    entryPoints: [join(page, 'src/main.ts'), join(page, 'src/page.css')],
    outdir: directory,
    entryNames: '[name]',
    plugins: [parts],
    logLevel: 'error',
  });
  copyFileSync(join(page, 'src/index.html'), join(directory, 'index.html'));
  return pathToFileURL(join(directory, 'index.html')).href;
}

export async function refusedFile(context) {
  const address = await built();
  const page = await context.newPage();
  page.setDefaultTimeout(20_000);
  await page.goto(address);
  await page.locator('#state.stopped').waitFor();
  await page.evaluate(() => (globalThis.isSame = true));
  const choose = (text) =>
    page.locator('#playground-file').setInputFiles({
      name: 'mine.toml',
      mimeType: 'application/toml',
      buffer: Buffer.from(text),
    });
  await choose('wrong = 1');
  await page.locator('#playground-said', { hasText: 'a key is wrong' }).waitFor();
  const kept = () => page.evaluate(() => sessionStorage.getItem('own.toml'));
  assert.ok(await page.evaluate(() => globalThis.isSame), 'the page has begun anew');
  assert.equal(await kept(), null);
  assert.match(await page.locator('#state').innerText(), /stopped/i);
  await Promise.all([page.waitForEvent('load'), choose('right = 1')]);
  await page.locator('#state.stopped').waitFor();
  assert.equal(await kept(), 'right = 1');
  await page.close();
}
