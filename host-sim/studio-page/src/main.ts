// The page: it shows what the server tells and asks for what a person wants. It computes nothing of
// control.

import { banner } from './banner';
import { list as listFaults, remedy } from './faults';
import { Form } from './form';
import { History, type Hello } from './history';
import { listen } from './keys';
import { Link, type Event } from './link';
import { svg, png } from './picture';
import { Planes } from './planes';
import { Plots, shown } from './plots';
import { csv, download, open, save, stamp, type Kept } from './session';
import { errorCounts, panels, position, reference, type Read } from './terms';

const by = <T extends HTMLElement = HTMLElement>(id: string) => document.getElementById(id) as T;
const on = (id: string, what: () => void) => {
  by(id).onclick = what;
};

const MOST_SAID = 30;
const MOST_EVENTS = 500;

const history = new History();
let hello: Hello | null = null;
let status: Event | null = null;
let file: string | null = null;
let commands = false;
let connected = false;
let gone: string | null = null;
let recording = false;
let view = 'live';
let dirty = true;
let events: Kept[] = [];
let lastState = '';
let refusal = '';

const link = new Link(
  told,
  (frame) => {
    if (!recording) {
      history.frame(frame);
      dirty = true;
    }
  },
  () => {
    connected = false;
    commands = false;
    status = null;
    look();
  },
);
const plots = new Plots(by('plots'), history, windowMoved);
const planes = new Planes(by('plane-plots'), history);
const form = new Form(by('form'), () => {
  refusal = '';
  edited();
});

function told(event: Event): void {
  connected = true;
  switch (event.event) {
    case 'hello':
      hello = event as unknown as Hello;
      if (!recording && !history.goOn(hello)) begin(hello);
      note(`${hello.device}, firmware ${hello.firmware}`);
      break;
    case 'role':
      commands = event.commands;
      by('role').hidden = commands;
      by('role').querySelector('p')!.textContent = event.why
        ? `This page only looks: ${event.why}.`
        : '';
      break;
    case 'status':
      status = event;
      gone = null;
      if (event.state !== lastState)
        note(event.fault ? `${event.state}: ${event.fault.said}` : event.state);
      lastState = event.state;
      break;
    case 'parameters':
      file = event.file;
      form.told(event.rows);
      by<HTMLButtonElement>('undo').dataset.left = String(event.undo);
      edited();
      break;
    case 'faults':
      listFaults(by('fault-list'), event.faults);
      break;
    case 'found':
      said(event.said, true);
      break;
    case 'gone':
      gone = event.said;
      said(event.said, false);
      break;
    case 'back':
      gone = null;
      said('the device answers again', true);
      break;
    case 'skipped':
      note(`this page was too slow: ${event.messages} messages were left out`);
      break;
  }
  look();
}

// The plots begin anew: other signals, or another source of them.
function begin(of: Hello): void {
  history.reset(of);
  plots.build(panels(of));
  planes.build();
  plots.window = { length: Number(by<HTMLSelectElement>('span').value), end: null };
  windowMoved();
}

function note(what: string): void {
  const clock = history.length ? history.clock(history.length - 1) : 0;
  events.push({ at: new Date().toISOString(), clock, said: what });
  if (events.length > MOST_EVENTS) events.shift();
  if (view === 'session') listEvents();
}

function listEvents(): void {
  by('events').replaceChildren(
    ...events
      .slice(-100)
      .reverse()
      .map(({ at, said }) => {
        const item = document.createElement('li');
        item.append(
          Object.assign(document.createElement('time'), { textContent: at.slice(11, 19) }),
          ` ${said}`,
        );
        return item;
      }),
  );
}

function said(what: string, ok: boolean): void {
  const item = document.createElement('li');
  item.className = ok ? 'done' : 'refused';
  item.textContent = `${ok ? '✓' : '✕ Refused:'} ${what}`;
  by('said').prepend(item);
  while (by('said').childElementCount > MOST_SAID) by('said').lastElementChild!.remove();
  note(item.textContent);
}

async function ask(what: string, more: object = {}): Promise<boolean> {
  const answer = await link.ask(what, more);
  said(answer.said, answer.ok);
  return answer.ok;
}

function number(id: string): number | null {
  const typed = by<HTMLInputElement>(id).value.trim().replace(',', '.').replace('−', '-');
  const value = typed === '' ? NaN : Number(typed);
  if (Number.isFinite(value)) return value;
  said(`${by<HTMLInputElement>(id).value || 'nothing'}: allowed is a number, as in -2.5`, false);
  by(id).focus();
  return null;
}

function go(how: 'move' | 'step'): void {
  const deg = number('deg');
  if (deg !== null) void ask(how, { deg });
}

// Everything that depends on the state but not on the samples.
function look(): void {
  const driven = status?.driven ?? false;
  const [kind, what, more] = banner({ connected, gone, recording, hello, driven });
  by('banner').className = kind;
  by('banner-what').textContent = what;
  by('banner-more').textContent = more;
  document.title = `${what.toLowerCase()} – stiction studio`;
  by('device').textContent = hello
    ? `${hello.device}, firmware ${hello.firmware}, law: ${law(hello)}`
    : '';
  const words: Record<string, string> = {
    boot: 'it has just been switched on',
    stopped: 'the output is off',
    armed: 'the output is on',
    faulted: 'the output is off until the fault is cleared',
  };
  const state = recording ? 'recording' : (status?.state ?? 'unknown');
  by('state').className = state;
  by('state').replaceChildren(
    Object.assign(document.createElement('strong'), { textContent: state }),
    Object.assign(document.createElement('span'), {
      textContent: recording ? '' : (words[state] ?? ''),
    }),
  );
  if (!recording && status?.fault) {
    const fault = document.createElement('p');
    fault.textContent = `${status.fault.said}. ${remedy(status.fault)}`;
    by('state').append(fault);
  }
  if (!recording && status && status.link_timeout_s === 0) {
    by('state').append(
      Object.assign(document.createElement('p'), {
        textContent:
          '⚠ limits.link_timeout_s is off: only the studio stops the motor when this page is gone, and nothing does if the studio is gone.',
      }),
    );
  }
  const may = connected && commands && gone === null && !recording;
  const set = (id: string, enabled: boolean) => {
    by<HTMLButtonElement>(id).disabled = !enabled;
  };
  by<HTMLFieldSetElement>('actions').disabled = !may;
  set('arm', state === 'stopped');
  set('hold', driven);
  set('clear', state === 'faulted');
  set('jog', state === 'stopped');
  set('step', driven);
  for (const button of document.querySelectorAll<HTMLButtonElement>('#move button'))
    button.disabled = !driven;
  form.enable(may && !driven);
  set('undo', may && !driven && Number(by('undo').dataset.left) > 0);
  set('save', may && !driven && status?.unsaved === true);
  set('pull', file !== null);
  set('set', may && !driven && form.edits.size > 0);
  by<HTMLInputElement>('push').disabled = !may || driven;
  by('parameters-said').textContent = refusal
    ? `✕ Refused: ${refusal}`
    : recording
      ? 'A recording has no device to set.'
      : driven
        ? 'The output is on: stop first. Parameters are taken with the output off only.'
        : status?.unsaved
          ? 'Values in use are not saved: a reset forgets them.'
          : '';
  by('back').hidden = !recording;
  by('status').textContent = recording ? '' : (status?.text ?? '');
}

function law(of: Hello): string {
  const tables = form.rows
    .map((row) => row.table)
    .filter((table) => table.startsWith('controller.'));
  return (
    tables[0]?.slice('controller.'.length) ??
    (of.law.length ? 'with signals of its own' : 'not known')
  );
}

function edited(): void {
  const count = form.edits.size;
  by('set').textContent = count ? `Set ${count} ${count === 1 ? 'value' : 'values'}` : 'Set';
  by<HTMLButtonElement>('discard').disabled = count === 0;
  look();
}

function windowMoved(): void {
  const paused = plots.window.end !== null;
  by('pause').setAttribute('aria-pressed', String(paused));
  by('pause').textContent = paused ? 'Go on' : 'Pause';
  dirty = true;
}

function pause(): void {
  const span = Number(by<HTMLSelectElement>('span').value);
  plots.window =
    plots.window.end === null ? { ...plots.window, end: plots.now } : { length: span, end: null };
  windowMoved();
}

function pan(by: number): void {
  const { length, end } = plots.window;
  plots.window = { length, end: Math.min(plots.now, (end ?? plots.now) + by * length) };
  windowMoved();
}

function show(name: string): void {
  view = name;
  for (const tab of document.querySelectorAll<HTMLElement>('[role=tab]')) {
    const is = tab.dataset.view === name;
    tab.setAttribute('aria-selected', String(is));
    by(tab.dataset.view!).hidden = !is;
  }
  if (name === 'session') listEvents();
  dirty = true;
}

function readings(): void {
  const last = history.length - 1;
  const armed = last >= 0 && history.armed(last);
  const of = (value: Read, unit: string) =>
    armed ? `${shown(value(history)(last))} ${unit}` : '–';
  const rows: [string, string][] = [
    ['Position', of(position, 'deg')],
    ['Reference', of(reference, 'deg')],
    ['Error', of(errorCounts, 'counts')],
    ['Velocity', of((h) => h.reader('velocity_deg_per_s'), 'deg/s')],
    ['Effort', of((h) => h.reader('v_applied_v'), 'V')],
  ];
  by('now').replaceChildren(
    ...rows.flatMap(([name, value]) => [
      Object.assign(document.createElement('dt'), { textContent: name }),
      Object.assign(document.createElement('dd'), { textContent: value }),
    ]),
  );
  const lost = history.lost ? `${history.lost} lost in ${history.gaps.length} gaps` : 'none lost';
  by('samples').textContent = `${history.length} samples, ${lost}`;
  by('samples').title = `drawn ${rate.toFixed(0)} times a second`;
}

// Drawing takes a third of the time at most: the words that keep the link alive come first.
let drawn = 0;
let took = 0;
let rate = 0;
function frame(now: number): void {
  requestAnimationFrame(frame);
  if (!dirty || !history.hello || now - drawn < Math.max(30, 3 * took)) return;
  rate = 0.9 * rate + 100 / Math.max(1, now - drawn);
  drawn = now;
  dirty = false;
  readings();
  if (view === 'live') plots.draw();
  if (view === 'planes') planes.draw(plots.rows);
  took = performance.now() - now;
}

function read(input: HTMLInputElement, then: (text: string, name: string) => void): void {
  input.onchange = async () => {
    const chosen = input.files?.[0];
    input.value = '';
    if (chosen) then(await chosen.text(), chosen.name);
  };
}

listen(() => void ask('stop'), {
  a: () => by('arm').click(),
  h: () => by('hold').click(),
  c: () => by('clear').click(),
  p: pause,
  m: () => {
    by('deg').focus();
    by<HTMLInputElement>('deg').select();
  },
  ArrowLeft: () => pan(-0.25),
  ArrowRight: () => pan(0.25),
  ...Object.fromEntries(
    [...document.querySelectorAll<HTMLElement>('[role=tab]')].map((tab, place) => [
      String(place + 1),
      () => show(tab.dataset.view!),
    ]),
  ),
});

on('stop', () => void ask('stop'));
for (const what of ['arm', 'hold', 'clear', 'jog', 'undo', 'save']) on(what, () => void ask(what));
on('command', () => void link.ask('command'));
on('step', () => go('step'));
by('move').onsubmit = (event) => {
  event.preventDefault();
  go('move');
};
by('identify').onsubmit = (event) => {
  event.preventDefault();
  const [rate, hold] = [number('rate'), number('holding')];
  if (rate !== null && hold !== null) void ask('identify', { rate, hold });
};
for (const nudge of document.querySelectorAll<HTMLElement>('[data-by]')) {
  nudge.onclick = () => {
    const last = history.length - 1;
    const from = last >= 0 ? reference(history)(last) : 0;
    const deg = Number((from + Number(nudge.dataset.by)).toFixed(6));
    by<HTMLInputElement>('deg').value = String(deg);
    void ask('move', { deg });
  };
}
for (const tab of document.querySelectorAll<HTMLElement>('[role=tab]'))
  tab.onclick = () => show(tab.dataset.view!);
on('pause', pause);
on('earlier', () => pan(-0.5));
on('later', () => pan(0.5));
by('span').onchange = () => {
  plots.window = { length: Number(by<HTMLSelectElement>('span').value), end: plots.window.end };
  windowMoved();
};
by('search').oninput = by('only-changed').onchange = () =>
  form.find(by<HTMLInputElement>('search').value, by<HTMLInputElement>('only-changed').checked);
on('discard', () => {
  refusal = '';
  form.edits.clear();
  form.told(form.rows);
  edited();
});
on('set', async () => {
  const answer = await link.ask('set', { values: Object.fromEntries(form.edits) });
  said(answer.said, answer.ok);
  if (answer.ok) form.edits.clear();
  refusal = answer.ok ? '' : answer.said;
  if (answer.ok) form.told(form.rows);
  form.blame(refusal);
  edited();
});
by('form').onsubmit = (event) => {
  event.preventDefault();
  by('set').click();
};
on('pull', () => {
  if (file) download(new Blob([file], { type: 'application/toml' }), `stiction-${stamp()}.toml`);
});
read(by('push'), (text) => void ask('push', { text }));
on('keep', () => {
  if (history.hello)
    download(save(history, { hello: history.hello, file, events }), `stiction-${stamp()}.jsonl`);
});
read(by('open'), (text, name) => {
  try {
    const session = open(text, history);
    recording = true;
    events = session.events;
    plots.build(panels(session.hello));
    planes.build();
    const length = history.length ? history.time(history.length - 1) - history.time(0) : 10;
    plots.window = { length: Math.max(0.1, length), end: plots.now };
    windowMoved();
    said(`opened ${name}: ${history.length} samples of ${session.hello.device}`, true);
    show('live');
  } catch (error) {
    said(`${name}: ${(error as Error).message}`, false);
    if (hello && !recording) begin(hello);
  }
  look();
});
on('back', () => {
  recording = false;
  events = [];
  if (hello) begin(hello);
  look();
});
const title = () => `${history.hello?.device ?? ''} – ${history.hello?.warning ?? 'measured'}`;
on('csv', () => download(csv(history, plots.rows), `stiction-${stamp()}.csv`));
on('png', async () => {
  const picture = await png(plots, title());
  if (picture) download(picture, `stiction-${stamp()}.png`);
});
on('svg', () => download(svg(plots, title()), `stiction-${stamp()}.svg`));
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  if (!history.hello) return;
  plots.build(panels(history.hello));
  planes.build();
  dirty = true;
});

link.connect();
look();
requestAnimationFrame(frame);
