// Runs the studio (`host-sim/playground`, a program for WASI) in a worker of the page, and provides
// its environment: a file, a clock, standard input and output.
//
// The clock stands still while the program computes, and advances by each requested wait. So the
// program never blocks: it is called again once the page's clock has caught up. On a page that is
// busy or asleep the time of the device stops as well, and catches up only a little of it.

import { ConsoleStdout, Fd, File, PreopenDirectory, WASI } from '@bjorn3/browser_wasi_shim';
import type { Begin } from './wire';

const BETWEEN_MS = 12;
// Longest lag that is caught up, and longest computation without a pause.
const BEHIND_MS = 200;
const STRETCH_MS = 100;
// Start of the clock, ms: above 0, since the program subtracts times from it.
let clock = 1e6;
let origin = performance.now() - clock;

const page = self as unknown as {
  onmessage: (event: MessageEvent<Begin | string>) => void;
  postMessage(message: unknown, transfer?: Transferable[]): void;
};

const SUCCESS = 0;
const encoder = new TextEncoder();
const decoder = new TextDecoder();

// Standard input: requests of the page, a line each.
class Requests extends Fd {
  left = new Uint8Array();

  add(text: string): void {
    this.left = joined([this.left, encoder.encode(`${text}\n`)]);
  }

  fd_read(size: number) {
    const data = this.left.slice(0, size);
    this.left = this.left.slice(size);
    return { ret: SUCCESS, data };
  }
}

// Standard output: messages to the page, each with a kind, a length, and its bytes.
class News extends Fd {
  private pieces: Uint8Array[] = [];

  fd_write(data: Uint8Array) {
    this.pieces.push(data.slice());
    return { ret: SUCCESS, nwritten: data.length };
  }

  flush(): void {
    const all = joined(this.pieces);
    this.pieces = [];
    const view = new DataView(all.buffer);
    for (let at = 0; at < all.length;) {
      const [isText, length] = [all[at] === 't'.charCodeAt(0), view.getUint32(at + 1, true)];
      const content = all.slice(at + 5, at + 5 + length);
      at += 5 + length;
      if (isText) page.postMessage(decoder.decode(content));
      else page.postMessage(content.buffer, [content.buffer]);
    }
  }
}

function joined(pieces: Uint8Array[]): Uint8Array<ArrayBuffer> {
  const all = new Uint8Array(pieces.reduce((length, piece) => length + piece.length, 0));
  let at = 0;
  for (const piece of pieces) {
    all.set(piece, at);
    at += piece.length;
  }
  return all;
}

const requests = new Requests();
const news = new News();

async function begin({ simulator, machine, file }: Begin): Promise<void> {
  const files = new Map(file === null ? [] : [[machine, new File(encoder.encode(file))]]);
  const path = file === null ? machine : `/${machine}`;
  const errors = ConsoleStdout.lineBuffered((line) => console.error(line));
  const wasi = new WASI(
    ['playground', path],
    [],
    [requests, news, errors, new PreopenDirectory('/', files)],
    { debug: false },
  );
  const { instance } = await WebAssembly.instantiate(simulator, {
    wasi_snapshot_preview1: { ...wasi.wasiImport, ...time(() => memory()) },
  });
  const exports = instance.exports as {
    memory: WebAssembly.Memory;
    playground_open: () => number;
    playground_pass: () => void;
  };
  const memory = () => new DataView(exports.memory.buffer);
  wasi.initialize(instance as Parameters<WASI['initialize']>[0]);
  const opened = exports.playground_open();
  news.flush();
  if (opened) go(exports.playground_pass);
}

// Functions of WASI for the clock and for waiting (with the layouts of its specification).
function time(memory: () => DataView) {
  const NANOSECONDS = 1e6;
  const ABSOLUTE = 1;
  return {
    clock_time_get(_clock: number, _precision: bigint, to: number): number {
      memory().setBigUint64(to, BigInt(Math.round(clock * NANOSECONDS)), true);
      return SUCCESS;
    },
    // The program waits only for the clock, and for one time.
    poll_oneoff(subscription: number, event: number, _count: number, events: number): number {
      const view = memory();
      const wait = Number(view.getBigUint64(subscription + 24, true)) / NANOSECONDS;
      const isTime = view.getUint16(subscription + 40, true) === ABSOLUTE;
      clock = isTime ? Math.max(clock, wait) : clock + wait;
      view.setBigUint64(event, view.getBigUint64(subscription, true), true);
      view.setUint32(event + 8, 0, true);
      view.setUint32(events, 1, true);
      return SUCCESS;
    },
  };
}

function go(pass: () => void): void {
  const begin = performance.now();
  const now = begin - origin;
  if (now - clock > BEHIND_MS) origin += now - clock - BEHIND_MS;
  const until = Math.min(now, begin - origin);
  do {
    pass();
    news.flush();
  } while (clock < until && performance.now() - begin < STRETCH_MS);
  setTimeout(() => go(pass), Math.max(BETWEEN_MS, clock - (performance.now() - origin)));
}

page.onmessage = ({ data }) => {
  if (typeof data === 'string') return requests.add(data);
  begin(data).catch((error: Error) =>
    setTimeout(() => {
      throw error;
    }),
  );
};
