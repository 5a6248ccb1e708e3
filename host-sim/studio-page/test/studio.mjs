// What the tests and the pictures have in common: a browser, a studio, a page of it.

import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const dist = join(import.meta.dirname, '../dist');

// A value behind an option, and whether an option is there.
export const after = (options, name) =>
  options.includes(name) ? options[options.indexOf(name) + 1] : null;

// Starts a browser by its name. With `isDist`, pages get their files from dist/.
export function launch(name, isDist = false) {
  const executablePath = execFileSync('which', [name], { encoding: 'utf8' }).trim();
  // A page that the test has put in place of the server's comes from no local address.
  const more = isDist ? ['--disable-features=LocalNetworkAccessChecks'] : [];
  return chromium.launch({ executablePath, args: ['--no-sandbox', ...more] });
}

// Gives a page the files of dist/ in the place of those that are built into the program.
export async function fromDist(page) {
  for (const name of ['main.js', 'page.css'])
    await page.route(`**/${name}`, (route) => route.fulfill({ path: join(dist, name) }));
  await page.route(/:\d+\/$/, (route) => route.fulfill({ path: join(dist, 'index.html') }));
}

// A file in a directory of its own.
export function file(name, text) {
  const path = join(mkdtempSync(join(tmpdir(), 'stiction-')), name);
  if (text !== undefined) writeFileSync(path, text);
  return path;
}

// The text of a built-in experiment.
export const shown = (program, machine) =>
  execFileSync(program, ['show', machine], { encoding: 'utf8' });

// Starts a studio. Its address comes with the first line that it prints.
export function serve(program, ...more) {
  const server = spawn(program, ['studio', '--no-open', ...more], {
    stdio: ['ignore', 'pipe', 'inherit'],
  });
  const address = new Promise((done, failed) => {
    let text = '';
    server.stdout.on('data', (piece) => {
      text += piece;
      if (text.includes('\n')) done(text.split('\n')[0]);
    });
    server.on('exit', (code) => failed(new Error(`the studio has ended with ${code}: ${text}`)));
  });
  // Who does not wait for the address sees that it has ended otherwise.
  address.catch(() => {});
  return { server, address };
}

// Opens a page, and keeps what goes wrong in it.
export async function open(context, address, { page, patience, isDist = false }) {
  page ??= await context.newPage();
  if (isDist) await fromDist(page);
  page.setDefaultTimeout(patience);
  page.mistakes = [];
  page.on('pageerror', (error) => page.mistakes.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && page.mistakes.push(message.text()));
  await page.goto(address);
  return page;
}

export const text = (page, where) => page.locator(where).innerText();
export const state = (page, wanted) => page.locator(`#state.${wanted}`).waitFor();

// Waits until this many more samples of the device have arrived. What the server sent before them
// has arrived as well.
export async function moreSamples(page, count) {
  const arrived = () => parseInt(document.getElementById('samples').textContent) || 0;
  const least = (await page.evaluate(arrived)) + count;
  await page.waitForFunction(
    (least) => parseInt(document.getElementById('samples').textContent) >= least,
    least,
  );
}

// Runs a test and prints its result.
export async function runTest(name, test) {
  try {
    await test();
    console.log(`ok      ${name}`);
    return true;
  } catch (error) {
    console.log(`FAILED  ${name}\n${error.stack}`);
    return false;
  }
}
