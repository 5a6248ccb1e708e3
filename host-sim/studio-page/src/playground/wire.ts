// The playground's studio is in the page itself, in a worker (worker.ts). Which joint it has stands
// behind the `#` of the address, and another one begins the page anew. A file of somebody's own
// stays in this tab.

import simulator from 'playground:simulator';
import worker from 'playground:worker';
import { app, by, element } from '../app';
import { read } from '../parameters';
import type { Wire } from '../wire';

export const IN_PAGE = true;

// A name is that of a built-in experiment, or of a joint of `stiction new --typical`.
const JOINTS: [name: string, title: string][] = [
  ['step-response', 'The axis of the thesis'],
  ['harmonic', 'A harmonic drive'],
  ['gimbal', 'A geared gimbal'],
];
const OWN = 'own.toml';
const NOT_OPENED = '{"event":"not-opened"';
const FIRST_VIEW = 'what-if';
// A machine's file has less than half of it (document/mod.rs allows more).
const LARGEST = 256 * 1024;

export type Begin = { simulator: ArrayBuffer; machine: string; file: string | null };

export function connect(
  news: (data: string | ArrayBuffer) => void,
  cut: (why?: string) => void,
): Wire {
  const [joint, view = FIRST_VIEW] = address().split('/');
  const own = sessionStorage.getItem(OWN);
  const name =
    joint === OWN && own !== null ? OWN : (JOINTS.find(([one]) => one === joint) ?? JOINTS[0])[0];
  choose(name, own);
  document.querySelector<HTMLElement>(`[data-view="${CSS.escape(view)}"]`)?.click();

  const studio = begun();
  let ready = false;
  let over = false;
  // It does not start, or it has trapped: it answers nothing any more.
  const ended = (why: string) => {
    const said = `the simulation has ended: ${why}. Reload the page`;
    ready = false;
    over = true;
    studio.terminate();
    by('playground-said').textContent = `✕ ${said}`;
    cut(said);
  };
  studio.onmessage = ({ data }) => {
    if (typeof data !== 'string' || !data.startsWith(NOT_OPENED)) return news(data);
    by('playground-said').textContent = `✕ ${JSON.parse(data).said}`;
  };
  studio.onerror = ({ message }) => ended(message);
  studio.onmessageerror = () => ended('what it has told cannot be read');
  unpacked()
    .then((bytes) => {
      // It has ended before there was anything for it to do.
      if (over) return;
      const begin: Begin = { simulator: bytes, machine: name, file: name === OWN ? own : null };
      studio.postMessage(begin, [bytes]);
      ready = true;
    })
    .catch((error: Error) => ended(error.message));
  return {
    get open() {
      return ready;
    },
    send: (text) => studio.postMessage(text),
  };
}

// What stands behind the `#`; somebody may have typed anything there.
function address(): string {
  try {
    return decodeURIComponent(location.hash.slice(1));
  } catch {
    return '';
  }
}

function begun(): Worker {
  const script = URL.createObjectURL(new Blob([worker], { type: 'text/javascript' }));
  const studio = new Worker(script);
  URL.revokeObjectURL(script);
  return studio;
}

// Opens a file in a simulator of its own, and returns why it is refused. The joint in use goes on
// meanwhile, and stays if the file is refused.
async function refusal(file: string): Promise<string | null> {
  const simulator = await unpacked();
  const trial = begun();
  try {
    return await new Promise((done, failed) => {
      trial.onmessage = ({ data }) =>
        done(
          typeof data === 'string' && data.startsWith(NOT_OPENED) ? JSON.parse(data).said : null,
        );
      trial.onerror = ({ message }) => failed(new Error(message));
      const begin: Begin = { simulator, machine: OWN, file };
      trial.postMessage(begin, [simulator]);
    });
  } finally {
    trial.terminate();
  }
}

async function unpacked(): Promise<ArrayBuffer> {
  const packed = new Blob([simulator as BlobPart]).stream();
  return new Response(packed.pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
}

// Shows which joint it is, and lets somebody choose another one.
function choose(now: string, own: string | null): void {
  const all = own === null ? JOINTS : [...JOINTS, [OWN, 'My own file'] as const];
  const begin = (name: string) => {
    location.hash = `${name}/${app.view}`;
    location.reload();
  };
  const select = by<HTMLSelectElement>('playground-joint');
  select.replaceChildren(
    ...all.map(([value, textContent]) =>
      element('option', { value, textContent, selected: value === now }),
    ),
  );
  select.onchange = () => begin(select.value);
  read(
    by('playground-file'),
    async (text, name) => {
      const why = await refusal(text).catch((error: Error) => error.message);
      by('playground-said').textContent =
        why === null ? '' : `✕ ${name} is refused, and the joint in use stays: ${why}`;
      if (why !== null) return;
      sessionStorage.setItem(OWN, text);
      begin(OWN);
    },
    LARGEST,
  );
  by('playground').hidden = false;
}
