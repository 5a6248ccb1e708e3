// A session as a file: a line of JSON with the device and its parameters, a line for each event,
// and lines of samples. Any program that reads JSON can read it.

import { Breath } from './breath';
import { History, type Hello } from './history';
import { position, reference } from './terms';

export type SessionEvent = { at: string; clock: number; said: string };
export type Session = {
  saved: string | null;
  hello: Hello;
  file: string | null;
  events: SessionEvent[];
};

const LINE = 200;
// Number of rows after which the elapsed time is checked.
export const PIECE = 500;

export async function save(of: History, session: Session): Promise<Blob> {
  const breath = new Breath();
  const { events, ...about } = session;
  const lines = [JSON.stringify({ stiction_session: 1, ...about })];
  for (const event of events) lines.push(JSON.stringify({ event }));
  for (let row = 0; row < of.length; row += LINE) {
    const samples = [];
    for (let i = row; i < Math.min(row + LINE, of.length); i++) samples.push(of.raw(i));
    lines.push(JSON.stringify({ samples }));
    await breath.take();
  }
  return new Blob(
    lines.map((line) => `${line}\n`),
    { type: 'application/jsonl' },
  );
}

// Reads a session, all of it or nothing.
export async function open(text: string): Promise<[Session, History]> {
  const breath = new Breath();
  const into = new History();
  const [first, ...lines] = text.split('\n').filter((line) => line.trim());
  const head = read(first ?? '') ?? {};
  if (head.stiction_session !== 1 || !head.hello)
    throw new Error('this file is not a session of stiction studio');
  const columns = head.hello.signals?.length;
  if (!columns) throw new Error('this session does not name the signals of its samples');
  if (!isWhole(head.hello))
    throw new Error('this session does not describe its device in the form of the studio');
  into.reset(head.hello);
  const events: SessionEvent[] = [];
  for (const line of lines) {
    const { event, samples = [] } = read(line) ?? {};
    if (!Array.isArray(samples))
      throw new Error('the samples of this session are not in the form of the studio');
    if (event) {
      if (!isText(event.at, event.said) || !isNumber(event.clock))
        throw new Error('an event of this session is not in the form of the studio');
      events.push(event);
    }
    for (const sample of samples) {
      if (!Array.isArray(sample) || sample.length !== 2 + columns)
        throw new Error('a sample of this session has other signals than the session names');
      // NaN is written as null; number and clock are always numbers.
      const [number, clock, ...values] = sample;
      const are = values.every((value) => value === null || isNumber(value));
      if (!isNumber(number, clock) || !are)
        throw new Error('a sample of this session has a value that is not a number');
      into.push(sample[0], sample[1], (column) => sample[2 + column]);
    }
    await breath.take();
  }
  const { saved = null, hello, file = null } = head;
  return [{ saved, hello, file, events }, into];
}

const isText = (...all: unknown[]) => all.every((one) => typeof one === 'string');
const isNumber = (...all: unknown[]) => all.every((one) => typeof one === 'number');

// Returns whether the description of a device has all that the page reads.
function isWhole(of: any): of is Hello {
  return (
    isText(of.device, of.firmware, of.program, of.kind) &&
    Array.isArray(of.law) &&
    isText(...of.law) &&
    isNumber(of.sample_time_s, of.resolution_deg, of.every) &&
    of.sample_time_s > 0 &&
    Array.isArray(of.signals) &&
    of.signals.every(
      (one: any) => isText(one?.name, one?.unit) && ['number', 'whole', 'bits'].includes(one.form),
    )
  );
}

function read(line: string): any {
  try {
    return JSON.parse(line);
  } catch {
    throw new Error('this file is not a session of stiction studio, or it was cut off');
  }
}

// Writes the columns of `stiction device ... log`. A tick without the loop has its time, and empty
// cells, since its other signals are not measured.
export async function csv(of: History, [first, end]: [number, number]): Promise<Blob> {
  const breath = new Breath();
  // A device with a sensor of the motor's current sends it.
  const current = of.hello!.signals.map(({ name }) => name).filter((name) => name === 'current_a');
  const more = [...of.hello!.law, ...current];
  const head = [
    'time_s',
    'reference_deg',
    'position_deg',
    'error_deg',
    'velocity_deg_per_s',
    'v_pd_v',
    'v_c_v',
    'v_v',
    'code',
    'stuck',
    'v_applied_v',
    ...more,
  ];
  const pieces = [head.join(',') + '\n'];
  const begin = first < end ? of.time(first) : 0;
  const [lead, place, armed] = [reference(of), position(of), of.arming()];
  const empty = ','.repeat(head.length - 1);
  for (let row = first; row < end; row++) {
    const value = (name: string) => of.value(name, row);
    const time = +(of.time(row) - begin).toFixed(6);
    if (row % PIECE === 0) await breath.take();
    if (!armed(row)) {
      pieces.push(`${time}${empty}\n`);
      continue;
    }
    pieces.push(
      [
        time,
        lead(row),
        place(row),
        value('error_deg'),
        value('velocity_deg_per_s'),
        value('v_pd_v'),
        value('v_c_v'),
        value('v_v'),
        value('code'),
        // As in such a log: the measured velocity is zero.
        value('velocity_deg_per_s') === 0,
        value('v_applied_v'),
        ...more.map(value),
      ].join(',') + '\n',
    );
  }
  return new Blob(pieces, { type: 'text/csv' });
}

export function download(blob: Blob, name: string): void {
  const link = Object.assign(document.createElement('a'), {
    href: URL.createObjectURL(blob),
    download: name,
  });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export function stamp(): string {
  return new Date().toISOString().slice(0, 19).replace(/[T:]/g, '-');
}
