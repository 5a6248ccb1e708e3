// The page: it shows the server's messages and sends the user's requests. It computes no control.

import { app, by, element, history, live, may, on } from './app';
import { banner } from './banner';
import { Commissioning } from './commissioning';
import { list as listFaults, remedy } from './faults';
import type { Hello } from './history';
import { IdentifiedView } from './identified';
import { keep } from './keep';
import { listen } from './keys';
import { Link, type Event } from './link';
import { forget, motions } from './motions';
import { Parameters } from './parameters';
import { Planes } from './planes';
import { Plots, shown } from './plots';
import { count as counted } from './count';
import { fields, PositionField } from './field';
import { ask, reportGraded, listEvents, note, report } from './messages';
import { errorCounts, panels, position, reference, type Read } from './terms';
import { Selftest } from './selftest';
import { Tuning } from './tuning';
import { WhatIf } from './what-if';
import { IN_PAGE } from './wire';

// As in page.css.
const NARROW = 640;

let dirty = true;
let lastState = '';
let measuredGear = false;

const link = new Link(
  receive,
  (frame) => {
    const of = live();
    const { resets } = of;
    of.frame(frame);
    if (of.resets > resets) wasReset();
    dirty ||= !app.recording;
  },
  (why) => {
    app.connected = false;
    app.commands = false;
    app.status = null;
    if (why !== undefined) {
      app.gone = why;
      report(why, false);
    }
    forget();
    look();
  },
);
const plots = new Plots(by('plots'), history, windowMoved, span);
const planes = new Planes(by('plane-plots'), history, (thinned) => setText('thinned', thinned));
const parameters = new Parameters(link, look);
const whatIf = new WhatIf(link, (values) => parameters.set(values));
const tuning = new Tuning(link, (gains) => {
  const count = parameters.put(gains);
  show('parameters');
  return count;
});
const selftest = new Selftest(link);
const positionField = new PositionField();
fields();
const identified = new IdentifiedView();
const commissioning = new Commissioning((view, search) => {
  if (search !== undefined) {
    by<HTMLInputElement>('search').value = search;
    parameters.form.find(search, false);
  }
  show(view);
});

function receive(event: Event): void {
  app.connected = true;
  switch (event.event) {
    case 'hello': {
      // A page that was too slow receives the same `hello` again.
      const isNew = event.generation !== app.hello?.generation;
      app.hello = event as unknown as Hello;
      if (!live().goOn(app.hello)) begin(app.hello);
      if (isNew) note(`${app.hello.device}, firmware ${app.hello.firmware}`);
      break;
    }
    case 'role':
      app.commands = event.commands;
      by('role').hidden = app.commands;
      by('role').querySelector('p')!.textContent = event.why
        ? `This page can only watch: ${event.why}.`
        : '';
      break;
    case 'status':
      app.status = event;
      app.gone = null;
      if (event.state !== lastState)
        note(event.fault ? `${event.state}: ${event.fault.said}` : event.state);
      lastState = event.state;
      positionField.follow(event.targets_deg ?? null);
      if (event.gear) identified.progress(event.gear);
      break;
    case 'parameters':
      app.file = event.file;
      parameters.form.update(event.rows);
      by<HTMLButtonElement>('undo').dataset.left = String(event.undo);
      parameters.edited();
      break;
    case 'faults':
      listFaults(by('fault-list'), event.faults);
      break;
    case 'motion':
      moved(event);
      whatIf.moved();
      break;
    case 'what-if':
      by<HTMLButtonElement>('file-trajectory').hidden = !event.trajectory;
      whatIf.update(event);
      break;
    case 'identified':
      app.found = event;
      identified.show(event);
      tuning.whose();
      selftest.whose();
      whatIf.whose();
      break;
    case 'selftest':
      selftest.update(event);
      break;
    case 'tuning':
      tuning.update(event);
      break;
    case 'tuned':
      tuning.found(event);
      break;
    case 'predicted':
      whatIf.predicted(event);
      return;
    case 'found':
      reportGraded(event.said, event.grade);
      break;
    case 'gone':
      app.gone = event.said;
      app.status = null;
      forget();
      report(event.said, false);
      break;
    case 'back':
      app.gone = null;
      report('the device answers again', true);
      break;
    case 'skipped':
      note(`this page was too slow: ${counted(event.messages, 'message')} lost`);
      break;
  }
  look();
}

// Restarts the history for another device or other signals.
function begin(of: Hello): void {
  const old = live();
  if (old.length > 0) report('the device sends other signals now: the plots restart', false, '⚠');
  old.reset(of);
  moved(null);
  if (!app.recording) redraw();
}

// Rebuilds the plots for other signals or another source.
function redraw(): void {
  plots.build(history.hello ? panels(history.hello) : []);
  planes.build();
  plots.window = { length: span(), end: null };
  windowMoved();
}

function moved(motion: Event | null): void {
  if (app.aside) app.aside.motion = motion;
  else app.motion = motion;
}

function wasReset(): void {
  moved(null);
  report('the device was reset. Earlier measurements stay, before a break', false, '⚠');
}

function span(): number {
  return Number(by<HTMLSelectElement>('span').value);
}

const WORDS: Record<string, string> = {
  boot: 'it was just switched on',
  stopped: 'the motor is off',
  armed: 'the motor is driven',
  faulted: 'the motor is off, and stays off',
};

// Meaning of the states for a joint without a motor.
const WITHOUT_MOTOR: Record<string, string> = {
  stopped: 'the loop is open',
  armed: 'the loop is closed',
  faulted: 'the loop is open, and stays open',
};

function meaning(state: string): string {
  const isBoard = IN_PAGE ? false : app.hello?.kind === 'board';
  const unknown = `the state of the ${isBoard ? 'motor' : 'device'} is unknown`;
  return (isBoard ? undefined : WITHOUT_MOTOR[state]) ?? WORDS[state] ?? unknown;
}

// A screen reader speaks every new text, so a text is set only if it has changed.
function setText(id: string, what: string): void {
  if (by(id).textContent !== what) by(id).textContent = what;
}

// Updates everything that depends on the state but not on the samples.
function look(): void {
  const { status, hello, recording } = app;
  // Unknown must not be taken for off.
  const driven: boolean | null = status?.driven ?? null;
  const [kind, what, more] = banner({ ...app, driven, inPage: IN_PAGE });
  by('banner').className = kind;
  setText('banner-what', what);
  setText('banner-more', more);
  // The last measurements are not present ones.
  const isStale = !recording && hello !== null && (!app.connected || app.gone !== null);
  document.body.classList.toggle('stale', isStale);
  by('stale').hidden = !isStale;
  document.title = `${what.toLowerCase()} – stiction studio`;
  by('device').textContent = hello
    ? `${hello.device}, firmware ${hello.firmware}, law: ${parameters.law}`
    : '';
  const state = status?.state ?? 'unknown';
  by('state').className = state;
  by('state').replaceChildren(
    element('strong', { textContent: state }),
    element('span', { textContent: meaning(state) }),
  );
  if (status?.fault)
    by('state').append(
      element('p', { textContent: `${status.fault.said}. ${remedy(status.fault)}` }),
    );
  if (status && status.link_timeout_s === 0)
    by('state').append(
      element('p', {
        textContent:
          '⚠ limits.link_timeout_s is off: when this page is gone, only the studio stops the motor; ' +
          'when the studio is gone, nothing stops it.',
      }),
    );
  by<HTMLFieldSetElement>('actions').disabled = !may();
  // While a self-test or moves for the gear move the joint, other motions are disabled.
  const isGuest = status?.guest === true;
  const measuresGear = Boolean(status?.gear);
  // Moves that have ended without a result, as those of a device that is gone.
  if (measuredGear && !measuresGear) identified.again();
  measuredGear = measuresGear;
  by('guest').hidden = !isGuest;
  const moves = driven === true && !app.testing && !measuresGear && !isGuest;
  for (const [id, enabled] of [
    ['arm', state === 'stopped' && !measuresGear],
    ['hold', moves],
    ['clear', state === 'faulted'],
    ['step', moves],
    ['file-trajectory', moves],
  ] as const)
    by<HTMLButtonElement>(id).disabled = !enabled;
  for (const button of document.querySelectorAll<HTMLButtonElement>(
    '#move button, #trapezoid button',
  ))
    button.disabled = !moves;
  for (const button of document.querySelectorAll<HTMLButtonElement>(
    '.jog, .identify, #ramp button, #reference button, #home button',
  ))
    button.disabled = state !== 'stopped' || measuresGear;
  if (state !== 'stopped') forget();
  parameters.enable(driven);
  whatIf.enable();
  tuning.prefer(parameters.law);
  tuning.enable();
  selftest.enable();
  commissioning.look();
  by('back').hidden = !recording;
  by('status').textContent = status?.text ?? '';
}

function windowMoved(): void {
  const paused = plots.window.end !== null;
  by('pause').setAttribute('aria-pressed', String(paused));
  by('pause').textContent = paused ? 'Continue' : 'Pause';
  dirty = true;
}

function pause(): void {
  plots.window =
    plots.window.end === null ? { ...plots.window, end: plots.now } : { length: span(), end: null };
  windowMoved();
}

function pan(by: number): void {
  const { length, end } = plots.window;
  plots.window = { length, end: Math.min(plots.now, (end ?? plots.now) + by * length) };
  windowMoved();
}

function show(name: string): void {
  app.view = name;
  for (const tab of document.querySelectorAll<HTMLElement>('[role=tab]')) {
    const is = tab.dataset.view === name;
    tab.setAttribute('aria-selected', String(is));
    by(tab.dataset.view!).hidden = !is;
  }
  if (name === 'session') listEvents();
  if (name === 'what-if') whatIf.open();
  // On a phone the view is below the commands.
  if (innerWidth < NARROW) document.querySelector('nav')!.scrollIntoView();
  // A long view starts at its top.
  else scrollTo(0, 0);
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
  if (history.hello?.signals.some(({ name }) => name === 'current_a'))
    rows.push(['Motor current', of((h) => h.reader('current_a'), 'A')]);
  by('now').replaceChildren(
    ...rows.flatMap(([name, value]) => [
      element('dt', { textContent: name }),
      element('dd', { textContent: value }),
    ]),
  );
  const { length, resets, gapCount: gaps } = history;
  const every = history.hello?.every ?? 1;
  by('samples').textContent = [
    counted(length, 'sample'),
    ...(every > 1 ? [`1 of ${every} ticks`] : []),
    history.lost ? `${history.lost} lost in ${gaps} ${gaps === 1 ? 'gap' : 'gaps'}` : 'none lost',
    ...(resets ? [`the device was reset ${resets === 1 ? 'once' : `${resets} times`}`] : []),
  ].join(', ');
}

// Drawing takes at most a third of the time: keep-alives come first.
let drawn = 0;
let took = 0;
let countedAt = 0;
let count = 0;
function frame(now: number): void {
  requestAnimationFrame(frame);
  if (!dirty || !history.hello || now - drawn < Math.max(30, 3 * took)) return;
  count++;
  if (now - countedAt >= 1000) {
    by('drawn').textContent =
      `drawn ${Math.round((1000 * count) / (now - countedAt))} times a second`;
    [countedAt, count] = [now, 0];
  }
  drawn = now;
  dirty = false;
  readings();
  if (app.view === 'live') plots.draw();
  if (app.view === 'planes') planes.draw(plots.rows);
  if (app.view === 'what-if') whatIf.draw();
  took = performance.now() - now;
}

const tabs = [...document.querySelectorAll<HTMLElement>('[role=tab]')];
listen(
  () => {
    forget();
    void ask(link, 'stop');
  },
  {
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
      tabs.map((tab, place) => [String(place + 1), () => show(tab.dataset.view!)]),
    ),
  },
);
for (const tab of tabs) tab.onclick = () => show(tab.dataset.view!);

on('stop', () => {
  forget();
  void ask(link, 'stop');
});
on('command', () => void link.ask('command'));
motions(link);
keep({ plots, look, show, redraw, windowMoved });
on('pause', pause);
on('earlier', () => pan(-0.5));
on('later', () => pan(0.5));
by('span').onchange = () => {
  plots.window = { length: span(), end: plots.window.end };
  windowMoved();
};
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  whatIf.repaint();
  if (!history.hello) return;
  plots.build(panels(history.hello));
  planes.build();
  dirty = true;
});

link.connect();
look();
requestAnimationFrame(frame);
