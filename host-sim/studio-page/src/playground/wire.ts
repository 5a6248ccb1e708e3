// Wire of the playground: its studio runs in a worker of the page (worker.ts). The `#` part of the
// address names the joint; another joint reloads the page. A file of the user stays in this tab.

import simulator from 'playground:simulator';
import worker from 'playground:worker';
import { app, by, element } from '../app';
import { read } from '../parameters';
import type { Wire } from '../wire';

export const IN_PAGE = true;

// Names of built-in experiments, or of joints of `stiction new --typical`.
const JOINTS: [name: string, title: string][] = [
  ['step-response', 'The axis of the thesis'],
  ['harmonic', 'A harmonic drive'],
  ['gimbal', 'A geared gimbal'],
];
const OWN = 'own.toml';
const NOT_OPENED = '{"event":"not-opened"';
const FIRST_VIEW = 'what-if';
// Largest file, bytes: a machine's file needs less than half (document/mod.rs allows more).
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
  // After a failed start or a trap the worker answers nothing.
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
  studio.onmessageerror = () => ended('its message cannot be read');
  unpacked()
    .then((bytes) => {
      // It has failed before its first message.
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

// Returns the `#` part of the address, which can be any text.
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

// Opens a file in a simulator of its own, and returns why it is refused. Until then, and after a
// refusal, the joint in use stays.
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

// Shows the joint, and lets the user choose another one.
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
