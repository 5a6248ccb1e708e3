// Builds the playground: the page with the studio inside, as static files.
//
//   node playground.mjs SIMULATOR.wasm DIRECTORY
//
// The page is the same. Its wire connects to a worker instead of a server, and its script contains
// the simulator, so that the page can also be opened as a file.

import { copyFileSync, mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { build } from 'esbuild';

const [simulator, directory] = process.argv.slice(2);
const here = import.meta.dirname;
const common = {
  bundle: true,
  minify: true,
  target: 'es2022',
  charset: 'utf8',
  legalComments: 'eof',
};

const { outputFiles } = await build({
  ...common,
  entryPoints: [join(here, 'src/playground/worker.ts')],
  write: false,
});

const parts = {
  name: 'playground',
  setup({ onResolve, onLoad }) {
    onResolve({ filter: /^\.\/wire$/ }, () => ({ path: join(here, 'src/playground/wire.ts') }));
    onResolve({ filter: /^playground:/ }, ({ path }) => ({ path, namespace: 'playground' }));
    onLoad({ filter: /simulator$/, namespace: 'playground' }, () => ({
      contents: gzipSync(readFileSync(simulator), { level: 9 }),
      loader: 'binary',
    }));
    onLoad({ filter: /worker$/, namespace: 'playground' }, () => ({
      contents: outputFiles[0].text,
      loader: 'text',
    }));
  },
};
mkdirSync(directory, { recursive: true });
await build({
  ...common,
  entryPoints: [join(here, 'src/main.ts'), join(here, 'src/page.css')],
  outdir: directory,
  entryNames: '[name]',
  plugins: [parts],
});
copyFileSync(join(here, 'src/index.html'), join(directory, 'index.html'));
copyFileSync(join(here, '../../docs/reference/faults.md'), join(directory, 'faults.md'));
