// Opens every page of the project's site in a headless Chromium, and fails if one reports an error,
// asks for a file that is not there, shows a picture that did not load, or is wider than the window.
//
//   node test/site.mjs STICTION CHROMIUM SITE [--pictures DIRECTORY]

import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, relative, resolve } from 'node:path';
import { after, launch } from './studio.mjs';

const [, browserName, directory, ...options] = process.argv.slice(2);
const pictures = after(options, '--pictures');
const site = resolve(directory);
const TYPES = {
  '.html': 'text/html',
  '.css': 'text/css',
  '.js': 'text/javascript',
  '.svg': 'image/svg+xml',
  '.png': 'image/png',
  '.wasm': 'application/wasm',
};

const server = createServer(({ url }, response) => {
  const path = join(site, decodeURIComponent(new URL(url, 'http://site').pathname));
  const file = existsSync(path) && statSync(path).isDirectory() ? join(path, 'index.html') : path;
  if (!existsSync(file)) return response.writeHead(404).end();
  response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream' });
  response.end(readFileSync(file));
});
await new Promise((ready) => server.listen(0, '127.0.0.1', ready));
const address = `http://127.0.0.1:${server.address().port}`;

function pages(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return ['api', 'playground'].includes(entry.name) ? [] : pages(path);
    return extname(path) === '.html' && entry.name !== 'toc.html' ? [relative(site, path)] : [];
  });
}

const browser = await launch(browserName);
const context = await browser.newContext({ viewport: { width: 1280, height: 900 } });
const mistakes = [];
const all = pages(site);
for (const name of all) {
  const page = await context.newPage();
  page.on('pageerror', (error) => mistakes.push(`${name}: ${error.message}`));
  page.on('console', (one) => one.type() === 'error' && mistakes.push(`${name}: ${one.text()}`));
  page.on('response', (one) => one.status() >= 400 && mistakes.push(`${name}: ${one.url()}`));
  await page.goto(`${address}/${name}`, { waitUntil: 'load' });
  const dark = await page.evaluate(() =>
    [...document.images].filter(({ naturalWidth }) => !naturalWidth).map(({ src }) => src),
  );
  mistakes.push(...dark.map((src) => `${name}: the picture ${src} did not load`));
  const wide = await page.evaluate(() => document.body.scrollWidth - innerWidth);
  if (wide > 0) mistakes.push(`${name}: ${wide} pixels wider than the window`);
  if (pictures) await page.screenshot({ path: join(pictures, `${name.replaceAll('/', '-')}.png`) });
  await page.close();
}
await browser.close();
server.close();
assert.deepEqual(mistakes, []);
assert.ok(all.length > 25, `${all.length} pages`);
console.log(`${all.length} pages opened without an error`);
